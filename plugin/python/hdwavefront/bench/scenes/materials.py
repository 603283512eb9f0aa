# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""MaterialX networks as UsdShade prims, node by node."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

# Node definitions of several outputs, with their types. The others have one, called "out".
_OUTPUTS = {
    "flake3d": {"id": "integer", "rand": "float", "presence": "float", "flakenormal": "vector3"},
}
_CLOSURES = ("_bsdf", "_edf", "_surfaceshader")


@dataclass(frozen=True)
class Vector:
    """A vector3 value; bare triples are colours."""

    x: float
    y: float
    z: float


@dataclass(frozen=True)
class File:
    """The path of an image."""

    path: str


@dataclass(frozen=True)
class Output:
    """An output of a node, to be connected to inputs of others."""

    attribute: Any
    type: str


Value = float | int | bool | str | tuple[float, ...] | Vector | File | Output


def _sdf_type(kind: str) -> Any:
    from pxr import Sdf

    names = {
        "float": Sdf.ValueTypeNames.Float,
        "integer": Sdf.ValueTypeNames.Int,
        "boolean": Sdf.ValueTypeNames.Bool,
        "string": Sdf.ValueTypeNames.String,
        "color3": Sdf.ValueTypeNames.Color3f,
        "vector3": Sdf.ValueTypeNames.Float3,
        "vector2": Sdf.ValueTypeNames.Float2,
        "filename": Sdf.ValueTypeNames.Asset,
    }
    return names.get(kind, Sdf.ValueTypeNames.Token)


def _typed(value: Any) -> tuple[str, Any]:
    from pxr import Gf, Sdf

    if isinstance(value, File):
        return "filename", Sdf.AssetPath(value.path)
    if isinstance(value, bool):
        return "boolean", value
    if isinstance(value, int):
        return "integer", value
    if isinstance(value, float):
        return "float", value
    if isinstance(value, str):
        return "string", value
    if isinstance(value, Vector):
        return "vector3", Gf.Vec3f(value.x, value.y, value.z)
    if len(value) == 2:
        return "vector2", Gf.Vec2f(*value)
    return "color3", Gf.Vec3f(*value)


class Network:
    """The nodes of one material. Whole numbers are integers to MaterialX: write 1.0 for a float."""

    def __init__(self, material: Any) -> None:
        self._material = material
        self._count = 0

    def node(self, definition: str, /, **inputs: Value) -> Output:
        """Adds a node of the definition ND_<definition>; gives its output. An input whose name is a word of Python has
        an underscore after it: `in_`."""
        shader = self._shader(definition, inputs)
        kind = "closure" if definition.endswith(_CLOSURES) or definition == "surface" else definition.split("_")[-1]
        if kind.endswith("FA"):  # a vector or colour with a float
            kind = kind[:-2]
        return Output(shader.CreateOutput("out", _sdf_type(kind)), kind)

    def outputs(self, definition: str, /, **inputs: Value) -> dict[str, Output]:
        """As `node`, for nodes of several outputs."""
        shader = self._shader(definition, inputs)
        return {n: Output(shader.CreateOutput(n, _sdf_type(t)), t) for n, t in _OUTPUTS[definition].items()}

    def _shader(self, definition: str, inputs: Mapping[str, Value]) -> Any:
        from pxr import UsdShade

        self._count += 1
        path = self._material.GetPath().AppendChild(f"n{self._count}_{definition}")
        shader = UsdShade.Shader.Define(self._material.GetPrim().GetStage(), path)
        shader.CreateIdAttr(f"ND_{definition}")
        for key, value in inputs.items():
            name = key.rstrip("_")
            if isinstance(value, Output):
                shader.CreateInput(name, _sdf_type(value.type)).ConnectToSource(value.attribute)
            else:
                kind, plain = _typed(value)
                shader.CreateInput(name, _sdf_type(kind)).Set(plain)
        return shader

    def surface(self, shader: Output) -> None:
        """The material's surface terminal."""
        self._material.CreateSurfaceOutput("mtlx").ConnectToSource(shader.attribute)

    # -- Often needed

    def standard_surface(self, **inputs: Value) -> None:
        self.surface(self.node("standard_surface_surfaceshader", **inputs))

    def position(self, scale: float | Vector = 1.0, space: str = "object") -> Output:
        """The position times a factor."""
        position = self.node("position_vector3", space=space)
        if isinstance(scale, Vector):
            return self.node("multiply_vector3", in1=position, in2=scale)
        return position if scale == 1.0 else self.node("multiply_vector3FA", in1=position, in2=float(scale))

    def fractal(self, position: Output, octaves: int = 3, amplitude: float = 1.0) -> Output:
        """Fractal noise, brought from about -1..1 to 0..1."""
        noise = self.node("fractal3d_float", position=position, octaves=octaves, amplitude=0.5 * amplitude)
        return self.clamped(self.node("add_float", in1=noise, in2=0.5))

    def clamped(self, value: Output) -> Output:
        return self.node("clamp_float", in_=value, low=0.0, high=1.0)

    def smoothstep(self, value: Output, low: float, high: float) -> Output:
        return self.node("smoothstep_float", in_=value, low=low, high=high)

    def mixed(self, low: Value, high: Value, amount: Output) -> Output:
        """Of two colours."""
        return self.node("mix_color3", bg=low, fg=high, mix=amount)

    def mixed_float(self, low: Value, high: Value, amount: Output) -> Output:
        return self.node("mix_float", bg=low, fg=high, mix=amount)
