# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdGeomMesh and its GeomSubsets: raw topology, points and subdivision tags. The delegate makes the triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import UsdGeom, UsdShade

from .context import PrimvarUpdate, Rprim, Translation, Update, common_fields
from .primvars import gprim_primvars, vector_array


def collect_subsets(prim: Any) -> tuple[Any, ...]:
    """The face subsets that materials are bound to."""
    return tuple(
        subset
        for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        if subset.GetElementTypeAttr().Get() in (None, "face")
    )


def _ints(value: Any) -> np.ndarray:
    return np.asarray(value if value is not None else (), dtype=np.int32)


def _floats(value: Any) -> np.ndarray:
    return np.asarray(value if value is not None else (), dtype=np.float32)


def _topology(translation: Translation, mesh: UsdGeom.Mesh, rprim: Rprim) -> Update:
    time = translation.time
    topology: Update = {
        "scheme": str(mesh.GetSubdivisionSchemeAttr().Get(time) or "catmullClark"),
        "orientation": str(mesh.GetOrientationAttr().Get(time) or "rightHanded"),
        "faceVertexCounts": _ints(mesh.GetFaceVertexCountsAttr().Get(time)),
        "faceVertexIndices": _ints(mesh.GetFaceVertexIndicesAttr().Get(time)),
        "holeIndices": _ints(mesh.GetHoleIndicesAttr().Get(time)),
        "subsets": [(str(s.GetPath()), _ints(s.GetIndicesAttr().Get(time))) for s in rprim.subsets],
    }
    if topology["scheme"] != "none":
        topology["interpolateBoundary"] = str(mesh.GetInterpolateBoundaryAttr().Get(time) or "")
        topology["faceVaryingLinearInterpolation"] = str(mesh.GetFaceVaryingLinearInterpolationAttr().Get(time) or "")
        topology["triangleSubdivisionRule"] = str(mesh.GetTriangleSubdivisionRuleAttr().Get(time) or "")
        topology["cornerIndices"] = _ints(mesh.GetCornerIndicesAttr().Get(time))
        topology["cornerSharpnesses"] = _floats(mesh.GetCornerSharpnessesAttr().Get(time))
        topology["creaseIndices"] = _ints(mesh.GetCreaseIndicesAttr().Get(time))
        topology["creaseLengths"] = _ints(mesh.GetCreaseLengthsAttr().Get(time))
        topology["creaseSharpnesses"] = _floats(mesh.GetCreaseSharpnessesAttr().Get(time))
    return topology


def _normals(translation: Translation, mesh: UsdGeom.Mesh) -> PrimvarUpdate | None:
    """UsdGeomPointBased.normals, which primvars:normals overrides where both are authored."""
    attribute = mesh.GetNormalsAttr()
    if not attribute.HasAuthoredValue():
        return None
    values = vector_array(translation, attribute)
    return ("normals", str(mesh.GetNormalsInterpolation()), values, None) if values.size else None


def emit_mesh(translation: Translation, rprim: Rprim) -> None:
    mesh = UsdGeom.Mesh(rprim.prim)
    primvars = gprim_primvars(translation, rprim)
    if not any(p[0] == "normals" for p in primvars):
        normals = _normals(translation, mesh)
        if normals:
            primvars.append(normals)
    if any(str(n) in ("primvars:skel:jointIndices", "skel:skeleton") for n in rprim.prim.GetAuthoredPropertyNames()):
        translation.diagnostics.warning(
            "skinning-unsupported", rprim.path, "skinning is not evaluated yet; the mesh is drawn in its rest pose"
        )
    update = common_fields(rprim, primvars)
    update["double_sided"] = bool(mesh.GetDoubleSidedAttr().Get(translation.time))
    update["topology"] = _topology(translation, mesh, rprim)
    update["points"] = vector_array(translation, mesh.GetPointsAttr())
    update["subset_materials"] = list(rprim.subset_materials)
    update["refine_level"] = translation.options.refine_level
    translation.sink.sync_mesh(rprim.path, **update)
