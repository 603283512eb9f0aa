# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Schemas that change the picture but are not translated yet: one diagnostic a prim, nothing drawn wrong in silence."""

from __future__ import annotations

from pxr import Usd, UsdGeom

from .context import Rprim, Translation, schema_type

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
    "GenerativeProcedural": "procedurals",
}

_LIGHT_APIS = (("MeshLightAPI", "mesh lights"), ("VolumeLightAPI", "volume lights"), ("LightAPI", "prims made lights"))
_SKINNING = frozenset({"primvars:skel:jointIndices", "skel:skeleton", "skel:blendShapes", "skel:blendShapeTargets"})


def report_unsupported(translation: Translation, prim: Usd.Prim) -> None:
    type_name = schema_type(prim)
    what = UNSUPPORTED.get(type_name, f"prims of type {type_name}")
    translation.diagnostics.warning(
        "prim-unsupported", prim.GetPath(), f"{what} are not rendered yet; the {type_name} is left out"
    )


def report_unknown_type(translation: Translation, prim: Usd.Prim) -> None:
    translation.diagnostics.warning(
        "prim-unknown-type",
        prim.GetPath(),
        f"this USD has no schema of the name {prim.GetTypeName()}; if the prim is to be seen, it is not",
    )


def report_applied_apis(translation: Translation, prim: Usd.Prim, *, is_light: bool) -> None:
    """`is_light`: the prim's type is a light, which is translated or reported by itself."""
    schemas = prim.GetAppliedSchemas()
    light_api = next(((name, what) for name, what in _LIGHT_APIS if name in schemas), None)
    if light_api and not is_light:
        name, what = light_api
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
    if "VisibilityAPI" in schemas:
        _report_purpose_visibility(translation, prim)


def _report_purpose_visibility(translation: Translation, prim: Usd.Prim) -> None:
    hidden = [
        purpose
        for purpose in ("guide", "proxy", "render")
        if purpose in translation.options.purposes
        and (attribute := prim.GetAttribute(purpose + "Visibility")).HasAuthoredValue()
        and attribute.Get(translation.time) == UsdGeom.Tokens.invisible
    ]
    if hidden:
        translation.diagnostics.warning(
            "purpose-visibility-unsupported",
            prim.GetPath(),
            f"{hidden[0]}Visibility is not read, as in UsdImaging: purposes are shown or hidden as a whole",
        )


def report_skinning(translation: Translation, rprim: Rprim) -> None:
    """Joints may be bound further up, for rigid parts."""
    inherited = any(p.GetPrimvarName() == "skel:jointIndices" for p in rprim.context.primvars)
    if inherited or rprim.names & _SKINNING:
        translation.diagnostics.warning(
            "skinning-unsupported",
            rprim.path,
            "skinning and blend shapes are not evaluated yet; the prim is drawn in its rest pose",
        )


def is_drawable(prim: Usd.Prim) -> bool:
    """True for what its schema calls something with a place and an extent in the world."""
    return bool(prim.IsA(UsdGeom.Boundable))
