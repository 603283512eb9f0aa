# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdGeomPointInstancer: the raw arrays. The delegate composes transforms, nested ones too."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from .context import PrimContext, PrimvarUpdate, Translation, Update, matrix_array
from .primvars import is_shading_primvar, primvar_update


def _inactive_ids(prim: Usd.Prim) -> np.ndarray:
    list_op = prim.GetMetadata("inactiveIds")
    return np.asarray(list_op.ApplyOperations([]) if list_op else (), dtype=np.int64)


def _instance_primvars(translation: Translation, prim: Usd.Prim) -> list[PrimvarUpdate]:
    updates = []
    for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues():
        if str(primvar.GetInterpolation()) == "constant" or not is_shading_primvar(str(primvar.GetPrimvarName())):
            continue
        update = primvar_update(translation, primvar, interpolation="instance")
        if update is not None:
            updates.append(update)
    return updates


def _array(value: Any, dtype: type, columns: int) -> np.ndarray:
    if value is None or len(value) == 0:
        return np.empty((0, columns) if columns > 1 else (0,), dtype=dtype)
    array: np.ndarray = np.asarray(value, dtype=dtype)
    return array.reshape(-1, columns) if columns > 1 else array.reshape(-1)


def emit_point_instancer(
    translation: Translation, prim: Usd.Prim, path: str, context: PrimContext
) -> list[tuple[Usd.Prim, PrimContext]]:
    """Tells the instancer, and returns the prototypes' roots to be walked with the context that they are drawn in."""
    time = translation.time
    instancer = UsdGeom.PointInstancer(prim)
    primvars = _instance_primvars(translation, prim)
    proto_indices = _array(instancer.GetProtoIndicesAttr().Get(time), np.int32, 1)
    orientations = (
        instancer.GetPrim().GetAttribute("orientationsf").Get(time) if prim.HasAttribute("orientationsf") else None
    )
    if not orientations:
        orientations = instancer.GetOrientationsAttr().Get(time)
    update: Update = {
        "positions": _array(instancer.GetPositionsAttr().Get(time), np.float32, 3),
        "orientations": _array(orientations, np.float32, 4),
        "scales": _array(instancer.GetScalesAttr().Get(time), np.float32, 3),
        "proto_indices": proto_indices,
        "ids": _array(instancer.GetIdsAttr().Get(time), np.int64, 1),
        "invisible_ids": _array(instancer.GetInvisibleIdsAttr().Get(time), np.int64, 1),
        "inactive_ids": _inactive_ids(prim),
        "transform": matrix_array(context.transform),
        "primvars": primvars,
        "visible": True,
    }
    if context.instancer:
        update["parent"] = context.instancer
        update["parent_prototype"] = context.prototype
    targets = instancer.GetPrototypesRel().GetForwardedTargets()
    # An empty array would mean "every prototype at every instance" to the delegate; in USD it draws nothing.
    if proto_indices.size == 0 or not targets:
        translation.diagnostics.warning(
            "point-instancer-empty", path, "the PointInstancer has no protoIndices or no prototypes; it draws nothing"
        )
        return []
    if proto_indices.min() < 0 or proto_indices.max() >= len(targets):
        translation.diagnostics.warning(
            "point-instancer-bad-index",
            path,
            f"protoIndices name prototypes outside 0..{len(targets) - 1}; those instances are not drawn",
        )
    translation.sink.sync_instancer(path, **update)
    bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(translation.options.material_purpose)
    used = set(np.unique(proto_indices).tolist())
    roots = []
    for index, target in enumerate(targets):
        if index not in used:
            continue
        root = translation.stage.GetPrimAtPath(target)
        if not root:
            translation.diagnostics.warning(
                "point-instancer-bad-prototype",
                path,
                f"the prototype {target} does not exist; its instances are not drawn",
            )
            continue
        if not root.IsActive():
            continue
        inner = _prototype_context(context, path, index, primvars, bound)
        roots.append((root, inner.at(**_purpose_above(root))))
    return roots


def _purpose_above(root: Usd.Prim) -> dict[str, Any]:
    """The purpose that a prototype inherits: from its own namespace, as in UsdImaging, not from the instancer."""
    above = UsdGeom.Imageable(root.GetParent()).ComputePurposeInfo()
    if above.isInheritable:
        return {"purpose": str(above.purpose)}
    if root.IsInPrototype() or root.IsInstanceProxy():
        return {}  # the namespace ends at the instance, whose purpose is in the context
    return {"purpose": "default"}


def _prototype_context(
    context: PrimContext, path: str, index: int, primvars: list[PrimvarUpdate], bound: UsdShade.Material
) -> PrimContext:
    return context.at(
        transform=type(context.transform)(1),
        instancer=path,
        prototype=index,
        instance_primvars=frozenset(p[0] for p in primvars),
        fallback_material=str(bound.GetPath()) if bound else context.fallback_material,
        in_prototype=True,
    )
