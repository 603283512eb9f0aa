# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Primvars as the delegate takes them: float values, indices as authored."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from .context import PrimvarUpdate, Translation

# Primvars that no material of ours reads: skinning, and other renderers' settings.
_SKIPPED_PREFIXES = ("skel:", "arnold:", "ri:", "prman:", "karma:", "cycles:", "renderman:")
_MAX_COMPONENTS = 4


def float_array(value: Any) -> np.ndarray | None:
    """(n, components) float32 of a numeric Vt array or value; None for strings, tokens, assets and the like."""
    if value is None or isinstance(value, str | bytes):
        return None
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return None
    if array.dtype == object:  # a Gf value that numpy does not know, such as a quaternion
        return None
    if array.dtype.kind not in "fiub":
        return None
    if array.ndim == 0:
        array = array.reshape(1, 1)
    return np.ascontiguousarray(array, dtype=np.float32)


def vector_array(translation: Translation, attribute: Usd.Attribute) -> np.ndarray:
    """(n, 3) float32; empty, and reported, where something else is authored."""
    value = attribute.Get(translation.time)
    if value is None:
        return np.empty((0, 3), dtype=np.float32)
    array = float_array(value)
    if array is not None and array.ndim == 2 and array.shape[1] == 3:
        return array
    if array is None or array.size:
        translation.diagnostics.warning(
            "attribute-bad-type",
            attribute.GetPath(),
            f"the attribute holds a {type(value).__name__} where an array of three-vectors is needed; it is ignored",
        )
    return np.empty((0, 3), dtype=np.float32)


def primvar_update(
    translation: Translation, primvar: UsdGeom.Primvar, *, name: str = "", interpolation: str = ""
) -> PrimvarUpdate | None:
    """None for primvars without a value, of a type that shading cannot use, or that are broken (which is reported)."""
    type_name = primvar.GetTypeName()
    array = float_array(primvar.Get(translation.time))
    if array is None or array.size == 0:
        return None
    indices = None
    if primvar.IsIndexed():
        authored = primvar.GetIndices(translation.time)
        if authored is not None:
            indices = np.asarray(authored, dtype=np.int32)
    element_size = primvar.GetElementSize()
    if type_name.isArray:
        array = array.reshape(array.shape[0], -1)
        if (
            element_size > 1
            and indices is not None
            and len(array) > indices.max(initial=0) >= len(array) // element_size
        ):
            # Exporters write the number of values here; Hydra does not look at it.
            translation.diagnostics.warning(
                "primvar-bad-size",
                primvar.GetAttr().GetPath(),
                f"elementSize {element_size} does not fit the primvar's indices; it is taken as 1",
            )
            element_size = 1
        if element_size > 1:
            if array.shape[0] % element_size:
                translation.diagnostics.warning(
                    "primvar-bad-size",
                    primvar.GetAttr().GetPath(),
                    f"{array.shape[0]} values are no multiple of elementSize {element_size}; the primvar is left out",
                )
                return None
            array = array.reshape(array.shape[0] // element_size, -1)
    else:
        array = array.reshape(1, -1)
    components = array.shape[1] if array.ndim == 2 else 1
    if components > _MAX_COMPONENTS:  # matrices and the like: nothing that a material can read
        return None
    return (
        name or str(primvar.GetPrimvarName()),
        interpolation or str(primvar.GetInterpolation()),
        array.reshape(-1, components),
        indices,
    )


def is_shading_primvar(name: str) -> bool:
    return not name.startswith(_SKIPPED_PREFIXES)


def primvar_updates(
    translation: Translation, primvars: Iterable[UsdGeom.Primvar], skip: frozenset[str] = frozenset()
) -> list[PrimvarUpdate]:
    updates = []
    for primvar in primvars:
        name = str(primvar.GetPrimvarName())
        if name in skip or not is_shading_primvar(name):
            continue
        update = primvar_update(translation, primvar)
        if update is not None:
            updates.append(update)
    return updates


def gprim_primvars(translation: Translation, rprim: Any) -> list[PrimvarUpdate]:
    """All primvars of a prim: its own, and inherited constants that the instancer does not give to each instance."""
    if not rprim.context.primvars and not any(name.startswith("primvars:") for name in rprim.names):
        return []
    own = UsdGeom.PrimvarsAPI(rprim.prim).FindPrimvarsWithInheritance(list(rprim.context.primvars))
    hidden = rprim.context.instance_primvars
    if hidden:
        own = [p for p in own if p.GetPrimvarName() not in hidden or p.GetAttr().GetPrim() == rprim.prim]
    return primvar_updates(translation, own)
