# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What an adapter is told about the prim that it translates, and whom it tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from pxr import Gf, Usd

from ..errors import Diagnostics

Update = dict[str, Any]
# (name, interpolation, values (n, components) float32, indices or None)
PrimvarUpdate = tuple[str, str, np.ndarray, np.ndarray | None]


class Sink(Protocol):
    """Receives typed updates: `_core.RenderDelegate`, whose stub documents every field, or a recorder in tests."""

    def sync_mesh(self, path: str, **update: Any) -> None: ...
    def sync_implicit(self, path: str, **update: Any) -> None: ...
    def sync_instancer(self, path: str, **update: Any) -> None: ...
    def sync_light(self, path: str, **update: Any) -> None: ...
    def sync_material(self, path: str, contexts: Update) -> None: ...
    def sync_camera(self, path: str, **update: Any) -> None: ...


@dataclass(frozen=True, slots=True)
class Options:
    """What a translation depends on besides the stage."""

    time: Usd.TimeCode
    purposes: frozenset[str] = frozenset({"default", "proxy"})
    refine_level: int = 0
    material_purpose: str = "full"  # bindings of this purpose, else those for all purposes
    render_contexts: tuple[str, ...] = ("wavefront", "mtlx", "")
    # Colour (r, g, b) of a named colour space ("" where nothing is authored) to the rendering colour space.
    convert_color: Callable[[Any, str], Any] = field(default=lambda rgb, space: rgb)
    knows_color_space: Callable[[str], bool] = field(default=lambda space: True)


@dataclass(frozen=True, slots=True)
class PrimContext:
    """A prim's inherited state. Transforms are to the world, or to the root of the prototype inside an instancer."""

    transform: Gf.Matrix4d
    purpose: str = "default"
    primvars: tuple[Any, ...] = ()  # UsdGeom.Primvar inherited from above
    instancer: str = ""
    prototype: int = 0
    # Names that the instancer gives to each instance: an inherited constant of the same name must not hide them.
    instance_primvars: frozenset[str] = frozenset()
    # The material bound to the PointInstancer, for prims of a prototype that have none.
    fallback_material: str = ""
    # The PointInstancers around a prototype, outermost first: one that contains itself would never end.
    instancer_chain: tuple[str, ...] = ()
    in_prototype: bool = False  # of a PointInstancer: overs and classes are drawn as well

    def at(self, **changes: Any) -> PrimContext:
        return replace(self, **changes)


@dataclass(slots=True)
class Rprim:
    """A thing that can be drawn, found by the traversal and translated after all bindings are known."""

    prim: Usd.Prim
    path: str
    context: PrimContext
    emit: Callable[[Translation, Rprim], None]
    names: frozenset[str]  # authored properties: reading only those halves the time
    material: str = ""
    subset_materials: tuple[str, ...] = ()
    subsets: tuple[Any, ...] = ()


@dataclass(slots=True)
class Translation:
    """One walk over a stage."""

    stage: Usd.Stage
    options: Options
    sink: Sink
    diagnostics: Diagnostics
    light_count: int = 0
    has_emission: bool = False  # a material that is used may shine

    @property
    def time(self) -> Usd.TimeCode:
        return self.options.time


def schema_type(prim: Usd.Prim) -> str:
    """The prim's type, or what the stage says to take where this USD does not know it; empty where it knows none."""
    return str(prim.GetPrimTypeInfo().GetSchemaTypeName())


def matrix_array(matrix: Gf.Matrix4d) -> np.ndarray:
    return np.array(matrix, dtype=np.float64)


def common_fields(rprim: Rprim, primvars: list[PrimvarUpdate]) -> Update:
    """What every Rprim tells."""
    fields: Update = {
        "primvars": primvars,
        "transform": matrix_array(rprim.context.transform),
        "material": rprim.material,
        "visible": True,
        "render_tag": "geometry" if rprim.context.purpose == "default" else rprim.context.purpose,
    }
    if rprim.context.instancer:
        fields["instancer"] = rprim.context.instancer
        fields["prototype"] = rprim.context.prototype
    return fields
