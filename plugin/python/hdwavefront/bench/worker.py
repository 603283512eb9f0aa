# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""One measurement in a process of its own: a scene, in one mode or in both, in turns. The process can be ended at any
time (compiling cannot be stopped otherwise), and its memory and caches are its own. Several may compile side by side
while only one measures: each waits where its task says so.

`python -m hdwavefront.bench.worker TASK` prints a line of JSON for each thing it knows: {"event": ..., ...}.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import tempfile
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from .measure import GROUPS, Contestant, Reading, Spread, Unavailable, cores
from .scenes import SCENES, stage_scene, sweep_scene
from .scenes.builder import Scene


@dataclass
class Task:
    scene: str = ""  # a name of SCENES, or
    stage: str = ""  # a USD file, or
    sweep: dict[str, Any] = field(default_factory=dict)  # arguments of sweep_scene
    modes: tuple[str, ...] = ("wavefront", "megakernel")
    width: int = 320
    samples: int = 1  # of the picture that is compared
    whole_samples: int = 0  # also time a whole picture of so many
    turns: int = 5
    seconds: float = 2.0  # of a turn, at least
    device: str = ""
    settings: dict[str, Any] = field(default_factory=dict)
    picture: str = ""  # a file to write the wavefront picture to
    waits: bool = False  # for a line from its starter before it opens the second mode, and before the turns

    @staticmethod
    def parse(text: str) -> Task:
        values = json.loads(text)
        return Task(**{**values, "modes": tuple(values["modes"])})

    def text(self) -> str:
        return json.dumps(asdict(self))


def _say(event: str, **values: Any) -> None:
    print(json.dumps({"event": event, **values}, default=float), flush=True)


def _await(task: Task) -> None:
    if task.waits:
        _say("waiting")
        sys.stdin.readline()


def _scene(task: Task, folder: str) -> Scene:
    if task.stage:
        return stage_scene(task.stage)
    return sweep_scene(folder, **task.sweep) if task.sweep else SCENES[task.scene](folder)


def _open(task: Task, scene: Scene, mode: str) -> Contestant | None:
    try:
        contestant = Contestant(
            scene, mode, width=task.width, samples=task.samples, device=task.device, settings=task.settings
        )
    except Unavailable as reason:
        _say("unavailable", mode=mode, why=str(reason))
        return None
    _say(
        "opened",
        mode=mode,
        openSeconds=contestant.open_seconds,
        firstPictureSeconds=contestant.first_seconds,
        firstPictureCpuSeconds=contestant.first_cpu,
        compileSeconds=contestant.compile_seconds,
    )
    return contestant


def _state_bytes(total: Reading, stats: dict[str, Any]) -> float:
    """Path state that is read and written for a segment, at most."""
    each = {k["name"]: k["stateBytesRead"] + k["stateBytesWritten"] for k in stats["kernels"]}
    moved = sum(each.get(name, 0) * items for name, (_, items) in total.kernels.items())
    return moved / max(total.segments, 1)


def result_of(contestant: Contestant) -> dict[str, Any]:
    """What the turns so far say."""
    readings, total, stats = contestant.readings, contestant.total(), contestant.stats()
    rates = Spread.of([r.rate for r in readings])
    cpu_rates = Spread.of([r.cpu_rate for r in readings])
    millions = max(total.segments, 1) * 1e-6
    everything = max(total.milliseconds, 1e-9)
    return {
        "mpathsPerSecond": rates.median,
        "mpathsPerSecondSpread": rates.half_range,
        "mpathsPerCpuSecond": cpu_rates.median,
        "mpathsPerCpuSecondSpread": cpu_rates.half_range,
        "mraysPerSecond": total.rays / max(total.wall, 1e-9) * 1e-6,
        "msegmentsPerSecond": total.segments / max(total.wall, 1e-9) * 1e-6,
        "segmentsPerPath": total.segments / max(total.paths, 1),
        "paths": total.paths,
        "segments": total.segments,
        "wallSeconds": total.wall,
        "cpuSeconds": total.cpu,
        "kernelMilliseconds": total.milliseconds,
        "stateBytesPerSegment": _state_bytes(total, stats),
        "millisecondsPerMillionSegments": {g: total.milliseconds_of(g) / millions for g in GROUPS},
        "share": {g: total.milliseconds_of(g) / everything for g in GROUPS},
        "kernels": [
            {"name": name, "milliseconds": ms, "items": items, "share": ms / everything}
            for name, (ms, items) in sorted(total.kernels.items(), key=lambda item: -item[1][0])
        ],
        # Of the picture that the last turn was in: what stood in line for each kernel.
        "queues": [dict(queue) for queue in stats["queues"] if queue["items"]],
        "turns": [_turn(r) for r in readings],
        "poolSize": stats["poolSize"],
        "openSeconds": contestant.open_seconds,
        "firstPathSeconds": contestant.first_path_seconds,
        "firstPictureSeconds": contestant.first_seconds,
        "firstPictureCpuSeconds": contestant.first_cpu,
        "compileSeconds": contestant.compile_seconds,
        "memoryBytes": dict(stats["memoryBytes"]),
        **contestant.whole,
    }


def _turn(r: Reading) -> dict[str, Any]:
    return {
        "wall": r.wall,
        "cpu": r.cpu,
        "paths": r.paths,
        "segments": r.segments,
        "rays": r.rays,
        "materialItems": sum(items for name, (_, items) in r.kernels.items() if name.startswith("material:")),
        "share": {g: r.milliseconds_of(g) / max(r.milliseconds, 1e-9) for g in GROUPS},
    }


def _facts(scene: Scene, contestant: Contestant) -> dict[str, Any]:
    """Of the scene; what is unique is the renderer's count, what is seen the scene's own."""
    stats = contestant.stats()
    return {
        "triangles": scene.triangles or stats["triangles"],
        "uniqueTriangles": stats["triangles"],
        "instances": scene.instances or stats["instances"],
        "materials": scene.materials or stats["materials"],
        "lights": stats["lights"],
        "topologies": len(stats["kernelSources"]),
        "width": contestant.render.size[0],
        "height": contestant.render.size[1],
        "bvhSeconds": stats["bvhSeconds"],
        "commitSeconds": stats["commitSeconds"],
        "hostPeakMemoryBytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
    }


def run(task: Task, folder: str) -> None:
    scene = _scene(task, folder)
    open_ones: dict[str, Contestant] = {}
    for mode in task.modes:
        if open_ones:
            _await(task)
        contestant = _open(task, scene, mode)
        if contestant is None:
            continue
        open_ones[mode] = contestant
        if mode == "wavefront" and task.picture:
            contestant.render.save(task.picture)
        # Does not count: counters come some submits late, and the first submits are of another length than later ones.
        contestant.turn(min(task.seconds, 0.5))
        contestant.readings.clear()
        # What there is if the other one compiles until the time is over.
        contestant.turn(min(task.seconds, 1.0))
        _say("result", mode=mode, scene=_facts(scene, contestant), result=result_of(contestant))
        contestant.readings.clear()
    pictures = [c.picture for c in open_ones.values()]
    if len(pictures) == 2:
        _say("compared", identical=bool(np.array_equal(pictures[0].view(np.uint32), pictures[1].view(np.uint32))))
    _await(task)
    if task.whole_samples:
        for contestant in open_ones.values():
            contestant.time_whole(task.whole_samples)
    for turn in range(task.turns):
        for mode in list(open_ones)[:: 1 if turn % 2 == 0 else -1]:
            open_ones[mode].turn(task.seconds)
        for mode, contestant in open_ones.items():
            _say("result", mode=mode, scene=_facts(scene, contestant), result=result_of(contestant))
    for contestant in open_ones.values():
        contestant.close()
    _say("done", cores=cores())


def main() -> int:
    with tempfile.TemporaryDirectory(prefix="hdwavefront-bench-") as folder:
        run(Task.parse(sys.argv[1]), folder)
    sys.stdout.flush()
    os._exit(0)  # nothing is left to do, and drivers take their time


if __name__ == "__main__":
    sys.exit(main())
