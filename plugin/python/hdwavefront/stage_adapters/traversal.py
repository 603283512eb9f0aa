# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The walk over a stage: own recursion with inherited state, prims told by type, bindings computed in bulk.

Collects first and tells later: material bindings of all prims come from one bulk call, which costs half of single ones.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from ..errors import Diagnostics
from .context import Options, PrimContext, Rprim, Sink, Translation, schema_type
from .gprims import IMPLICIT_TYPES, emit_implicit
from .lights import LIGHT_TYPES, emit_light
from .material import emit_material
from .mesh import collect_subsets, emit_mesh
from .native_instances import InstanceGroups, emit_instances
from .point_instancer import emit_point_instancer
from .unsupported import (
    UNSUPPORTED,
    is_drawable,
    report_applied_apis,
    report_unknown_type,
    report_unsupported,
)

RPRIM_ADAPTERS: dict[str, Callable[[Translation, Rprim], None]] = {
    "Mesh": emit_mesh,
    **dict.fromkeys(IMPLICIT_TYPES, emit_implicit),
}

# Types that only group, and those that have no place in a picture by themselves: walked without a word.
_SILENT_TYPES = frozenset({"", "Xform", "Scope", "SkelRoot", "Camera", "GeomSubset", "Skeleton", "SkelAnimation"})
# Types below which nothing is drawn.
_LEAF_TYPES = frozenset(
    {"Material", "Shader", "NodeGraph", "RenderSettings", "RenderProduct", "RenderVar", "RenderPass"}
)
_KNOWN_TYPES = _SILENT_TYPES | _LEAF_TYPES | RPRIM_ADAPTERS.keys() | LIGHT_TYPES.keys() | {"PointInstancer"}

_CHILDREN = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
# Prototypes of a PointInstancer may be overs or classes.
_PROTOTYPE_CHILDREN = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)
_MAX_INSTANCER_DEPTH = 64


class _Walk:
    def __init__(self, translation: Translation) -> None:
        self.translation = translation
        self.rprims: list[Rprim] = []
        self.groups = InstanceGroups(translation)
        self._paths: set[str] = set()
        self._pending: list[tuple[Usd.Prim, PrimContext]] = []

    def run(self) -> None:
        root = self.translation.stage.GetPseudoRoot()
        self._push_children(root, PrimContext(Gf.Matrix4d(1)))
        self._drain()
        while groups := self.groups.take():
            for group in groups:
                context = emit_instances(self.translation, group)
                self._push_children(group.root, context)
                self._drain()

    def _push_children(self, prim: Usd.Prim, context: PrimContext) -> None:
        children = prim.GetFilteredChildren(_PROTOTYPE_CHILDREN if context.in_prototype else _CHILDREN)
        self._pending.extend((child, context) for child in reversed(children))

    def _drain(self) -> None:
        while self._pending:
            prim, parent = self._pending.pop()
            self._visit(prim, parent)

    def _visit(self, prim: Usd.Prim, parent: PrimContext) -> None:
        translation = self.translation
        authored_type = type_name = str(prim.GetTypeName())
        if type_name not in _KNOWN_TYPES:
            type_name = schema_type(prim)
        if type_name in _LEAF_TYPES:
            return
        names = frozenset(prim.GetAuthoredPropertyNames())
        context = self._inherit(prim, parent, names)
        if context is None:
            return
        drawn = context.purpose in translation.options.purposes
        if type_name in RPRIM_ADAPTERS and prim.IsInstance():
            translation.diagnostics.warning(
                "gprim-instanced",
                prim.GetPath(),
                "a gprim that is itself instanceable is not drawn, as in UsdImaging; instance an Xform above it",
            )
        elif type_name in RPRIM_ADAPTERS:
            if drawn:
                self._add_rprim(prim, context, RPRIM_ADAPTERS[type_name], names)
        elif type_name == "PointInstancer":
            self._point_instancer(prim, context)  # whatever its own purpose: that of what it draws counts
            return
        elif type_name in LIGHT_TYPES:
            emit_light(translation, prim, context, self._unique_path(prim, context))
        elif authored_type and not type_name:
            report_unknown_type(translation, prim)
        elif type_name in _SILENT_TYPES:
            pass
        elif type_name in UNSUPPORTED or is_drawable(prim):
            if drawn:
                report_unsupported(translation, prim)
        if prim.GetAppliedSchemas():
            report_applied_apis(translation, prim, is_light=type_name in LIGHT_TYPES or type_name in UNSUPPORTED)
        if prim.IsInstance():
            self.groups.add(prim, str(prim.GetPath()), context)
        else:
            self._push_children(prim, context)

    def _inherit(self, prim: Usd.Prim, parent: PrimContext, names: frozenset[str]) -> PrimContext | None:
        """The prim's context; None if it and all below are invisible."""
        if not names or not UsdGeom.Imageable(prim):
            return parent
        time = self.translation.time
        changes: dict[str, Any] = {}
        if "visibility" in names and prim.GetAttribute("visibility").Get(time) == UsdGeom.Tokens.invisible:
            return None
        if "purpose" in names:
            purpose = prim.GetAttribute("purpose").Get()
            if purpose is not None:
                changes["purpose"] = str(purpose)
        if any(name.startswith("primvars:") for name in names):
            primvars = UsdGeom.PrimvarsAPI(prim).FindIncrementallyInheritablePrimvars(list(parent.primvars))
            if primvars:
                changes["primvars"] = tuple(primvars)
        if "xformOpOrder" in names:
            xformable = UsdGeom.Xformable(prim)
            local = xformable.GetLocalTransformation(time)
            changes["transform"] = local if xformable.GetResetXformStack() else local * parent.transform
        return parent.at(**changes) if changes else parent

    def _unique_path(self, prim: Usd.Prim, context: PrimContext) -> str:
        """The prim's own path, or one that names the instancer too where two draw the same prim."""
        path = str(prim.GetPath())
        if path in self._paths:
            path = f"{context.instancer}.prototype{context.prototype}{path}"
        while path in self._paths:
            path += "'"
        self._paths.add(path)
        return path

    def _add_rprim(
        self,
        prim: Usd.Prim,
        context: PrimContext,
        emit: Callable[[Translation, Rprim], None],
        names: frozenset[str],
    ) -> None:
        subsets = (
            collect_subsets(prim, self.translation.diagnostics)
            if emit is emit_mesh and prim.GetAllChildrenNames()
            else ()
        )
        path = self._unique_path(prim, context)
        self.rprims.append(Rprim(prim, path, context, emit, names, subsets=subsets))

    def _point_instancer(self, prim: Usd.Prim, context: PrimContext) -> None:
        own = str(prim.GetPath())
        if own in context.instancer_chain or len(context.instancer_chain) >= _MAX_INSTANCER_DEPTH:
            self.translation.diagnostics.warning(
                "point-instancer-cycle", own, "the PointInstancer is one of its own prototypes; it is drawn once only"
            )
            return
        path = self._unique_path(prim, context)
        # In reverse, so that the stack gives them in order.
        for root, inner in reversed(emit_point_instancer(self.translation, prim, path, context)):
            inner = inner.at(instancer_chain=(*context.instancer_chain, own))
            self._pending.append((root, inner))


def _bind_materials(walk: _Walk) -> dict[str, UsdShade.Material]:
    """Fills in the materials of all Rprims and subsets; returns those that are used."""
    translation = walk.translation
    prims = [r.prim for r in walk.rprims] + [s.GetPrim() for r in walk.rprims for s in r.subsets]
    materials: dict[str, UsdShade.Material] = {}
    if not prims:
        return materials
    bound, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, translation.options.material_purpose)
    seen: set[Sdf.Path] = set()  # whose bindings to nothing were said

    def path_of(prim: Usd.Prim, material: UsdShade.Material, fallback: str) -> str:
        if material and material.GetPrim():
            path = str(material.GetPath())
            materials.setdefault(path, material)
            return path
        _report_dangling_bindings(translation, prim, seen)
        if fallback and fallback not in materials:
            materials[fallback] = UsdShade.Material(translation.stage.GetPrimAtPath(fallback))
        return fallback

    at = len(walk.rprims)
    for index, rprim in enumerate(walk.rprims):
        rprim.material = path_of(rprim.prim, bound[index], rprim.context.fallback_material)
        subset_paths = []
        for subset in rprim.subsets:
            subset_paths.append(path_of(subset.GetPrim(), bound[at], rprim.material))
            at += 1
        rprim.subset_materials = tuple(subset_paths)
    return materials


def _report_dangling_bindings(translation: Translation, prim: Usd.Prim, seen: set[Sdf.Path]) -> None:
    """Bindings of the prim, or of one above, to materials that do not exist: each is said once, where it stands."""
    purpose = translation.options.material_purpose
    direct = {"material:binding", f"material:binding:{purpose}"}
    while prim and prim.GetPath() not in seen:
        seen.add(prim.GetPath())
        for relation in prim.GetAuthoredPropertiesInNamespace("material"):
            is_collection = relation.GetName().startswith("material:binding:collection:")
            if relation.GetName() not in direct and not is_collection:
                continue
            for target in relation.GetTargets():
                if target.IsPrimPath() and not UsdShade.Material(translation.stage.GetPrimAtPath(target)):
                    translation.diagnostics.warning(
                        "material-missing",
                        prim.GetPath(),
                        f"the bound material {target} does not exist; the default is used",
                    )
        prim = prim.GetParent()


def _emit(translation: Translation, rprim: Rprim) -> None:
    try:
        rprim.emit(translation, rprim)
    except Exception as error:  # a prim that nobody foresaw must not stop the rest, nor be left out in silence
        translation.diagnostics.error(
            "prim-failed",
            rprim.path,
            f"the prim could not be translated and is left out: {type(error).__name__}: {error}",
        )


def translate(stage: Usd.Stage, options: Options, sink: Sink, diagnostics: Diagnostics) -> Translation:
    """Tells `sink` everything that is drawn at the frame of `options`. Broken prims are reported and left out."""
    translation = Translation(stage, options, sink, diagnostics)
    collecting = gc.isenabled()
    gc.disable()  # a third of the time on large stages, and nothing here makes cycles
    try:
        walk = _Walk(translation)
        walk.run()
        materials = _bind_materials(walk)
        for material in materials.values():
            emit_material(translation, material)
        for rprim in walk.rprims:
            _emit(translation, rprim)
    finally:
        if collecting:
            gc.enable()
    return translation
