# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront bench`."""

from __future__ import annotations

import argparse
import json
import os
import sys
from typing import Any

from ..errors import EXIT_FAILED, EXIT_OK, HdWavefrontError, UsageError
from .named_scenes import NAMES as _SCENES

_QUICK_SECONDS = 105.0
_QUICK_SCENE_SECONDS = 14.0
_WHOLE_SECONDS = 570.0
_SWEEPS = ("materials", "triangles", "instances", "lights", "resolution", "samples", "pool")
_RAY_TURNS = 9
_MILLION = "a million triangles"  # the sweep's step, for rays
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
    if args.plots:
        from ..bench import plots

        if not plots.available():
            raise HdWavefrontError("--plots needs matplotlib: pip install 'hdwavefront[bench]'")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _run_scenes(args: argparse.Namespace, tasks: dict[str, Any], clock: Any) -> tuple[list[dict[str, Any]], list[str]]:
    """Results, and remarks about what went missing."""
    from ..bench.runner import run_side_by_side, run_task
    from ..bench.scene_bench import brief, remarks, summary

    results: list[dict[str, Any]] = []
    notes: list[str] = []

    def take(name: str, outcome: Any) -> None:
        notes.extend(remarks(name, outcome))
        result = summary(name, outcome)
        if result is not None:
            results.append(result)
            _say(f"{name}: {brief(result)}")

    if not args.quick and len(tasks) > 1:
        turns = next(iter(tasks.values()))
        for name, outcome in run_side_by_side(tasks, clock, 4 * turns.turns * turns.seconds + 10, _say).items():
            take(name, outcome)
        return results, notes
    for place, (name, task) in enumerate(tasks.items()):
        limit = _limit(clock.left, len(tasks) - place - 1, args.quick)
        if limit < 5:
            notes.append(f"{name}: left out: {clock.passed:.0f} s have passed")
            continue
        _say(f"{name} ...")
        take(name, run_task(task, limit))
    return results, notes


def _limit(left: float, others: int, quick: bool) -> float:
    """Seconds of a scene, so that a slow compiler does not eat the others' time. In a hurry the first one gets its
    megakernel if any does, and the others are measured without."""
    if left == float("inf"):
        return 3600.0
    return left - _QUICK_SCENE_SECONDS * others if quick else left / (others + 1)


def bench(args: argparse.Namespace) -> int:
    from ..bench import machine as machines
    from ..bench import tables
    from ..bench.runner import Clock
    from ..bench.sweeps import SWEEPS, run_sweep, text_of
    from ..bench.worker import Task
    from ..stage import import_pxr

    scenes, sweeps, stages = _chosen(args.what)
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
    for folder in filter(None, (args.pictures, args.plots)):
        os.makedirs(folder, exist_ok=True)
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
    if args.peer:
        return _run_peers(args, [*scenes, *stages], "triangles" in sweeps, machine)
    results, notes = _run_scenes(args, tasks, clock)
    if results:
        print("\n" + tables.scene_table(results, machine["isProcessor"]))
        print("\n" + tables.kernel_table(results, machine["copyBytesPerSecond"]))
        print("\n" + tables.start_table(results))
        for result in results:
            print("\n" + tables.all_kernels(result))
    print("".join(f"\n{note}" for note in notes), flush=True)
    os.environ["HDWAVEFRONT_MEGAKERNEL_SECONDS"] = "60"  # in sweeps it comes where it comes soon
    sweep_rows = {}
    for name in sweeps:
        _say(f"{name} ...")
        rows = run_sweep(SWEEPS[name], args.quick, args.device, clock, machine["isProcessor"], print)
        sweep_rows[name] = rows
        if rows:
            print("\n" + text_of(SWEEPS[name], rows) + "\n", flush=True)
    everything = {"machine": machine, "scenes": results, "sweeps": sweep_rows, "seconds": clock.passed, "notes": notes}
    _write(args, everything)
    broken = any(r["identical"] is False for r in results) or (len(results) < len(tasks) and seconds is None)
    return EXIT_FAILED if broken else EXIT_OK


def _run_peers(args: argparse.Namespace, names: list[str], a_million: bool, machine: dict[str, Any]) -> int:
    import tempfile

    from ..bench.peers.compare import compare, compare_rays, why_absent
    from ..bench.scenes import SCENES, stage_scene, sweep_scene
    from ..bench.tables import peer_table

    rows, failed = [], False
    for peer in args.peer:
        absent = why_absent(peer)
        if absent:
            print(f"{peer} is not compared: {absent}.")
            continue
        for name in [*names, *([_MILLION] if peer == "embree" and a_million else [])]:
            _say(f"{name} by {peer} ...")
            with tempfile.TemporaryDirectory(prefix="hdwavefront-bench-") as folder:
                if name == _MILLION:
                    scene = sweep_scene(folder, "triangles", count=1_000_000)
                else:
                    scene = SCENES[name](folder) if name in SCENES else stage_scene(os.path.abspath(name))
                try:
                    if peer == "embree":
                        rows += compare_rays(scene, folder, args.width, args.turns or _RAY_TURNS, args.device)
                        continue
                    rows.append(compare(peer, scene, folder, args.width, args.peer_samples, args.device, args.variant))
                except HdWavefrontError as error:
                    failed = True
                    print(f"{name}: {error}")
    if rows:
        print("\n" + peer_table(rows))
    if args.json:
        _write(args, {"machine": machine, "peers": rows, "scenes": [], "sweeps": {}, "seconds": 0.0})
    return EXIT_FAILED if failed else EXIT_OK


def _write(args: argparse.Namespace, everything: dict[str, Any]) -> None:
    if args.json:
        try:
            with open(args.json, "w", encoding="utf-8") as file:
                json.dump(everything, file, indent=1)
                file.write("\n")
        except OSError as error:
            raise HdWavefrontError(f"The file {args.json} cannot be written: {error.strerror}") from None
    if args.plots:
        from ..bench import plots

        for path in plots.draw(args.plots, everything):
            print(f"Wrote {path}")
    print(f"{everything['seconds']:.0f} s in all")
