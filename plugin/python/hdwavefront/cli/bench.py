# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront bench`."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from ..errors import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_OK, HdWavefrontError, UsageError
from . import bench_output, bench_peers
from .named_scenes import NAMES as _SCENES

_QUICK_SECONDS = 105.0
_QUICK_SCENE_SECONDS = 14.0
_WHOLE_SECONDS = 570.0
_SWEEPS = ("materials", "triangles", "instances", "lights", "resolution", "samples", "pool")
_MEGAKERNEL_SECONDS = "600"  # of compiling, at most; the scenes are to be compared, whatever it takes


def add_bench_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what",
        nargs="*",
        metavar="WHAT",
        help=f"scenes ({', '.join(_SCENES)}, or 'scenes' for the three), sweeps ({', '.join(_SWEEPS)}, or 'sweeps' for "
        "all), and USD files. Default: scenes and sweeps, as far as they go in ten minutes",
    )
    parser.add_argument("--quick", action="store_true", help="less of everything, within two minutes")
    parser.add_argument("--json", metavar="FILE", help="also write all figures to this file")
    parser.add_argument("--plots", metavar="FOLDER", help="also draw plots, PNG and SVG, into this folder (matplotlib)")
    parser.add_argument("--pictures", metavar="FOLDER", help="also write the scenes' pictures into this folder")
    parser.add_argument("--minutes", type=float, help="time that it may take (default: 9.5 without WHAT; else any)")
    parser.add_argument("--turns", type=int, help="turns of each mode (default: 5; quick: 2)")
    parser.add_argument("--seconds", type=float, help="seconds of a turn, at least (default: 2; quick: 0.7)")
    parser.add_argument(
        "--width", "-w", type=int, default=320, help="width of the scenes' images (default: %(default)s)"
    )
    parser.add_argument(
        "--samples", type=int, default=1, help="samples of the pictures compared (default: %(default)s)"
    )
    parser.add_argument(
        "--peer",
        action="append",
        choices=("mitsuba", "cycles", "embree"),
        default=[],
        help="in place of all that, the scenes against this renderer: 1 / (relMSE x CPU seconds), or with embree the "
        "rates of the camera's rays and of two diffuse bounces (of 'triangles', a million)",
    )
    parser.add_argument("--variant", default="scalar_rgb", help="Mitsuba's variant (default: %(default)s)")
    parser.add_argument("--peer-samples", type=int, default=16, help="samples of those pictures (default: %(default)s)")
    parser.add_argument("--device", default="", help="Vulkan device; as of record")


def _chosen(what: list[str]) -> tuple[list[str], list[str], list[str]]:
    scenes: list[str] = []
    sweeps: list[str] = []
    stages: list[str] = []
    for name in what or ["scenes", "sweeps"]:
        if name in _SCENES:
            scenes.append(name)
        elif name in _SWEEPS:
            sweeps.append(name)
        elif name == "scenes":
            scenes += _SCENES
        elif name == "sweeps":
            sweeps += _SWEEPS
        elif os.path.isfile(name):
            stages.append(name)
        else:
            known = ", ".join(["scenes", *_SCENES, "sweeps", *_SWEEPS])
            raise UsageError(f"'{name}' is no file, and none of {known}.")
    return scenes, sweeps, stages


def _check(args: argparse.Namespace) -> None:
    for name in ("minutes", "turns", "seconds", "width", "samples"):
        value = getattr(args, name)
        if value is not None and value <= 0:
            raise UsageError(f"--{name} is {value}; it must be more than 0.")
    bench_output.check(args)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _tasks(args: argparse.Namespace, scenes: list[str], stages: list[str]) -> dict[str, Any]:
    """Of workers, by the names that their results have."""
    from ..bench.worker import Task

    common: dict[str, Any] = {
        "width": args.width,
        "samples": args.samples,
        "device": args.device,
        "turns": args.turns or (2 if args.quick else 5),
        "seconds": args.seconds or (0.7 if args.quick else 2.0),
    }
    tasks = {}
    for name in scenes:
        picture = os.path.join(args.pictures, f"{name}.png") if args.pictures else ""
        tasks[name] = Task(scene=name, picture=picture, **common)
    for stage in stages:
        tasks[os.path.basename(stage)] = Task(stage=os.path.abspath(stage), **common)
    return tasks


def _measure_scenes(args: argparse.Namespace, tasks: dict[str, Any], clock: Any, report: dict[str, Any]) -> bool:
    """Fills the report's "scenes", and "notes" about what went missing. False where something failed."""
    from ..bench.runner import Outcome
    from ..bench.scene_bench import remarks, summary

    outcomes: dict[str, Outcome] = {}
    try:
        _run_scenes(args, tasks, clock, outcomes, report["notes"])
    finally:
        results = [summary(name, outcome) for name, outcome in outcomes.items()]
        report["scenes"] += [result for result in results if result is not None]
        _print_scenes(report)
    for name, outcome in outcomes.items():
        report["notes"] += remarks(name, outcome)
    print("".join(f"\n{note}" for note in report["notes"]), flush=True)
    missing = clock.left == float("inf") and len(report["scenes"]) < len(tasks)
    return not missing and not any(o.error or o.identical is False for o in outcomes.values())


def _run_scenes(
    args: argparse.Namespace, tasks: dict[str, Any], clock: Any, outcomes: dict[str, Any], notes: list[str]
) -> None:
    from ..bench.runner import run_side_by_side, run_task

    if not args.quick and len(tasks) > 1:
        task = next(iter(tasks.values()))
        run_side_by_side(tasks, clock, 4 * task.turns * task.seconds + 10, _say, outcomes)
        return
    for place, (name, task) in enumerate(tasks.items()):
        limit = _limit(clock.left, len(tasks) - place - 1, args.quick)
        if limit < 5:
            notes.append(f"{name}: left out: {clock.passed:.0f} s have passed")
            continue
        _say(f"{name} ...")
        outcomes[name] = run_task(task, limit)


def _limit(left: float, others: int, quick: bool) -> float:
    """Seconds of a scene, so that a slow compiler does not eat the others' time. In a hurry the first one gets its
    megakernel if any does, and the others are measured without."""
    if left == float("inf"):
        return 3600.0
    return left - _QUICK_SCENE_SECONDS * others if quick else left / (others + 1)


def _print_scenes(report: dict[str, Any]) -> None:
    from ..bench import tables

    scenes, machine = report["scenes"], report["machine"]
    if not scenes:
        return
    print("\n" + tables.scene_table(scenes, machine["isProcessor"]))
    print("\n" + tables.kernel_table(scenes, machine["copyBytesPerSecond"]))
    print("\n" + tables.start_table(scenes))
    for scene in scenes:
        print("\n" + tables.all_kernels(scene), flush=True)


def _measure_sweeps(args: argparse.Namespace, sweeps: list[str], clock: Any, report: dict[str, Any]) -> None:
    """Fills the report's "sweeps"."""
    from ..bench.sweeps import SWEEPS, run_sweep, text_of

    on_processor = report["machine"]["isProcessor"]
    os.environ["HDWAVEFRONT_MEGAKERNEL_SECONDS"] = "60"  # in sweeps it comes where it comes soon
    for name in sweeps:
        _say(f"{name} ...")
        rows = report["sweeps"][name] = []
        try:
            for row in run_sweep(SWEEPS[name], args.quick, args.device, clock, on_processor, print):
                rows.append(row)
        finally:
            if rows:
                print("\n" + text_of(SWEEPS[name], rows) + "\n", flush=True)


def bench(args: argparse.Namespace) -> int:
    from ..bench import machine as machines
    from ..bench.runner import Clock
    from ..stage import import_pxr

    scenes, sweeps, stages = _chosen(args.what)
    if args.peer:
        bench_peers.check(args, [*scenes, *stages], sweeps)
    _check(args)
    import_pxr()
    os.environ.setdefault("HDWAVEFRONT_MEGAKERNEL_SECONDS", _MEGAKERNEL_SECONDS)
    seconds = (
        args.minutes * 60 if args.minutes else _QUICK_SECONDS if args.quick else None if args.what else _WHOLE_SECONDS
    )
    clock = Clock(seconds)
    try:
        machine = machines.describe(args.device)
    except RuntimeError as error:
        raise HdWavefrontError(str(error)) from None
    print("\n".join(machines.lines(machine)), flush=True)
    report: dict[str, Any] = {"machine": machine, "scenes": [], "sweeps": {}, "peers": [], "notes": []}
    try:
        if args.peer:
            good = bench_peers.compare_peers(args, [*scenes, *stages], sweeps, clock, report)
        else:
            good = _measure_scenes(args, _tasks(args, scenes, stages), clock, report)
            _measure_sweeps(args, sweeps, clock, report)
        code = EXIT_OK if good else EXIT_FAILED
    except KeyboardInterrupt:
        report["notes"].append("interrupted: what had been measured by then")
        _say("\nhdwavefront: interrupted; what had been measured by then is kept")
        code = EXIT_INTERRUPTED
    report["seconds"] = clock.passed
    bench_output.write(args, report)
    return code
