# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Sweeps: one number grows, the rest stays. A step that would not fit into the memory or the time is left out, and a
line says so."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .measure import Spread
from .runner import Clock, Outcome, run_task
from .tables import number, table, with_spread
from .worker import Task


@dataclass(frozen=True)
class Step:
    """A row. `cost` is the work of making it ready, to foresee how long it takes from how long another one took."""

    label: str
    task: Task
    cost: float
    host_bytes: float = 0.0
    not_on_a_processor: str = ""  # why it is left out there


@dataclass(frozen=True)
class Sweep:
    name: str
    title: str
    steps: Callable[[bool, str], list[Step]]  # of quick, device
    columns: Sequence[tuple[str, Callable[[Mapping[str, Any]], str]]]
    note: str = ""
    axis: str = ""  # of the plot
    figure: str = "nanosecondsPerRay"  # of a row; with "Spread" after it, its spread
    figure_title: str = "ns of a core a ray"


def _task(device: str, modes: tuple[str, ...] = ("wavefront",), **values: Any) -> Task:
    return Task(modes=modes, device=device, turns=3, seconds=0.7, **values)


def _steps_of(kind: str, counts: Sequence[int], host_bytes: float) -> Callable[[bool, str], list[Step]]:
    def steps(quick: bool, device: str) -> list[Step]:
        chosen = counts[:2] if quick else counts
        return [
            Step(f"{n:,}", _task(device, sweep={"kind": kind, "count": n}), 2e5 + n, n * host_bytes) for n in chosen
        ]

    return steps


# Seen on lavapipe: a hundred kernels are as many as its driver holds in reasonable time and memory.
_MOST_TOPOLOGIES = 100


_TEXTURE_SIDE = 64  # texels of each material's own texture


def _material_steps(quick: bool, device: str) -> list[Step]:
    rows: list[tuple[int, ...]] = [(1, 1, 400), (16, 1, 400), (1000, 1, 400), (4, 4, 400)]
    if not quick:
        rows += [(1, 1, 400, _TEXTURE_SIDE), (1000, 1, 400, _TEXTURE_SIDE)]
        rows += [(16, 16, 400), (100, 100, 400), (1000, 100, 400), (1000, 1000, 400)]
        rows += [(16, 16, 100), (16, 16, 1000), (16, 16, 4000)]
    steps = []
    for count, topologies, operations, *texture in rows:
        modes = ("wavefront", "megakernel") if topologies <= 16 else ("wavefront",)
        sweep = {"kind": "materials", "count": count, "topologies": topologies, "operations": operations}
        if texture:
            sweep["texture"] = texture[0]
        too_many = f"more than {_MOST_TOPOLOGIES} distinct topologies" if topologies > _MOST_TOPOLOGIES else ""
        steps.append(
            Step(
                f"{count} x {operations}, {topologies} distinct{', textured' if texture else ''}",
                _task(device, modes, sweep=sweep),
                2 + topologies,
                not_on_a_processor=too_many,
            )
        )
    return steps


def _setting_steps(token: str, values: Sequence[int]) -> Callable[[bool, str], list[Step]]:
    def steps(quick: bool, device: str) -> list[Step]:
        chosen = values[:2] if quick else values
        return [Step(f"{v:,}", _task(device, scene="carpaint", settings={token: v}), 1.0) for v in chosen]

    return steps


def _resolution_steps(quick: bool, device: str) -> list[Step]:
    return [
        Step(f"{w} x {w * 9 // 16}", _task(device, scene="carpaint", width=w), 1.0)
        for w in ((160, 320) if quick else (160, 320, 640, 1280, 1920))
    ]


def _sample_steps(quick: bool, device: str) -> list[Step]:
    return [
        Step(f"{n}", _task(device, scene="carpaint", width=160, whole_samples=n), 1.0)
        for n in ((1, 4) if quick else (1, 4, 16, 64))
    ]


def _measured(key: str, mode: str = "") -> Callable[[Mapping[str, Any]], str]:
    """Of a row, or of a mode in it, with its spread."""

    def show(row: Mapping[str, Any]) -> str:
        values = row[mode] if mode else row
        return with_spread(values[key], values[f"{key}Spread"]) if values else "–"

    return show


_RATE = ("Mpaths/s", _measured("mpathsPerSecond", "wavefront"))
_RAY = ("ns a ray", _measured("nanosecondsPerRay"))
_SEGMENT = ("ns a segment", _measured("nanosecondsPerSegment"))
_OPEN = ("open s", lambda r: f"{r['wavefront']['openSeconds']:.2f}")
_COMPILE = ("compile s", lambda r: f"{r['wavefront']['compileSeconds']:.1f}")


def _gain(row: Mapping[str, Any]) -> str:
    return f"{row['gainInCpuTime'] * 100:+.0f} %" if row["gainInCpuTime"] is not None else "–"


SWEEPS = {
    s.name: s
    for s in (
        Sweep(
            "materials",
            "materials x operations",
            _material_steps,
            [
                _SEGMENT,
                ("ns a path in materials", _measured("nanosecondsPerMaterialItem")),
                _RATE,
                _COMPILE,
                ("mega Mpaths/s", _measured("mpathsPerSecond", "megakernel")),
                ("mega compile s", lambda r: number(r["megakernel"]["compileSeconds"]) if r["megakernel"] else "–"),
                ("gain in CPU time", _gain),
            ],
            "operations are those of fractal noise, 125 an octave; each topology has a kernel",
            "materials x operations, topologies",
            "nanosecondsPerSegment",
            "ns of a core a segment",
        ),
        Sweep(
            "triangles",
            "triangles of one mesh",
            _steps_of("triangles", (10**4, 10**5, 10**6, 10**7), 420.0),
            [
                _RAY,
                _SEGMENT,
                _RATE,
                ("bytes a triangle", lambda r: number(r["geometryBytes"] / r["uniqueTriangles"])),
                ("BVH s", lambda r: f"{r['bvhSeconds']:.2f}"),
                _OPEN,
            ],
            "an indexed mesh with smooth normals; bytes are those of geometry on the device",
            "triangles",
        ),
        Sweep(
            "instances",
            "instances of one mesh",
            _steps_of("instances", (1, 10, 10**2, 10**3, 10**4, 10**5, 10**6), 700.0),
            [
                _RAY,
                _SEGMENT,
                _RATE,
                ("bytes an instance", lambda r: number(r["bytesPerInstance"])),
                ("BVH s", lambda r: f"{r['bvhSeconds']:.2f}"),
                _OPEN,
            ],
            "bytes are those of geometry on the device, less those of a scene of one instance",
            "instances",
        ),
        Sweep(
            "lights",
            "sphere lights",
            _steps_of("lights", (1, 10, 100, 1000, 10**4), 3e4),
            [_SEGMENT, _RAY, _RATE, _OPEN],
            "",
            "lights",
            "nanosecondsPerSegment",
            "ns of a core a segment",
        ),
        Sweep(
            "resolution",
            "resolution (carpaint)",
            _resolution_steps,
            [_RATE, _SEGMENT],
            "",
            "pixels",
            "nanosecondsPerSegment",
            "ns of a core a segment",
        ),
        Sweep(
            "samples",
            "whole pictures of so many samples (carpaint, 160 x 90)",
            _sample_steps,
            [
                ("seconds", lambda r: number(r["wavefront"]["wholeSeconds"])),
                ("CPU ms a sample", lambda r: number(r["cpuMillisecondsPerSample"])),
            ],
            "from start to converged, kernels compiled before",
            "samples",
            "cpuMillisecondsPerSample",
            "CPU ms a sample",
        ),
        Sweep(
            "pool",
            "paths in the pool (carpaint)",
            _setting_steps("poolSize", (4096, 16384, 32768, 65536, 131072, 262144)),
            [_RATE, _SEGMENT],
            "",
            "paths",
            "nanosecondsPerSegment",
            "ns of a core a segment",
        ),
    )
}


def available_memory() -> float:
    try:
        with open("/proc/meminfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("MemAvailable"):
                    return float(line.split()[1]) * 1024
    except OSError:
        pass
    return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))


# Of a row: the kernels whose time counts (all: none is named), and what of a turn it is divided by.
_WORK = {
    "nanosecondsPerSegment": ("", "segments"),
    "nanosecondsPerRay": ("rays", "rays"),
    "nanosecondsPerMaterialItem": ("materials", "materialItems"),
}


def _nanoseconds(turns: Sequence[Mapping[str, Any]], on_processor: bool, group: str, count: str) -> Spread:
    """Of one core where the device is a processor, else of the device."""
    work = "cpu" if on_processor else "wall"
    return Spread.of([t[work] * 1e9 * (t["share"][group] if group else 1.0) / max(t[count], 1) for t in turns])


def row_of(step: Step, outcome: Outcome, on_processor: bool) -> dict[str, Any] | None:
    """What a table shows of a step."""
    from .scene_bench import summary

    row = summary(step.label, outcome)
    if row is None:
        return None
    wave = row["wavefront"]
    for result in filter(None, (wave, row["megakernel"])):
        of = row if result is wave else result
        for name, (group, count) in _WORK.items():
            spread = _nanoseconds(result["turns"], on_processor, group, count)
            of[name], of[f"{name}Spread"] = spread.median, spread.half_range
    if "wholeSamples" in wave:
        row["cpuMillisecondsPerSample"] = wave["wholeCpuSeconds"] * 1e3 / wave["wholeSamples"]
    row["geometryBytes"] = wave["memoryBytes"].get("geometry", 0)
    row["parameters"] = {**step.task.sweep, **step.task.settings, "width": step.task.width}
    return row


def run_sweep(
    sweep: Sweep, quick: bool, device: str, clock: Clock, on_processor: bool, say: Callable[[str], None]
) -> Iterator[dict[str, Any]]:
    """A row as soon as it is measured."""
    first: dict[str, Any] | None = None
    per_cost, fixed = 0.0, 8.0
    for step in sweep.steps(quick, device):
        foreseen = fixed + per_cost * step.cost
        if on_processor and step.not_on_a_processor:
            say(f"  {sweep.name} {step.label}: left out: {step.not_on_a_processor}")
            continue
        if step.host_bytes > 0.7 * available_memory():
            say(f"  {sweep.name} {step.label}: left out: it takes about {step.host_bytes / 2**30:.1f} GiB of memory")
            continue
        if foreseen > clock.left:
            say(
                f"  {sweep.name} {step.label}: left out: it would take about {foreseen:.0f} s, "
                f"{max(clock.left, 0):.0f} s are left"
            )
            continue
        outcome = run_task(step.task, min(clock.left, 900.0))
        row = row_of(step, outcome, on_processor)
        # Starting the process and the device costs the same each time.
        per_cost = max(outcome.seconds - fixed, 1.0) / step.cost
        if outcome.error or row is None:
            why = outcome.error or ("its time was over" if outcome.timed_out else "nothing was measured")
            say(f"  {sweep.name} {step.label}: no result: {why}")
            continue
        for mode, reason in outcome.why_not.items():
            say(f"  {sweep.name} {step.label}: no {mode}: {reason}")
        first = first or row
        count = max(row["instances"] - first["instances"], 1)
        row["bytesPerInstance"] = max(row["geometryBytes"] - first["geometryBytes"], 0) / count
        yield row


def text_of(sweep: Sweep, rows: Sequence[Mapping[str, Any]]) -> str:
    body = table(
        [sweep.title, *(title for title, _ in sweep.columns)],
        [[row["name"], *(show(row) for _, show in sweep.columns)] for row in rows],
    )
    return body + (f"\n({sweep.note})" if sweep.note else "")
