# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Puts converted .mtlx files in the place of a stage's references and payloads to them.

The session layer says that each prim with such an arc specializes what the file holds. Specializing is USD's weakest
arc: whatever the stage and the layers it references say over the materials stays stronger, at any depth of references.
Prims inside of instances cannot be spoken of; there the instances themselves specialize an over that leads to the prim.
"""

from __future__ import annotations

import os
import re
import weakref
from typing import Any

from pxr import Sdf, UsdGeom

from ..errors import Diagnostics
from .convert import convert_file
from .looks import VARIANT_SET

# "Could not open asset @a.mtlx@ for reference ..." where pxr has no UsdMtlx, "Asset @a.mtlx@ was muted for ..." else,
# and "Unresolved reference prim path @a.mtlx@</...>" where UsdMtlx makes no such prim.
_BROKEN_ARC = re.compile(r"(?:[Aa]sset|prim path) @([^@]+?\.mtlx\]?)(?::SDF_FORMAT_ARGS[^@]*)?@[ <]")
_HOLDER = Sdf.Path("/__hdWavefrontMaterialX")

# Anonymous layers live as long as somebody holds them; a stage finds them by identifier when it recomposes.
_REPLACEMENTS: weakref.WeakKeyDictionary[Any, _Replacements] = weakref.WeakKeyDictionary()


def replace_references(stage: Any, diagnostics: Diagnostics) -> None:
    """Makes materials of all .mtlx files that the stage refers to now. To be called again where the stage changed."""
    _mute(stage)
    arcs = _broken_arcs(stage)
    arcs += [("/", file) for file in _own_sublayers(stage, diagnostics)]
    known = _REPLACEMENTS.get(stage)
    if known is None:
        if not arcs:
            return
        known = _REPLACEMENTS[stage] = _Replacements(stage)
    known.update(stage, arcs, diagnostics)


def _mute(stage: Any) -> None:
    """Makes the arcs to .mtlx files that this pxr did read look like those of one that cannot."""
    layers = [layer.identifier for layer in stage.GetUsedLayers() if layer.GetFileFormat().formatId == "mtlx"]
    if layers:
        stage.MuteAndUnmuteLayers(layers, [])


def _broken_arcs(stage: Any) -> list[tuple[str, str]]:
    """(prim path, file) of each reference or payload to a .mtlx file."""
    found: dict[tuple[str, str], None] = {}
    for error in stage.GetCompositionErrors():
        match = _BROKEN_ARC.search(str(error))
        if match:
            found[(str(error.rootSite.path), match.group(1))] = None
    return list(found)


def _sublayers(layers: list[Any]) -> dict[str, str]:
    """.mtlx files that are sublayers of `layers`, and of which."""
    return {
        layer.ComputeAbsolutePath(path): layer.identifier
        for layer in layers
        for path in layer.subLayerPaths
        if path.endswith(".mtlx")
    }


def _own_sublayers(stage: Any, diagnostics: Diagnostics) -> list[str]:
    """Those of the layers that the stage itself consists of; others are said."""
    own = _sublayers(stage.GetLayerStack())
    for file, layer in _sublayers(stage.GetUsedLayers()).items():
        if file not in own:
            diagnostics.warning(
                "mtlx-reference-unsupported",
                layer,
                f"the sublayer {file} is left out: .mtlx files are read where they are referenced, and as sublayers of "
                "the stage's own layers",
            )
    return list(own)


class _Replacements:
    """What one stage has in place of its .mtlx files."""

    def __init__(self, stage: Any) -> None:
        self._session = stage.GetSessionLayer()
        self._meters_per_unit = UsdGeom.GetStageMetersPerUnit(stage)
        self._layers: dict[str, Any] = {}  # of files: a layer, or in words why there is none
        self._said: dict[str, list[tuple[str, str]]] = {}
        self._arcs: list[tuple[str, str]] = []
        self._authored: list[tuple[Any, Any]] = []

    def update(self, stage: Any, arcs: list[tuple[str, str]], diagnostics: Diagnostics) -> None:
        if arcs == self._arcs:
            return
        self._arcs = arcs
        wanted: dict[tuple[Any, Any], None] = {}
        holder = _Holder()
        for site, file in arcs:
            layer = self._layer_for(file)
            if isinstance(layer, str):
                diagnostics.warning("mtlx-reference-unsupported", site, f"the materials of {file} are missing: {layer}")
                continue
            for code, text in self._said.pop(file, ()):  # once, at the first prim that refers to the file
                diagnostics.warning(code, site, f"{file}: {text}")
            if site == "/":  # a sublayer: its prims stand where they are
                for spec in layer.rootPrims:
                    wanted[(spec.path, holder.add(layer, spec.path))] = None
                continue
            prim = stage.GetPrimAtPath(site)
            for target in _targets(prim, file) or [layer.GetPrimAtPath(f"/{layer.defaultPrim}").path]:
                if not layer.GetPrimAtPath(target):
                    diagnostics.warning("mtlx-reference-unsupported", site, f"there is no {target} in {file}")
                    continue
                source = holder.add(layer, target)
                for path, specialized in _in_instances(stage, prim, source, holder):
                    wanted[(path, specialized)] = None
                if layer.GetPrimAtPath(target).variantSets.get(VARIANT_SET) and not _look_of(prim):
                    diagnostics.info(
                        "mtlx-look-unselected",
                        site,
                        f"no look of {file} is chosen: {VARIANT_SET} may be "
                        + ", ".join(layer.GetPrimAtPath(target).variantSets[VARIANT_SET].variants.keys()),
                    )
        self._author(holder, list(wanted))

    def _layer_for(self, file: str) -> Any:
        if file not in self._layers:
            self._said[file] = []
            self._layers[file] = _convert(file, self._said[file], self._meters_per_unit)
        return self._layers[file]

    def _author(self, holder: _Holder, wanted: list[tuple[Any, Any]]) -> None:
        with Sdf.ChangeBlock():
            for path, source in self._authored:
                spec = self._session.GetPrimAtPath(path)
                if spec:
                    spec.specializesList.RemoveItemEdits(source)
            self._authored = wanted
            holder.write(self._session)
            for path, source in wanted:
                spec = self._session.GetPrimAtPath(path) or Sdf.CreatePrimInLayer(self._session, path)
                spec.specializesList.appendedItems.append(source)


def _convert(file: str, said: list[tuple[str, str]], meters_per_unit: float) -> Any:
    try:
        return convert_file(file, lambda code, text: said.append((code, text)), meters_per_unit)
    except ImportError:
        return "the materialx package is not installed (pip install materialx)"
    except Exception as error:  # whatever the file makes of the parser ends here
        return f"the file cannot be read: {' '.join(str(error).split())[:200]}"


class _Holder:
    """Prims of the session layer that others specialize: abstract, so that nobody draws them."""

    def __init__(self) -> None:
        self._sources: dict[tuple[str, Any], Any] = {}
        self._overs: dict[tuple[Any, Any], Any] = {}

    def add(self, layer: Any, target: Any) -> Any:
        """A prim that is `target` of `layer`."""
        key = (layer.identifier, Sdf.Path(target))
        return self._sources.setdefault(key, _HOLDER.AppendChild(f"file{len(self._sources)}"))

    def add_over(self, relative: Any, source: Any) -> Any:
        """A prim whose descendant at the path `relative` specializes `source`."""
        return self._overs.setdefault((relative, source), _HOLDER.AppendChild(f"over{len(self._overs)}"))

    def write(self, session: Any) -> None:
        if session.GetPrimAtPath(_HOLDER):
            del session.rootPrims[_HOLDER.name]
        if not self._sources:
            return
        Sdf.CreatePrimInLayer(session, _HOLDER).specifier = Sdf.SpecifierClass
        for (identifier, target), path in self._sources.items():
            Sdf.CreatePrimInLayer(session, path).referenceList.explicitItems = [Sdf.Reference(identifier, target)]
        for (relative, source), path in self._overs.items():
            inner = Sdf.CreatePrimInLayer(session, path.AppendPath(relative))
            inner.specializesList.explicitItems = [source]


def _in_instances(stage: Any, prim: Any, source: Any, holder: _Holder) -> list[tuple[Any, Any]]:
    """Which prims must specialize what for `prim` to be `source`: itself, or all instances that hold it."""
    found: list[tuple[Any, Any]] = []
    pending = [(prim, source)]
    seen = set()
    while pending:
        prim, source = pending.pop()
        if (prim.GetPath(), source) in seen:
            continue
        seen.add((prim.GetPath(), source))
        instance = prim.GetParent() if prim.IsInstanceProxy() or prim.IsInPrototype() else None
        while instance and not instance.IsInstance() and not instance.IsPrototype():
            instance = instance.GetParent()
        if not instance:
            found.append((prim.GetPath(), source))
            continue
        relative = prim.GetPath().MakeRelativePath(instance.GetPath())
        over = holder.add_over(relative, source)
        prototype = instance if instance.IsPrototype() else instance.GetPrototype()
        pending += [(other, over) for other in prototype.GetInstances()]
    return found


def _look_of(prim: Any) -> str:
    """As authored: the variant set itself is in the file."""
    selections = (spec.variantSelections.get(VARIANT_SET) for spec in prim.GetPrimStack())
    return next((s for s in selections if s), "")


def _targets(prim: Any, file: str) -> list[Any]:
    """The paths inside of the file that the prim's arcs to it name; none where they name none."""
    found: dict[Any, None] = {}
    for spec in prim.GetPrimStack():
        for arcs in (spec.referenceList, spec.payloadList):
            for arc in arcs.GetAddedOrExplicitItems():
                if ".mtlx" in arc.assetPath and _is_same_file(spec.layer.ComputeAbsolutePath(arc.assetPath), file):
                    if arc.primPath:
                        found[arc.primPath] = None
    return list(found)


def _is_same_file(a: str, b: str) -> bool:
    return os.path.normpath(a) == os.path.normpath(b)
