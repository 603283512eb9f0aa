# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Schemas that can be drawn but are not translated yet: one diagnostic a prim, nothing drawn wrong in silence."""

from __future__ import annotations

from pxr import Usd, UsdGeom

from .context import Translation

# Type -> what a user would call it.
UNSUPPORTED: dict[str, str] = {
    "BasisCurves": "curves",
    "NurbsCurves": "NURBS curves",
    "HermiteCurves": "Hermite curves",
    "NurbsPatch": "NURBS patches",
    "Points": "points",
    "TetMesh": "tetrahedral meshes",
    "Volume": "volumes",
    "PortalLight": "portal lights",
    "PluginLight": "plug-in lights",
    "GeometryLight": "geometry lights",
    "ParticleField": "particle fields",
    "ParticleField3DGaussianSplat": "Gaussian splats",
}


def report_unsupported(translation: Translation, prim: Usd.Prim) -> None:
    type_name = str(prim.GetTypeName())
    what = UNSUPPORTED.get(type_name, f"prims of type {type_name}")
    translation.diagnostics.warning(
        "prim-unsupported", prim.GetPath(), f"{what} are not rendered yet; the {type_name} is left out"
    )


def report_applied_apis(translation: Translation, prim: Usd.Prim) -> None:
    schemas = prim.GetAppliedSchemas()
    for name, what in (("MeshLightAPI", "mesh lights"), ("VolumeLightAPI", "volume lights")):
        if name in schemas:
            translation.diagnostics.warning(
                "prim-unsupported",
                prim.GetPath(),
                f"{what} ({name}) are not rendered yet; the prim is drawn without shining by it",
            )
    if "GeomModelAPI" in schemas:
        mode = UsdGeom.ModelAPI(prim).GetModelDrawModeAttr().Get()
        if mode in ("origin", "bounds", "cards"):
            translation.diagnostics.warning(
                "draw-mode-unsupported",
                prim.GetPath(),
                f"model:drawMode '{mode}' is not rendered; the full geometry is drawn",
            )


def is_drawable(prim: Usd.Prim) -> bool:
    """True for what its schema calls geometry with a place in the world."""
    return bool(prim.IsA(UsdGeom.Gprim))
