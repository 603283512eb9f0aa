# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Runs the lobes of bsdfs.def on the device: many (parameters, wo) configurations per dispatch.

A configuration is one parameter set of a lobe and one wo. Quadrature is over cells of about equal probability in a
chart of each hemisphere: (z, azimuth), or about a sharp peak (log of the angle to it, azimuth), so that mirrors,
grazing tails and cosine lobes are resolved alike. Cells are refined where the midpoint rule is uncertain.
"""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 2e-5  # error of a cell that is not refined further
CELL_POINTS = 8  # midpoints per cell and axis

_KERNEL = """
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_samplerless_texture_functions : require
layout(binding = 22) uniform utextureBuffer lobeTable;
#include "lib/bsdf/{file}.glsl"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kMode = 0;
layout(push_constant) uniform Push {{ uint count; uint perConfig; uint seed; }};
layout(binding = 0, std430) readonly buffer Params {{ vec4 params[]; }};
layout(binding = 1, std430) buffer Points {{ vec4 points[]; }};
layout(binding = 2, std430) buffer Result {{ vec4 result[]; }};
layout(binding = 3, std430) readonly buffer Views {{ vec4 views[]; }};
uvec3 pcg(uvec3 v) {{  // Jarzynski and Olano 2020, pcg3d
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  return v;
}}
void main() {{
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  uint config = kMode == 1 ? uint(points[i].w) : i / perConfig;
  vec4 a = params[config * 4], b = params[config * 4 + 1], c = params[config * 4 + 2], d = params[config * 4 + 3];
  vec3 wo = views[config].xyz;
  {struct} l = {name}Make(wo, {make});
  if (kMode == 0) {{
    vec3 u = vec3(pcg(uvec3(i, seed, 17u)) >> 8) * (1.0 / 16777216.0);
    vec3 wi = {name}Sample(l, wo, u);
    points[i] = vec4(wi, 0.0);
    result[i] = {name}Eval(l, wo, wi);
  }} else if (kMode == 1) {{
    result[i] = {name}Eval(l, wo, points[i].xyz);
  }} else {{
    points[i] = vec4({name}Albedo(l, wo), 0.0);
    result[i] = vec4({name}Throughput(l, wo), 0.0);
  }}
}}
"""


@dataclass(frozen=True)
class Lobe:
    """One row of bsdfs.def and what the tests know about it."""

    name: str
    file: str
    reciprocal: bool
    transmissive: bool
    make: str = ""  # arguments of fooMake, from the vec4s a, b, c, d
    sets: dict[str, list[float]] = field(default_factory=dict)  # up to 16 numbers: a, b, c, d

    def params(self, names: list[str]) -> np.ndarray:
        rows = np.zeros((len(names), 16), np.float32)
        for row, name in zip(rows, names, strict=True):
            row[: len(self.sets[name])] = self.sets[name]
        return rows


def rows() -> list[tuple[str, str, bool, bool]]:
    """(name, file, reciprocal, transmissive) of each row of bsdfs.def."""
    text = (ROOT / "wavefront" / "shared" / "bsdfs.def").read_text()
    found = re.findall(r'^WAVEFRONT_BSDF\((\w+), "(\w+)", (true|false), (true|false), "', text, re.M)
    assert len(found) == len(re.findall(r"^WAVEFRONT_BSDF\(", text, re.M)), "a row that this pattern does not read"
    return [(name, file, r == "true", t == "true") for name, file, r, t in found]


def direction(theta_degrees: float, phi_degrees: float, side: float = 1.0) -> np.ndarray:
    t, p = np.radians(theta_degrees), np.radians(phi_degrees)
    return np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), side * np.cos(t)], np.float64)


@functools.lru_cache(maxsize=64)
def source(lobe_name: str, file: str, make: str) -> str:
    struct = lobe_name[0].upper() + lobe_name[1:] + "Lobe"
    return _KERNEL.format(name=lobe_name, file=file, struct=struct, make=make)


@functools.lru_cache(maxsize=1)
def lobe_table(runner) -> dict[int, tuple[np.ndarray, str]]:
    """The table that the library was built with, for the binding `lobeTable`."""
    return {22: (np.frombuffer(runner._native.interface_table(), np.uint32), "rg32ui")}


class Device:
    """The three ways to ask a lobe. params: (configs, 16); wo: (configs, 3)."""

    def __init__(self, runner, lobe: Lobe):
        self.runner = runner
        self.lobe = lobe
        self.source = source(lobe.name, lobe.file, lobe.make)

    def _run(self, mode: int, params, wo, points: np.ndarray, per_config: int, seed: int = 0):
        count = len(points)
        views = np.zeros((len(wo), 4), np.float32)
        views[:, :3] = wo
        out = self.runner.run(
            self.source,
            {
                0: np.asarray(params, np.float32),
                1: points,
                2: np.zeros((count, 4), np.float32),
                3: views,
            },
            ((count + 63) // 64,),
            push=np.array([count, per_config, seed], np.uint32).tobytes(),
            spec={0: mode},
            texel=lobe_table(self.runner),
        )
        return out[1], out[2]

    def sample(self, params, wo, count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """`count` samples a configuration: wi (configs, count, 3), and eval there (configs, count, 4)."""
        points, result = self._run(0, params, wo, np.zeros((len(wo) * count, 4), np.float32), count, seed)
        return points[:, :3].reshape(len(wo), count, 3), result.reshape(len(wo), count, 4)

    def evaluate(self, params, wo, config: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """eval (n, 4) of configuration config[i] at wi[i]."""
        return self._run(1, params, wo, np.column_stack([wi, config]).astype(np.float32), 1)[1]

    def albedo(self, params, wo) -> tuple[np.ndarray, np.ndarray]:
        """albedo and throughput, (configs, 3) each."""
        albedo, through = self._run(2, params, wo, np.zeros((len(wo), 4), np.float32), 1)
        return albedo[:, :3], through[:, :3]


@dataclass(frozen=True)
class Chart:
    """Coordinates of one hemisphere (side +1 or -1): s along the rows of `frame`'s z, then azimuth about it.

    epsilon = 0: s = cosine to the axis. Else s = log(1 + angle / epsilon), for lobes of about that width.
    """

    side: float
    frame: np.ndarray
    epsilon: float

    @staticmethod
    def of(side: float, wi: np.ndarray) -> Chart:
        """The chart that suits samples wi (n, 3) of that side."""
        plain = Chart(side, np.diag([1.0, side, side]), 0.0)
        if len(wi) < 16:
            return plain
        axis = np.median(wi.astype(np.float64), 0)
        axis /= max(np.linalg.norm(axis), 1e-9)
        width = float(np.median(np.linalg.norm(wi - axis, axis=1)))
        # A wide lobe, or one that the horizon cuts: the horizon is an edge of the plain chart.
        if width > 0.2 or axis[2] * side < 4 * width:
            return plain
        x = np.cross(axis, [0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [1.0, 0.0, 0.0])
        x /= np.linalg.norm(x)
        return Chart(side, np.stack([x, np.cross(axis, x), axis]), max(width, 1e-5))

    def box(self) -> tuple[float, ...]:
        return (0.0, float(np.log1p(np.pi / self.epsilon)) if self.epsilon else 1.0, -np.pi, np.pi)

    def coordinates(self, wi: np.ndarray) -> np.ndarray:
        local = wi.astype(np.float64) @ self.frame.T
        radius = np.hypot(local[:, 0], local[:, 1])
        angle = np.arctan2(radius, local[:, 2])
        s = np.log1p(angle / self.epsilon) if self.epsilon else np.cos(angle)
        return np.stack([s, np.arctan2(local[:, 1], local[:, 0])], -1)


def partition(chart: Chart, train: np.ndarray, test: np.ndarray, depth: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells (n, 4) = (s0, s1, azimuth0, azimuth1) that cover the chart, and how many of `test` fall in each.

    Halved `depth` times at medians of `train`. Both are directions (n, 3) of the chart's side.
    """
    cells: list[tuple[float, ...]] = []
    counts: list[int] = []

    def cut(axis: int, at: float, box: tuple[float, ...], train: np.ndarray, test: np.ndarray, left: int) -> None:
        low, high = list(box), list(box)
        low[2 * axis + 1] = high[2 * axis] = at
        below, tested = train[:, axis] < at, test[:, axis] < at
        split(tuple(low), train[below], test[tested], left)
        split(tuple(high), train[~below], test[~tested], left)

    def split(box: tuple[float, ...], train: np.ndarray, test: np.ndarray, left: int) -> None:
        if left and len(train) >= 16:
            for axis in (0, 1):
                q10, q90 = np.quantile(train[:, axis], (0.1, 0.9))
                width, low, high = q90 - q10, *box[2 * axis : 2 * axis + 2]
                # A ridge that a grid over the cell could miss: first cut away what lies far from it.
                for at in (q10 - 2 * width, q90 + 2 * width) if width < 0.1 * (high - low) else ():
                    if low + 2 * width < at < high - 2 * width:
                        return cut(axis, at, box, train, test, left)
            axis = 0 if left % 2 else 1
            at = float(np.median(train[:, axis]))
            if box[2 * axis] < at < box[2 * axis + 1]:
                return cut(axis, at, box, train, test, left - 1)
        cells.append(box)
        counts.append(len(test))
        return None

    split(chart.box(), chart.coordinates(train), chart.coordinates(test), depth)
    return np.array(cells), np.array(counts)


@dataclass
class Cells:
    """Cells of all configurations: box (n, 4), its chart (an index), its configuration, and samples counted in it."""

    charts: list[Chart]
    box: np.ndarray
    chart: np.ndarray
    config: np.ndarray
    counts: np.ndarray

    @staticmethod
    def of(wi: np.ndarray, valid: np.ndarray, train: int, depth: int) -> Cells:
        """From samples wi (configs, n, 3): the first `train` of each shape the cells, the others are counted."""
        charts: list[Chart] = []
        parts = []
        for config, (w, ok) in enumerate(zip(wi, valid, strict=True)):
            for side in (-1.0, 1.0):
                here = ok & ((w[:, 2] < 0) == (side < 0))
                first, rest = w[:train][here[:train]], w[train:][here[train:]]
                charts.append(Chart.of(side, first))
                box, counts = partition(charts[-1], first, rest, depth)
                parts.append((box, np.full(len(box), len(charts) - 1), np.full(len(box), config), counts))
        return Cells(charts, *(np.concatenate(column) for column in zip(*parts, strict=True)))


def _cell_points(charts: list[Chart], box: np.ndarray, chart: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints (n, k, 3) of a grid in each cell, with a frame at its edges; solid angles (0 on the other side)."""
    m = np.concatenate([[1e-3], (np.arange(CELL_POINTS) + 0.5) / CELL_POINTS, [1 - 1e-3]])
    s = (box[:, None, 0] + (box[:, None, 1] - box[:, None, 0]) * m)[:, :, None]
    azimuth = (box[:, None, 2] + (box[:, None, 3] - box[:, None, 2]) * m)[:, None, :]
    epsilon = np.array([c.epsilon for c in charts])[chart][:, None, None]
    angle = np.where(epsilon > 0, epsilon * np.expm1(np.minimum(s, 50)), np.arccos(np.clip(s, -1, 1)))
    r, z = np.sin(angle), np.cos(angle)
    local = np.stack(np.broadcast_arrays(r * np.cos(azimuth), r * np.sin(azimuth), z), -1)
    points = np.einsum("nabi,nij->nabj", local, np.stack([c.frame for c in charts])[chart])
    jacobian = np.where(epsilon > 0, r * (angle + epsilon), 1.0)
    side = np.array([c.side for c in charts])[chart][:, None, None]
    area = ((box[:, 1] - box[:, 0]) * (box[:, 3] - box[:, 2]))[:, None, None]
    weights = area * jacobian * (points[..., 2] * side >= 0)
    return points.reshape(len(box), -1, 3), weights


def integrate(device: Device, params, wo, cells: Cells, rounds: int = 14) -> tuple[np.ndarray, np.ndarray]:
    """Integrals (cells, 4) of eval over the cells, and estimates of their errors.

    A cell where the midpoint rule is uncertain is quartered, up to `rounds` times.
    """
    box, chart, config = cells.box, cells.chart, cells.config
    owner = np.arange(len(box))
    total, error = np.zeros((len(box), 4)), np.zeros((len(box), 4))
    for left in reversed(range(rounds)):
        points, weights = _cell_points(cells.charts, box, chart)
        values = device.evaluate(params, wo, np.repeat(config, points.shape[1]), points.reshape(-1, 3))
        grid = values.astype(np.float64).reshape(*weights.shape, 4) * weights[..., None]
        fine = grid[:, 1:-1, 1:-1].mean((1, 2))
        # The midpoint rule is off by second differences / 24, and by up to half a step beside a jump: take 1/8. The
        # frame shows jumps between the last midpoint and the edge.
        off = sum(np.abs(np.diff(grid, 2, axis)).sum((1, 2)) for axis in (1, 2)) / (8 * CELL_POINTS**2)
        split = (off.max(1) > TOLERANCE) & (left > 0)
        np.add.at(total, owner[~split], fine[~split])
        np.add.at(error, owner[~split], off[~split])
        if not split.any():
            break
        b = box[split]
        sm, am = (b[:, 0] + b[:, 1]) / 2, (b[:, 2] + b[:, 3]) / 2
        halves = ((b[:, 0], sm), (sm, b[:, 1])), ((b[:, 2], am), (am, b[:, 3]))
        box = np.concatenate([np.stack([*s, *a], -1) for s in halves[0] for a in halves[1]])
        chart, config, owner = (np.tile(x[split], 4) for x in (chart, config, owner))
    return total, error
