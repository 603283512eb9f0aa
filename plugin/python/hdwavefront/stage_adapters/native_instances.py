# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Native (scene-graph) instances: those of one prototype that look alike share one instancer and one set of meshes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdShade

from .context import PrimContext, PrimvarUpdate, Translation, Update, matrix_array
from .primvars import float_array, is_shading_primvar


@dataclass(slots=True)
class InstanceGroup:
    """Instances of one prototype that inherit equal things from outside; the first one stands for all in names."""

    root: Usd.Prim
    path: str
    context: PrimContext
    transforms: list[Gf.Matrix4d] = field(default_factory=list)
    primvars: list[tuple[Any, ...]] = field(default_factory=list)


class InstanceGroups:
    """Groups in order of their first instance."""

    def __init__(self, translation: Translation) -> None:
        self._translation = translation
        self._groups: dict[tuple[Any, ...], InstanceGroup] = {}

    def add(self, prim: Usd.Prim, path: str, context: PrimContext) -> None:
        """`context` holds at the instance's own root, its transform included."""
        options = self._translation.options
        bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(options.material_purpose)
        names = tuple(sorted((str(p.GetPrimvarName()), str(p.GetTypeName())) for p in context.primvars))
        key = (
            str(prim.GetPrototype().GetPath()),
            context.instancer,
            context.prototype,
            context.purpose,
            str(bound.GetPath()) if bound else "",
            names,
        )
        group = self._groups.get(key)
        if group is None:
            group = self._groups[key] = InstanceGroup(prim, path + ".instances", context)
        group.transforms.append(context.transform)
        group.primvars.append(context.primvars)

    def take(self) -> list[InstanceGroup]:
        groups, self._groups = list(self._groups.values()), {}
        return groups


def emit_instances(translation: Translation, group: InstanceGroup) -> PrimContext:
    """Tells the instancer, and returns the context in which the children of `group.root` are walked once."""
    context = group.context
    primvars, shared = _split_primvars(translation, group)
    update: Update = {
        "transforms": np.stack([matrix_array(m) for m in group.transforms]),
        "transform": np.eye(4),
        "primvars": primvars,
        "visible": True,
    }
    if context.instancer:
        update["parent"] = context.instancer
        update["parent_prototype"] = context.prototype
    translation.sink.sync_instancer(group.path, **update)
    return context.at(
        transform=Gf.Matrix4d(1),
        primvars=shared,
        instancer=group.path,
        prototype=0,
        instance_primvars=context.instance_primvars | frozenset(p[0] for p in primvars),
    )


def _split_primvars(translation: Translation, group: InstanceGroup) -> tuple[list[PrimvarUpdate], tuple[Any, ...]]:
    """Constants that differ between the instances become instance primvars; the rest is inherited as usual."""
    shared: list[Any] = []
    split: list[PrimvarUpdate] = []
    by_name = [{str(p.GetPrimvarName()): p for p in primvars} for primvars in group.primvars]
    for primvar in group.context.primvars:
        name = str(primvar.GetPrimvarName())
        mine = [primvars[name] for primvars in by_name]
        first = mine[0].GetAttr().GetPath()
        if all(p.GetAttr().GetPath() == first for p in mine):
            shared.append(primvar)
            continue
        values = [v for v in (_constant(p, translation.time) for p in mine) if v is not None]
        alike = len(values) == len(mine) and all(v.shape == values[0].shape for v in values)
        if not is_shading_primvar(name) or not alike:
            shared.append(primvar)
            if is_shading_primvar(name) and primvar.GetTypeName().isArray:
                translation.diagnostics.warning(
                    "instance-primvar-unsupported",
                    mine[-1].GetAttr().GetPath(),
                    f"the primvar differs between instances of one prototype and is no single value; "
                    f"all take that of {first}",
                )
            continue
        split.append((name, "instance", np.stack(values), None))
    return split, tuple(shared)


def _constant(primvar: UsdGeom.Primvar, time: Usd.TimeCode) -> np.ndarray | None:
    """A constant of one element, flat; None for others."""
    array = float_array(primvar.ComputeFlattened(time))
    if array is None:
        return None
    if primvar.GetTypeName().isArray:
        if len(array) != 1:
            return None
        array = array[0]
    array = np.atleast_1d(array).reshape(-1)
    return array if array.size <= 4 else None
