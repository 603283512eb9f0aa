# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Runs pattern nodes as the renderer does: a material network is generated, compiled and evaluated on the device.

Many nodes share one kernel. Each read (three components of one output of one node) has a number; a chain of MaterialX's
own `ifequal` picks the read whose number a primvar holds, and goes to the emission of a surface_unlit. Inputs come from
primvars, shared by nodes through pools of values, or are authored, which is what the CPU folds.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import Any

import kernel_runner
import MaterialX as mx
import numpy as np
from kernels.core_harness import call

POINTS = 64
FRAME, TIME = 17.0, 2.5
CLOSURES = {"BSDF", "EDF", "VDF", "surfaceshader", "volumeshader", "displacementshader", "lightshader", "material"}
COMPONENTS = {"boolean": 1, "integer": 1, "float": 1}
COMPONENTS |= {"vector2": 2, "vector3": 3, "color3": 3, "vector4": 4, "color4": 4, "matrix33": 9, "matrix44": 16}
LIBRARIES = ("targets", "stdlib", "pbrlib", "bxdf", "cmlib", "nprlib")


@lru_cache
def library() -> Any:
    document = mx.createDocument()
    mx.loadLibraries(list(LIBRARIES), mx.FileSearchPath(kernel_runner.native().materialx_libraries()), document)
    return document


@lru_cache
def generator() -> Any:
    return kernel_runner.native().create_generator()


def pattern_definitions() -> list[Any]:
    """Definitions whose outputs are all values, in the library's order."""
    definitions = library().getNodeDefs()
    return [d for d in definitions if not any(o.getType() in CLOSURES for o in d.getActiveOutputs())]


# Values by pool: each a seeded array of POINTS x components, the same for every node.
def _uniform(low: float, high: float) -> Any:
    return lambda rng, shape: rng.uniform(low, high, shape)


POOLS: dict[str, Any] = {
    "any": _uniform(-2, 2),
    "unit": _uniform(0.02, 0.98),
    "positive": _uniform(0.1, 3),
    "nonzero": lambda rng, shape: rng.uniform(0.3, 2, shape) * rng.choice([-1.0, 1.0], shape),
    "cosine": _uniform(-0.98, 0.98),
    "low": _uniform(-1.5, 0.2),
    "high": _uniform(0.4, 2),
    "far": _uniform(-5, 5),
    "degrees": _uniform(-200, 200),
    "kelvin": _uniform(600, 12000),
    "index": _uniform(-1.5, 11.5),
    "whole": lambda rng, shape: rng.integers(-3, 13, shape).astype(float),
    "truth": lambda rng, shape: rng.integers(0, 2, shape).astype(float),
    "axis": lambda rng, shape: (lambda v: v / np.linalg.norm(v, axis=-1, keepdims=True))(rng.normal(size=shape)),
}


@lru_cache
def pool(name: str, slot: int, components: int) -> np.ndarray:
    rng = np.random.default_rng([*name.encode(), slot, components])
    return POOLS[name](rng, (POINTS, components)).astype(np.float32)


@dataclass(frozen=True)
class Varying:
    """An input that comes from a primvar."""

    pool: str
    slot: int
    type: str

    def values(self) -> np.ndarray:
        if self.type.startswith("matrix"):
            side = 3 if self.type == "matrix33" else 4
            rows = [pool(self.pool, 10 * self.slot + i, side) for i in range(side)]
            return np.stack(rows, 1)
        return pool(self.pool, self.slot, COMPONENTS[self.type])


@dataclass
class Case:
    """One node: its inputs by name are Varying, or what a user authors (numbers as tuples of floats)."""

    definition: Any
    inputs: dict[str, Any]
    label: str = ""
    messages: list[tuple[str, str, str]] = field(default_factory=list)
    outputs: dict[str, np.ndarray] = field(default_factory=dict)  # filled by run: POINTS x components


class Network:
    def __init__(self) -> None:
        self.nodes: list[tuple[str, str, dict[str, Any]]] = []
        self.connections: list[tuple[str, str, str, str]] = []
        self._paths: set[str] = set()

    def add(self, path: str, identifier: str, values: dict[str, Any] | None = None) -> str:
        if path not in self._paths:
            self._paths.add(path)
            self.nodes.append((path, identifier, values or {}))
        return path

    def connect(self, source: str, output: str, target: str, name: str) -> None:
        self.connections.append((source, output, target, name))

    def shine(self, path: str, output: str) -> dict[str, Any]:
        """The material that emits a vector3."""
        read = self._through(path, output, "vector3", "convert_vector3_color3")
        self.connect(read, "out", self.add("/surface", "ND_surface_unlit"), "emission_color")
        return material(self)

    def reader(self, value: Varying) -> str:
        if value.type.startswith("matrix"):
            side, rows = (3, 3) if value.type == "matrix33" else (4, 4)
            path = f"/in/{value.type}/{value.pool}{value.slot}"
            if path not in self._paths:
                self.add(path, f"ND_creatematrix_vector{side}_{value.type}")
                for i in range(rows):
                    row = self.reader(Varying(value.pool, 10 * value.slot + i, f"vector{side}"))
                    self.connect(row, "out", path, f"in{i + 1}")
            return path
        name = f"{value.pool}_{value.slot}_{COMPONENTS[value.type]}"
        return self.add(
            f"/in/{value.type}/{value.pool}{value.slot}", f"ND_geompropvalue_{value.type}", {"geomprop": name}
        )

    def reads(self, path: str, output: str, kind: str) -> list[str]:
        """Paths of color3 nodes that together show the whole output."""
        if kind in ("vector4", "color4"):
            first, last = self._through(path, output, kind, f"convert_{kind}_color3"), f"{path}/{output}/w"
            self.add(last, f"ND_extract_{kind}", {"index": 3})
            self.connect(path, output, last, "in")
            return [first, self._through(last, "out", "float", "convert_float_color3")]
        if kind.startswith("matrix"):
            found = []
            for i in range(3 if kind == "matrix33" else 4):
                row = self.add(f"{path}/{output}/row{i}", f"ND_extract_{kind}", {"index": i})
                self.connect(path, output, row, "in")
                found += self.reads(row, "out", "vector3" if kind == "matrix33" else "vector4")
            return found
        return [self._through(path, output, kind, f"convert_{kind}_color3" if kind != "color3" else "dot_color3")]

    def _through(self, path: str, output: str, kind: str, identifier: str) -> str:
        target = self.add(f"{path}/{output}/{identifier}", f"ND_{identifier}")
        self.connect(path, output, target, "in")
        return target


def _gather(reads: list[np.ndarray], kind: str) -> np.ndarray:
    """The output's components from its reads."""
    if kind in ("vector4", "color4"):
        return np.concatenate([reads[0], reads[1][:, :1]], 1)
    if kind == "matrix33":
        return np.stack(reads, 1)
    if kind == "matrix44":
        return np.stack([_gather(reads[2 * i : 2 * i + 2], "vector4") for i in range(4)], 1)
    return reads[0][:, : COMPONENTS[kind]]


@lru_cache
def scene() -> dict[str, Any]:
    """What the hit gives, POINTS rows each: every point is a triangle of its own."""
    rng = np.random.default_rng(5)

    def unit() -> np.ndarray:
        v = rng.normal(size=(POINTS, 3))
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    toWorld = np.eye(4)
    toWorld[:3, :3] = rng.normal(size=(3, 3))
    toWorld[:3, 3] = rng.uniform(-2, 2, 3)
    corners = rng.uniform(-2, 2, (POINTS, 3, 3))
    bary = rng.dirichlet((1, 1, 1), POINTS)
    st = rng.uniform(-3, 3, (POINTS, 3, 2))
    position = np.einsum("nc,nck->nk", bary, corners)
    edges = (corners[:, 1:] - corners[:, :1]) @ toWorld[:3, :3].T
    geometric = np.cross(edges[:, 0], edges[:, 1])
    geometric /= np.linalg.norm(geometric, axis=1, keepdims=True)
    shading = geometric + 0.3 * unit()
    shading /= np.linalg.norm(shading, axis=1, keepdims=True)
    found = {
        "positionObject": position,
        "positionWorld": position @ toWorld[:3, :3].T + toWorld[:3, 3],
        "normalGeometric": geometric,
        "normalWorld": shading,
        "wo": unit(),
        "edge1": edges[:, 0],
        "edge2": edges[:, 1],
        "barycentric": bary[:, 1:],
        "st": np.einsum("nc,nck->nk", bary, st),
        "stCorners": st,
        "toWorld": toWorld,
    }
    return {k: v.astype(np.float32) for k, v in found.items()} | {
        "frame": FRAME,
        "time": TIME,
        "texture": lambda file: textures()["images"][file].astype(float),
        "primvar": lambda name: _primvar(name)[0].astype(float),
    }


MAIN = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= outputs.length()) return;
  uint point = i % POINTS;
  vec4 a = inputs[IN * point], b = inputs[IN * point + 1u], c = inputs[IN * point + 2u], d = inputs[IN * point + 3u];
  vec4 e = inputs[IN * point + 4u], f = inputs[IN * point + 5u];
  ShadingPoint sp;
  sp.positionWorld = a.xyz;
  sp.positionObject = b.xyz;
  sp.normalWorld = c.xyz;
  sp.normalGeometric = d.xyz;
  sp.wo = vec3(a.w, b.w, c.w);
  sp.frontFacing = dot(sp.normalGeometric, sp.wo) >= 0.0;
  sp.footprint = FOOTPRINT;
  sp.time = 0.0;
  sp.instance = i / POINTS;
  sp.triangle = point;
  sp.mesh = 0u;
  sp.binding = 0u;
  sp.parameterBase = 0u;
  sp.barycentric = vec2(e.w, f.w);
  gEdge1World = e.xyz;
  gEdge2World = f.xyz;
  outputs[i] = vec4(materialEmission(sp), 1.0);
}"""


# Readers of pools: one fetch each, where the real ones cost many; nodes that read primvars themselves use the latter.
READERS = """
vec4 poolAt(uint first, ShadingPoint sp) { return texelFetch(lightRecords, int(first + sp.triangle)); }
float poolFloat(ShadingPoint sp, uint first, float none) { return poolAt(first, sp).x; }
vec2 poolVec2(ShadingPoint sp, uint first, vec2 none) { return poolAt(first, sp).xy; }
vec3 poolVec3(ShadingPoint sp, uint first, vec3 none) { return poolAt(first, sp).xyz; }
vec4 poolVec4(ShadingPoint sp, uint first, vec4 none) { return poolAt(first, sp); }
PatternUv poolUv(ShadingPoint sp, uint first, vec2 none) {
  return PatternUv(poolAt(first, sp).xy, vec2(0.0), vec2(0.0), 0.0);
}
"""


def _with_pools(source: str, primvars: Sequence[str]) -> tuple[str, np.ndarray]:
    """The source with pools read by `READERS`, and what they read."""
    rows = [np.zeros((1, 4), np.float32)]
    for slot, name in enumerate(primvars):
        if name in ("st", "st1", "read", "nowhere") or name.startswith(("real_", "displayColor")):
            continue
        values = np.zeros((POINTS, 4), np.float32)
        known, number, components = name.rsplit("_", 2)
        values[:, : int(components)] = pool(known, int(number), int(components))
        at = sum(len(r) for r in rows)
        source = re.sub(rf"\bprimvar(Float|Vec\d)\(sp, {slot}u,", rf"pool\1(sp, {at}u,", source)
        source = source.replace(f"patternUv(sp, {slot}u,", f"poolUv(sp, {at}u,")
        rows.append(values)
    return source, np.concatenate(rows)


def _primvar(name: str) -> tuple[np.ndarray, int]:
    """Values of a primvar and its interpolation (scene_layout.h)."""
    if name == "st":
        return scene()["stCorners"].reshape(-1, 2), 3
    if name.startswith("displayColor"):
        return pool("unit", len(name), 3), 1
    if name == "st1":
        return pool("far", 1, 2), 1
    if name == "read":
        return np.arange(4096, dtype=np.float32)[:, None], 4
    known, slot, components = name.removeprefix("real_").rsplit("_", 2)
    return pool(known, int(slot), int(components)), 1


def _tables(primvars: Sequence[str], parameters: Sequence[float], reads: int) -> dict[str, np.ndarray]:
    descriptors = np.zeros((2 + len(primvars), 4), np.uint32)
    streams: list[np.ndarray] = []
    at = 0
    for i, name in enumerate(primvars):
        try:
            values, interpolation = _primvar(name)
        except (ValueError, KeyError):
            descriptors[2 + i] = (0xFFFFFFFF, 0xFFFFFFFF, 0, 0)
            continue
        descriptors[2 + i] = (at, 0xFFFFFFFF, interpolation | values.shape[1] << 8, 0)
        streams.append(values.ravel())
        at += values.size
    world = scene()["toWorld"].astype(np.float64)
    instances = np.zeros((max(reads, 1), 9, 4), np.float32)
    instances[:, 0:3] = np.linalg.inv(world)[:3]
    instances[:, 4:7] = world[:3]
    instances.view(np.uint32)[:, 7, 2] = np.arange(max(reads, 1))
    mesh = np.full(8, 0xFFFFFFFF, np.uint32)
    return {
        "bindingRecords": descriptors,
        "primvarStream": np.concatenate(streams) if streams else np.zeros(4, np.float32),
        "materialParameters": np.asarray(parameters, np.float32),
        "instanceRecords": instances,
        "meshRecords": mesh,
    }


def material(network: Network, surface: str = "/surface") -> dict[str, Any]:
    return generator().generate(network.nodes, network.connections, surface)


def build(cases: Sequence[Case]) -> tuple[dict[str, Any], list[tuple[Case, str, str, int]]]:
    """The material, and where each output's reads start."""
    network = Network()
    network.add("/read", "ND_geompropvalue_integer", {"geomprop": "read"})
    places: list[tuple[Case, str, str, int]] = []
    reads: list[str] = []
    for number, case in enumerate(cases):
        path = f"/case{number}"
        values = {k: v for k, v in case.inputs.items() if not isinstance(v, Varying)}
        for port in case.definition.getActiveInputs():
            if port.getType() == "filename" and port.getName() in values:
                values[port.getName()] = ("asset", values[port.getName()], "")
        network.add(path, case.definition.getName(), values)
        for name, value in case.inputs.items():
            if isinstance(value, Varying):
                network.connect(network.reader(value), "out", path, name)
        for output in case.definition.getActiveOutputs():
            kind = output.getType()
            if kind in COMPONENTS:
                places.append((case, output.getName(), kind, len(reads)))
                reads += network.reads(path, output.getName(), kind)
    last = network.add("/none", "ND_constant_color3", {"value": (-99.0, -99.0, -99.0)})
    for number, read in enumerate(reads):
        choice = network.add(f"/choose{number}", "ND_ifequal_color3I", {"value2": number})
        network.connect("/read", "out", choice, "value1")
        network.connect(read, "out", choice, "in1")
        network.connect(last, "out", choice, "in2")
        last = choice
    network.add("/surface", "ND_surface_unlit")
    network.connect(last, "out", "/surface", "emission_color")
    result = material(network)
    for code, location, text in result["messages"]:
        number = location.split("/")[1].removeprefix("case")
        (cases[int(number)] if number.isdigit() else cases[0]).messages.append((code, location, text))
    return result, [*places, (cases[0], "", "", len(reads))]


@lru_cache
def textures() -> dict[str, Any]:
    """Tables of two small images, as the texture store writes them, and what they hold."""
    rng = np.random.default_rng(11)
    images = {"smooth": rng.uniform(0.05, 1, (8, 16, 4)), "normals": rng.uniform(0.3, 0.7, (8, 8, 4))}
    images["normals"][..., 2] = 0.95
    images = {k: v.astype(np.float16) for k, v in images.items()}
    tables = kernel_runner.native().scene_tables(
        [], [(v.shape[1], v.shape[0], "rgba16f", v.tobytes()) for v in images.values()], [], 1.0
    )
    found: dict[str, Any] = {k: tables[k] for k in ("textureRecords", "pageTable", "texturePages")}
    return found | {"images": images, "ids": {name: i for i, name in enumerate(images)}}


def execute(runner: Any, result: dict[str, Any], reads: int = 1, footprint: float = 0.0) -> np.ndarray:
    """The material's emission: (reads, POINTS, 3)."""
    parameters = np.array(result["parameters"], np.float32)
    tables: dict[str, Any] = {}
    for path, _, _, _, offset in result["textures"]:
        parameters[offset : offset + 1] = np.array([textures()["ids"][path]], np.uint32).view(np.float32)
        tables = {k: textures()[k] for k in ("textureRecords", "pageTable", "texturePages")}
    tables |= _tables(result["primvars"], parameters, reads)
    s = scene()
    rows = np.zeros((POINTS, 6, 4), np.float32)
    for i, name in enumerate(("positionWorld", "positionObject", "normalWorld", "normalGeometric", "edge1", "edge2")):
        rows[:, i, :3] = s[name]
    rows[:, 0:3, 3] = s["wo"]
    rows[:, 4:6, 3] = s["barycentric"]
    lines = result["emission"].splitlines()[2:]  # the test has a head and a main of its own
    body = "\n".join(line for line in lines if not line.startswith('#include "material/'))
    body, tables["lightRecords"] = _with_pools(body, result["primvars"])
    main = f"const uint POINTS = {POINTS}u;\nconst float FOOTPRINT = {footprint!r};\n" + READERS + body + MAIN
    values = {"frameNumber": FRAME, "timeSeconds": TIME}
    inputs = np.tile(rows.reshape(POINTS, 24), (reads, 1))
    out = call(runner, ["lib/frame_values.glsl", "lib/pattern.glsl"], main, inputs, 1, tables, values)
    return out.reshape(reads, POINTS, 4)[:, :, :3]


def run(runner: Any, cases: Sequence[Case], footprint: float = 0.0) -> dict[str, Any]:
    """Fills `outputs` and `messages` of the cases; the material."""
    result, places = build(cases)
    out = execute(runner, result, places[-1][3], footprint)
    for (case, name, kind, first), (_, _, _, end) in pairwise(places):
        case.outputs[name] = _gather(list(out[first:end]), kind)
    return result
