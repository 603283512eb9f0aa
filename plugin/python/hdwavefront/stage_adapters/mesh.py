# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdGeomMesh and its GeomSubsets: raw topology, points and subdivision tags. The delegate makes the triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import UsdGeom, UsdShade

from ..errors import Diagnostics
from .context import PrimvarUpdate, Rprim, Translation, Update, common_fields
from .primvars import gprim_primvars, vector_array
from .unsupported import report_skinning


def collect_subsets(prim: Any, diagnostics: Diagnostics) -> tuple[Any, ...]:
    """The face subsets that materials are bound to."""
    subsets = []
    for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        kind = subset.GetElementTypeAttr().Get()
        if kind == "face":
            subsets.append(subset)
        else:
            diagnostics.warning(
                "subset-unsupported", subset.GetPath(), f"materials of subsets of type '{kind}' are not rendered"
            )
    return tuple(subsets)


def _ints(value: Any) -> np.ndarray:
    return np.asarray(value if value is not None else (), dtype=np.int32)


def _floats(value: Any) -> np.ndarray:
    return np.asarray(value if value is not None else (), dtype=np.float32)


# Subdivision tags: name -> numbers or tokens.
_TAGS: dict[str, Any] = {
    "interpolateBoundary": str,
    "faceVaryingLinearInterpolation": str,
    "triangleSubdivisionRule": str,
    "cornerIndices": _ints,
    "cornerSharpnesses": _floats,
    "creaseIndices": _ints,
    "creaseLengths": _ints,
    "creaseSharpnesses": _floats,
}


def _topology(translation: Translation, rprim: Rprim) -> Update:
    """What is authored; absent keys take UsdGeomMesh's fallbacks."""
    time, prim, names = translation.time, rprim.prim, rprim.names

    def get(name: str) -> Any:
        return prim.GetAttribute(name).Get(time) if name in names else None

    topology: Update = {
        "scheme": str(get("subdivisionScheme") or "catmullClark"),
        "orientation": str(get("orientation") or "rightHanded"),
        "faceVertexCounts": _ints(get("faceVertexCounts")),
        "faceVertexIndices": _ints(get("faceVertexIndices")),
        "holeIndices": _ints(get("holeIndices")),
    }
    if rprim.subsets:
        topology["subsets"] = [(str(s.GetPath()), _ints(s.GetIndicesAttr().Get(time))) for s in rprim.subsets]
    if topology["scheme"] != "none":
        for name in names & _TAGS.keys():
            value = get(name)
            if value is not None:
                topology[name] = _TAGS[name](value)
    return topology


def _normals(translation: Translation, mesh: UsdGeom.Mesh) -> PrimvarUpdate | None:
    """UsdGeomPointBased.normals, which primvars:normals overrides where both are authored."""
    values = vector_array(translation, mesh.GetNormalsAttr())
    return ("normals", str(mesh.GetNormalsInterpolation()), values, None) if values.size else None


def emit_mesh(translation: Translation, rprim: Rprim) -> None:
    mesh = UsdGeom.Mesh(rprim.prim)
    primvars = gprim_primvars(translation, rprim)
    if "normals" in rprim.names and not any(p[0] == "normals" for p in primvars):
        normals = _normals(translation, mesh)
        if normals:
            primvars.append(normals)
    report_skinning(translation, rprim)
    update = common_fields(rprim, primvars)
    update["double_sided"] = "doubleSided" in rprim.names and bool(mesh.GetDoubleSidedAttr().Get(translation.time))
    update["topology"] = _topology(translation, rprim)
    update["points"] = vector_array(translation, mesh.GetPointsAttr())
    update["subset_materials"] = list(rprim.subset_materials)
    update["refine_level"] = translation.options.refine_level
    translation.sink.sync_mesh(rprim.path, **update)
