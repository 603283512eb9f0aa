# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Looks, collections and variants of a .mtlx document, laid out as UsdMtlx does it.

/MaterialX/Collections             a collection for each of the document's, and for each geometry that a look names
/MaterialX/Looks/<look>            bindings to those collections, of the materials under it; inherits by reference
/MaterialX/Looks/<look>/Materials/<assignment>   the material, with the variants that the look assigns
/ModelRoot                         a variant set LookVariant: stages reference it above their geometry, and choose

Geometry is named from the prim that references /ModelRoot. Beyond UsdMtlx: "*" means all of it, a look group is one
more variant (of its default look, or its first), and a material has every variant whose inputs it has.
"""

from __future__ import annotations

from typing import Any

from pxr import Sdf, Tf

from .document import Say
from .values import TYPES, usd_value

_COLLECTIONS = Sdf.Path("/MaterialX/Collections")
_LOOKS = Sdf.Path("/MaterialX/Looks")
_BASES = Sdf.Path("/MaterialX/Bases")
_MODEL = Sdf.Path("/ModelRoot")
VARIANT_SET = "LookVariant"


def write_looks(layer: Any, document: Any, materials: dict[str, Any], say: Say) -> bool:
    """`materials`: paths by name in the document. False where the document has no look."""
    looks = document.getLooks()
    if not looks:
        return False
    writer = _LookWriter(layer, document, materials, say)
    writer.variants()
    writer.collections()
    for look in looks:
        writer.look(look)
    writer.model()
    return True


def _name(element: Any) -> str:
    return Tf.MakeValidIdentifier(element.getName().replace(":", "__"))


def _names(text: str) -> list[str]:
    return [part for part in text.replace(",", " ").split() if part]


class _LookWriter:
    def __init__(self, layer: Any, document: Any, materials: dict[str, Any], say: Say) -> None:
        self._layer = layer
        self._document = document
        self._materials = materials
        self._say = say
        self._of_geometry: dict[tuple[str, ...], str] = {}

    def _prim(self, path: Any) -> Any:
        for prefix in path.GetPrefixes():
            spec = Sdf.CreatePrimInLayer(self._layer, prefix)
            spec.specifier = Sdf.SpecifierDef
        return spec

    # -- Variants: values of material inputs

    def variants(self) -> None:
        for path in self._materials.values():
            material = self._layer.GetPrimAtPath(path)
            for variant_set in self._document.getVariantSets():
                self._variant_set(material, variant_set)

    def _variant_set(self, material: Any, variant_set: Any) -> None:
        spec = None
        for variant in variant_set.getVariants():
            known = [p for p in variant.getInputs() if material.attributes.get(f"inputs:{p.getName()}")]
            if not known:
                continue
            if spec is None:
                spec = Sdf.VariantSetSpec(material, _name(variant_set))
                material.variantSetNameList.prependedItems.append(spec.name)
            prim = Sdf.VariantSpec(spec, _name(variant)).primSpec
            for port in known:
                value = usd_value(port.getType(), port.getAttribute("value"))
                if value is None:
                    self._say("mtlx-bad-value", f"{port.getNamePath()} has no value that is a {port.getType()}")
                    continue
                self._weaken(material, f"inputs:{port.getName()}")
                attribute = Sdf.AttributeSpec(prim, f"inputs:{port.getName()}", TYPES[port.getType()])
                attribute.default = value
                if port.getActiveColorSpace() and port.getType() in ("color3", "color4"):
                    attribute.SetInfo("colorSpace", port.getActiveColorSpace())

    def _weaken(self, material: Any, name: str) -> None:
        """Moves a material's value below its variants, which count less than what stands on the prim itself."""
        attribute = material.attributes.get(name)
        if attribute is None or not attribute.HasInfo("default"):
            return
        base = self._prim(_BASES.AppendChild(material.name))
        Sdf.CopySpec(self._layer, attribute.path, self._layer, base.path.AppendProperty(name))
        attribute.ClearInfo("default")
        attribute.ClearInfo("colorSpace")
        material.referenceList.explicitItems = [Sdf.Reference("", base.path)]

    # -- Collections

    def collections(self) -> None:
        for collection in self._document.getCollections():
            prefix = collection.getActiveGeomPrefix()
            includes = [p for g in _names(collection.getIncludeGeom()) if (p := self._geometry(prefix + g, collection))]
            excludes = [p for g in _names(collection.getExcludeGeom()) if (p := self._geometry(prefix + g, collection))]
            for name in _names(collection.getIncludeCollectionString()):
                other = self._document.getCollection(name)
                if other is None or collection.hasIncludeCycle():
                    self._say(
                        "mtlx-bad-reference",
                        f"collection {collection.getName()} includes {name}, which "
                        + ("does not exist" if other is None else "closes a cycle"),
                    )
                else:
                    includes.append(_COLLECTIONS.AppendProperty(f"collection:{_name(other)}"))
            self._collection(_name(collection), includes, excludes)

    def _geometry(self, text: str, element: Any) -> Any:
        """The path below the collections' prim, which stands for the referencing prim, of a geometry; None: no name."""
        text = text.strip()
        if text in ("*", "/", "/*", "//*"):
            return _COLLECTIONS
        relative = text.strip("/")
        if not Sdf.Path.IsValidPathString(relative) or not Sdf.Path(relative).IsPrimPath():
            self._say(
                "mtlx-geometry-unsupported",
                f"{element.getNamePath()} names geometry by the expression '{text}'; only paths and * are read",
            )
            return None
        return Sdf.Path(relative).MakeAbsolutePath(_COLLECTIONS)

    def _collection(self, name: str, includes: list[Any], excludes: list[Any]) -> None:
        prim = self._prim(_COLLECTIONS)
        _apply(prim, f"CollectionAPI:{name}")
        rule = Sdf.AttributeSpec(
            prim, f"collection:{name}:expansionRule", Sdf.ValueTypeNames.Token, Sdf.VariabilityUniform
        )
        rule.default = "expandPrims"
        for kind, targets in (("includes", includes), ("excludes", excludes)):
            if targets:
                relation = Sdf.RelationshipSpec(prim, f"collection:{name}:{kind}", False)
                relation.targetPathList.explicitItems = targets

    def _collection_of(self, assignment: Any) -> str | None:
        """The name of the collection that an assignment is for; empty: none is named, so all of the model."""
        if name := assignment.getCollectionString():
            if self._document.getCollection(name) is not None:
                return _name(self._document.getCollection(name))
            self._say("mtlx-bad-reference", f"{assignment.getNamePath()} names collection {name}, which does not exist")
            return None
        prefix = assignment.getActiveGeomPrefix()
        geometry = tuple(sorted({prefix + g for g in _names(assignment.getAttribute("geom"))}))
        if not geometry:
            return ""
        if geometry not in self._of_geometry:
            name = f"geom_{len(self._of_geometry) + 1}"
            while self._document.getCollection(name) is not None:
                name += "_"
            self._of_geometry[geometry] = name
            self._collection(name, [p for g in geometry if (p := self._geometry(g, assignment))], [])
        return self._of_geometry[geometry]

    # -- Looks

    def look(self, look: Any) -> None:
        path = _LOOKS.AppendChild(_name(look))
        prim = self._prim(path)
        _apply(prim, "MaterialBindingAPI")
        references = [Sdf.Reference("", _COLLECTIONS)]
        if base := look.getInheritString():
            if self._document.getLook(base) is None or look.hasInheritanceCycle():
                self._say("mtlx-bad-reference", f"look {look.getName()} inherits from {base}, which it cannot")
            else:
                references.insert(0, Sdf.Reference("", _LOOKS.AppendChild(_name(self._document.getLook(base)))))
        self._prim(_COLLECTIONS)
        prim.referenceList.prependedItems = references
        order = []
        for assignment in look.getMaterialAssigns():
            collection = self._collection_of(assignment)
            material = self._materials.get(assignment.getMaterial())
            if material is None:
                self._say(
                    "mtlx-bad-reference",
                    f"{assignment.getNamePath()} assigns material {assignment.getMaterial()}, which does not exist",
                )
            if assignment.hasAttribute("exclusive") and not assignment.getExclusive():
                self._say(
                    "mtlx-look-unsupported",
                    f"{assignment.getNamePath()} is not exclusive; it is read as if it were: geometry has one material",
                )
            if collection is not None and material is not None:
                order.append(self._bind(prim, look, assignment, collection, material))
        # The first binding that matches counts: the look's own, in their order, before those that it inherits.
        inherited = [a for base in self._chain(look)[1:] for a in base.getMaterialAssigns()]
        prim.SetInfo("propertyOrder", [*order, *(f"material:binding:collection:{_name(a)}" for a in inherited)])
        for unread in (*look.getVisibilities(), *look.getPropertyAssigns(), *look.getPropertySetAssigns()):
            self._say(
                "mtlx-look-unsupported",
                f"{unread.getNamePath()}: a {unread.getCategory()} of a look is not read; the stage's own counts",
            )

    def _chain(self, look: Any) -> list[Any]:
        """The look and those that it inherits from, nearest first."""
        chain = [look]
        while (base := self._document.getLook(chain[-1].getInheritString())) is not None and base not in chain:
            chain.append(base)
        return chain

    def _bind(self, prim: Any, look: Any, assignment: Any, collection: str, material: Any) -> str:
        name = _name(assignment)
        while self._layer.GetPrimAtPath(prim.path.AppendPath(f"Materials/{name}")):
            name += "_"
        path = prim.path.AppendPath(f"Materials/{name}")
        bound = self._prim(path)
        bound.referenceList.prependedItems = [Sdf.Reference("", material)]
        # Inherited ones first, the assignment's own last: the last one counts.
        holders = [*reversed(self._chain(look)), assignment]
        for choice in (c for h in holders for c in h.getChildren() if c.getCategory() == "variantassign"):
            variant_set = Tf.MakeValidIdentifier(choice.getAttribute("variantset"))
            if variant_set in self._layer.GetPrimAtPath(material).variantSets:
                bound.variantSelections[variant_set] = Tf.MakeValidIdentifier(choice.getAttribute("variant"))
        if not collection:
            relation = Sdf.RelationshipSpec(prim, "material:binding", False)
            relation.targetPathList.explicitItems = [path]
        else:
            relation = Sdf.RelationshipSpec(prim, f"material:binding:collection:{name}", False)
            relation.targetPathList.explicitItems = [prim.path.AppendProperty(f"collection:{collection}"), path]
        return str(relation.name)

    # -- The model

    def model(self) -> None:
        prim = self._prim(_MODEL)
        looks = Sdf.VariantSetSpec(prim, VARIANT_SET)
        prim.variantSetNameList.prependedItems.append(VARIANT_SET)
        choices = {look.getName(): look for look in self._document.getLooks()}
        for group in self._document.getLookGroups():
            names = [*_names(group.getAttribute("default")), *_names(group.getLooks())]
            chosen = next((choices[n] for n in names if n in choices), None)
            if chosen is None:
                self._say("mtlx-bad-reference", f"look group {group.getName()} names no look that exists")
            else:
                choices.setdefault(group.getName(), chosen)
        for name, look in choices.items():
            variant = Sdf.VariantSpec(looks, Tf.MakeValidIdentifier(name.replace(":", "__"))).primSpec
            variant.referenceList.prependedItems = [Sdf.Reference("", _LOOKS.AppendChild(_name(look)))]


def _apply(prim: Any, schema: str) -> None:
    known = prim.GetInfo("apiSchemas") if prim.HasInfo("apiSchemas") else Sdf.TokenListOp()
    prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[*known.prependedItems, schema]))
