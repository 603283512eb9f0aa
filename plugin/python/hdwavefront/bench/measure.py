# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Steady-state rates of renders that take turns.

A contestant is a scene in an execution mode, on a device of its own. It renders one small picture first, which
compiles what it needs and can be compared; then it renders on and on, paused while others have their turn. A turn
begins and ends with a change of the counters, so that no submit counts in part.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import HdWavefrontError
from .scenes.builder import Scene

_FOREVER = 1 << 22  # samples: more than are rendered while anything is measured
_POLL = 0.01
_STALLED = 600.0  # seconds without a submit that end the benchmark: something hangs

# Kernels of the paper's table, by the names of ours. Everything else works on materials.
_GROUPS = {
    "logic": ("logic", "scan_buckets", "scatter", "reset_buckets", "light_sample", "escape"),
    "new path": ("new_path",),
    "rays": ("extension_ray", "shadow_ray"),
}
GROUPS = ("logic", "new path", "materials", "rays")


def group_of(kernel: str) -> str:
    return next((group for group, names in _GROUPS.items() if kernel in names), "materials")


@dataclass
class Reading:
    """What happened in one turn."""

    wall: float = 0.0
    cpu: float = 0.0  # of this process, all threads: on a software device, what the work cost
    paths: int = 0
    segments: int = 0
    rays: int = 0  # extension and shadow rays
    kernels: dict[str, tuple[float, int]] = field(default_factory=dict)  # name -> milliseconds, items

    @property
    def rate(self) -> float:
        """Mpaths/s."""
        return self.paths / max(self.wall, 1e-9) * 1e-6

    @property
    def cpu_rate(self) -> float:
        """Mpaths a second of one core; on software devices what counts where others use the machine too."""
        return self.paths / max(self.cpu, 1e-9) * 1e-6

    @property
    def milliseconds(self) -> float:
        return sum(ms for ms, _ in self.kernels.values())

    def milliseconds_of(self, group: str) -> float:
        return sum(ms for name, (ms, _) in self.kernels.items() if group_of(name) == group)


@dataclass
class Spread:
    """Median, and half the range between the quartiles."""

    median: float
    half_range: float

    @staticmethod
    def of(values: Sequence[float]) -> Spread:
        if len(values) < 2:
            return Spread(values[0] if values else 0.0, 0.0)
        low, _, high = statistics.quantiles(values, n=4, method="inclusive")
        return Spread(statistics.median(values), (high - low) / 2)

    def as_json(self) -> dict[str, float]:
        return {"median": self.median, "halfInterquartile": self.half_range}


class Unavailable(Exception):  # noqa: N818 - nothing is wrong: this scene has no such mode
    """The device does not render this scene in this mode; says why."""


class Contestant:
    """A scene, opened in a mode. Raises Unavailable where the scene renders in another one."""

    def __init__(
        self,
        scene: Scene,
        mode: str,
        *,
        width: int,
        samples: int = 1,
        device: str = "",
        settings: Mapping[str, Any] | None = None,
    ) -> None:
        from ..api import Render

        self.scene, self.mode = scene, mode
        self._settings = {**scene.settings, **(settings or {}), "executionMode": mode}
        begin = time.perf_counter()
        self.render = Render(scene.path, width=width, device=device, settings={**self._settings, "samples": samples})
        self.render.prepare()
        self.open_seconds = time.perf_counter() - begin
        begin, cpu = time.perf_counter(), time.process_time()
        self.render.start()
        self.render.wait()
        self.first_seconds, self.first_cpu = time.perf_counter() - begin, time.process_time() - cpu
        stats = self.render.stats()
        if stats["executionMode"] != mode:
            self.close()
            raise Unavailable(self._why_not())
        self.compile_seconds = compile_seconds(stats)
        self.first_path_seconds = float(stats["firstPathSeconds"])  # since the scene was committed
        self.picture: npt.NDArray[np.float32] = self.render.map("color")
        self.readings: list[Reading] = []
        self.whole: dict[str, float] = {}
        self._started = False

    def time_whole(self, samples: int) -> None:
        """A picture from its start to its end, of other random numbers than the first; with all kernels compiled."""
        begin, cpu = time.perf_counter(), time.process_time()
        self.render.start(samples=samples, seed=1)
        self.render.wait()
        self._started = False  # the render that turns go on with is gone
        self.whole = {
            "wholeSamples": samples,
            "wholeSeconds": time.perf_counter() - begin,
            "wholeCpuSeconds": time.process_time() - cpu,
        }

    def _why_not(self) -> str:
        said = [d.message for d in self.render.diagnostics if d.code.startswith("megakernel")]
        return said[0].split(" The picture")[0] if said else f"The scene does not render in {self.mode} mode."

    def turn(self, seconds: float) -> Reading:
        """Renders for at least so long, and pauses."""
        if self._started:
            self.render.resume()
        else:
            self.render.start(samples=_FOREVER)
            self._started = True
        # The first submits fill the pool or the pipeline of submits: not counted.
        self._tick()
        first = self._tick()
        while True:
            last = self._tick()
            if last.wall - first.wall >= seconds:
                break
        self.render.pause()
        self._settle()
        reading = _difference(first, last)
        self.readings.append(reading)
        return reading

    def _tick(self) -> Reading:
        """Waits for the counters to change."""
        before = _snapshot(self.render.stats())
        begin = time.perf_counter()
        while True:
            now = _snapshot(self.render.stats())
            if now.segments != before.segments:
                return now
            progress = self.render.progress
            if not progress["running"] or time.perf_counter() - begin > _STALLED:
                raise HdWavefrontError(f"The render of {self.scene.name} ended or hangs: {progress}.")
            time.sleep(_POLL)

    def _settle(self) -> None:
        """Until the submits that were under way are done."""
        last, quiet = -1, 0
        while quiet < 10:
            segments = self.render.stats()["segments"]
            quiet = quiet + 1 if segments == last else 0
            last = segments
            time.sleep(_POLL * 5)

    def stats(self) -> dict[str, Any]:
        return self.render.stats()

    def close(self) -> None:
        self.render.stop()
        del self.render.delegate  # and with it the device's memory

    def total(self) -> Reading:
        """All turns together."""
        sum_of = Reading()
        for r in self.readings:
            sum_of.wall, sum_of.cpu = sum_of.wall + r.wall, sum_of.cpu + r.cpu
            sum_of.paths, sum_of.segments, sum_of.rays = (
                sum_of.paths + r.paths,
                sum_of.segments + r.segments,
                sum_of.rays + r.rays,
            )
            for name, (ms, items) in r.kernels.items():
                old = sum_of.kernels.get(name, (0.0, 0))
                sum_of.kernels[name] = (old[0] + ms, old[1] + items)
        return sum_of


def compile_seconds(stats: Mapping[str, Any]) -> float:
    """What making kernels took, summed over kernels, threads apart."""
    parts = ("codeMilliseconds", "createMilliseconds", "firstDispatchMilliseconds")
    return sum(kernel[part] for kernel in stats["kernels"] for part in parts) * 1e-3


def _snapshot(stats: Mapping[str, Any]) -> Reading:
    return Reading(
        time.perf_counter(),
        time.process_time(),
        stats["paths"],
        stats["segments"],
        stats["extensionRays"] + stats["shadowRays"],
        {k["name"]: (k["milliseconds"], k["items"]) for k in stats["kernels"]},
    )


def _difference(a: Reading, b: Reading) -> Reading:
    kernels = {}
    for name, (ms, items) in b.kernels.items():
        before = a.kernels.get(name, (0.0, 0))
        if ms > before[0]:
            kernels[name] = (ms - before[0], items - before[1])
    return Reading(b.wall - a.wall, b.cpu - a.cpu, b.paths - a.paths, b.segments - a.segments, b.rays - a.rays, kernels)


def cores() -> int:
    return len(os.sched_getaffinity(0))
