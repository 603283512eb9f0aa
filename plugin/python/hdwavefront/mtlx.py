# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""References to .mtlx files where pxr has no UsdMtlx, as in the usd-core wheel.

Such a pxr opens the stage with an empty prim in the reference's place. Each file is converted by the `materialx`
package to an anonymous layer of UsdMtlx's layout (/MaterialX/Materials/<material>), which the session layer references.
Where that cannot be done, a diagnostic says which materials are missing and why.
"""

from __future__ import annotations

import os
import re
from typing import Any

from .errors import Diagnostics

_MTLX_PATH = re.compile(r"Could not open asset @([^@]+?\.mtlx)(?::SDF_FORMAT_ARGS[^@]*)?@")


def missing_mtlx(stage: Any) -> list[tuple[str, str]]:
    """(prim path, file) of each reference or payload to a .mtlx file that could not be composed."""
    found: dict[tuple[str, str], None] = {}
    for error in stage.GetCompositionErrors():
        match = _MTLX_PATH.search(str(error))
        if match:
            found[(str(error.rootSite.path), match.group(1))] = None
    return list(found)


def author_missing_mtlx(stage: Any, diagnostics: Diagnostics) -> None:
    from pxr import Sdf

    layers: dict[str, Any] = {}
    session = stage.GetSessionLayer()
    wanted = []
    for site, file in missing_mtlx(stage):
        prim = stage.GetPrimAtPath(site)
        layer = _layer_for(prim, file, layers)
        if isinstance(layer, str):
            diagnostics.warning(
                "mtlx-reference-unsupported",
                site,
                f"the materials of {file} are missing: this pxr has no UsdMtlx, and {layer}",
            )
        else:
            target = Sdf.Path(_target_path(prim, file) or "/MaterialX")
            wanted.append((Sdf.Path(site), Sdf.Reference(layer.identifier, target)))
            if _LOOKS in layer.customLayerData and target == Sdf.Path("/MaterialX"):
                diagnostics.warning(
                    "mtlx-look-unsupported",
                    site,
                    f"the looks of {file} are not read: what {layer.customLayerData[_LOOKS]} assign is not bound",
                )
    with Sdf.ChangeBlock():
        for path, reference in wanted:
            spec = session.GetPrimAtPath(path) or Sdf.CreatePrimInLayer(session, path)
            # The weakest reference: what the stage says over the materials stays stronger.
            spec.referenceList.appendedItems.append(reference)
    _KEPT_ALIVE.setdefault(session.identifier, []).extend(v for v in layers.values() if not isinstance(v, str))


def _layer_for(prim: Any, file: str, layers: dict[str, Any]) -> Any:
    """The converted file, made once, or in words why there is none."""
    if not prim or prim.IsInstanceProxy() or prim.IsInPrototype():
        return "materials inside instances cannot be replaced"
    if file not in layers:
        try:
            layers[file] = convert_file(file)
        except ImportError:
            layers[file] = "the materialx package is not installed (pip install materialx)"
        except Exception as error:  # whatever the file makes of the parser ends here
            layers[file] = f"the conversion failed: {' '.join(str(error).split())[:200]}"
    return layers[file]


# Where a converted layer says which looks of its document assign materials.
_LOOKS = "looks"

# Anonymous layers live as long as somebody holds them; stages find them by identifier when they recompose.
_KEPT_ALIVE: dict[str, list[Any]] = {}


def _target_path(prim: Any, file: str) -> Any:
    """The path inside the .mtlx file that the broken arc names."""
    for spec in prim.GetPrimStack():
        for arcs in (spec.referenceList, spec.payloadList):
            for arc in arcs.GetAddedOrExplicitItems():
                if arc.assetPath.endswith(".mtlx") and _same_file(spec.layer.ComputeAbsolutePath(arc.assetPath), file):
                    return arc.primPath or None
    return None


def _same_file(a: str, b: str) -> bool:
    return os.path.normpath(a) == os.path.normpath(b)


def convert_file(path: str) -> Any:
    """An anonymous Sdf.Layer with the materials of a .mtlx file. Raises what the materialx package raises."""
    import MaterialX as mx

    document = mx.createDocument()
    search = mx.FileSearchPath(os.path.dirname(os.path.abspath(path)))
    search.append(mx.getDefaultDataSearchPath())
    mx.readFromXmlFile(document, path, search)
    library = _library(mx)
    document.importLibrary(library)
    _flatten_own_nodes(mx, document, library)
    return _Converter(mx, document, path).convert()


_LIBRARY: list[Any] = []


def _library(mx: Any) -> Any:
    if not _LIBRARY:
        library = mx.createDocument()
        mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
        _LIBRARY.append(library)
    return _LIBRARY[0]


def _flatten_own_nodes(mx: Any, document: Any, library: Any) -> None:
    """Nodes that the file defines itself by graphs become the nodes of those graphs: nobody else knows their names."""

    def is_own(node: Any) -> bool:
        definition = node.getNodeDef()
        return definition is not None and library.getNodeDef(definition.getName()) is None

    for graph in [document, *document.getNodeGraphs()]:
        if graph is not document and (library.getNodeGraph(graph.getName()) is not None or graph.getNodeDef()):
            continue
        if any(is_own(node) for node in graph.getNodes()):
            graph.flattenSubgraphs("", is_own)


class _Converter:
    """One document to one layer."""

    def __init__(self, mx: Any, document: Any, path: str) -> None:
        from pxr import Sdf, Usd

        self._mx = mx
        self._document = document
        self._folder = os.path.dirname(os.path.abspath(path))
        self._layer = Sdf.Layer.CreateAnonymous(os.path.basename(path) + ".usda")
        self._stage = Usd.Stage.Open(self._layer)
        names = Sdf.ValueTypeNames
        self._types = {
            "float": names.Float,
            "integer": names.Int,
            "boolean": names.Bool,
            "string": names.String,
            "filename": names.Asset,
            "color3": names.Color3f,
            "color4": names.Color4f,
            "vector2": names.Float2,
            "vector3": names.Float3,
            "vector4": names.Float4,
            "matrix33": names.Matrix3d,
            "matrix44": names.Matrix4d,
        }

    def convert(self) -> Any:
        from pxr import UsdGeom

        root = UsdGeom.Scope.Define(self._stage, "/MaterialX")
        self._stage.SetDefaultPrim(root.GetPrim())
        UsdGeom.Scope.Define(self._stage, "/MaterialX/Materials")
        for node in self._document.getMaterialNodes():
            self._material(node)
        looks = [look.getName() for look in self._document.getLooks() if look.getMaterialAssigns()]
        if looks:
            self._layer.customLayerData = {_LOOKS: ", ".join(looks)}
        return self._layer

    def _material(self, node: Any) -> None:
        from pxr import UsdShade

        path = f"/MaterialX/Materials/{node.getName()}"
        material = UsdShade.Material.Define(self._stage, path)
        outputs = {
            "surfaceshader": material.CreateSurfaceOutput,
            "displacementshader": material.CreateDisplacementOutput,
            "volumeshader": material.CreateVolumeOutput,
        }
        for name, create in outputs.items():
            terminal = node.getInput(name)
            source = terminal.getConnectedNode() if terminal is not None else None
            if source is None:
                continue
            shader = self._shader(source, path)
            create("mtlx").ConnectToSource(shader.ConnectableAPI(), terminal.getOutputString() or "out")
            self._promote(material, shader)

    def _promote(self, material: Any, shader: Any) -> None:
        """Values of the surface become inputs of the material, as UsdMtlx has it, so that stages may override them."""
        for shader_input in shader.GetInputs():
            attribute = shader_input.GetAttr()
            if shader_input.HasConnectedSource() or not attribute.HasAuthoredValue():
                continue
            public = material.CreateInput(shader_input.GetBaseName(), shader_input.GetTypeName())
            public.Set(attribute.Get())
            if attribute.HasColorSpace():
                public.GetAttr().SetColorSpace(attribute.GetColorSpace())
            attribute.Clear()
            shader_input.ConnectToSource(public)

    def _shader(self, node: Any, parent: str) -> Any:
        """The node's Shader prim under `parent`, made with all above it at the first call."""
        from pxr import UsdShade

        path = f"{parent}/{node.getName()}"
        known = self._stage.GetPrimAtPath(path)
        if known and known.IsA(UsdShade.Shader):
            return UsdShade.Shader(known)
        shader = UsdShade.Shader.Define(self._stage, path)
        definition = node.getNodeDef()
        shader.CreateIdAttr(definition.getName() if definition is not None else node.getCategory())
        for node_input in node.getInputs():
            self._input(shader, node_input, parent)
        return shader

    def _input(self, owner: Any, node_input: Any, parent: str) -> None:
        """An input of a shader or node graph whose sources stand below `parent`."""
        kind = self._types.get(node_input.getType())
        interface = node_input.getInterfaceName()
        graph_name = node_input.getNodeGraphString()
        source = None if interface or graph_name else node_input.getConnectedNode()
        if kind is None:
            from pxr import Sdf

            kind = Sdf.ValueTypeNames.Token  # closures and shaders: only connections
        usd_input = owner.CreateInput(node_input.getName(), kind)
        if interface:
            from pxr import UsdShade

            container = UsdShade.NodeGraph(self._stage.GetPrimAtPath(parent))
            public = container.GetInput(interface)
            if public:
                usd_input.ConnectToSource(public)
                return
        if graph_name:
            graph = self._graph(graph_name, parent)
            if graph is not None:
                output = node_input.getOutputString() or "out"
                usd_input.ConnectToSource(graph.ConnectableAPI(), output)
                return
        if source is not None:
            shader = self._shader(source, parent)
            usd_input.ConnectToSource(shader.ConnectableAPI(), node_input.getOutputString() or "out")
            return
        self._value(usd_input, node_input)

    def _graph(self, name: str, parent: str) -> Any:
        """A copy of the document's node graph inside the material: references may take in single materials."""
        from pxr import UsdShade

        graph = self._document.getNodeGraph(name)
        if graph is None:
            return None
        path = f"{parent}/{name}"
        known = self._stage.GetPrimAtPath(path)
        if known:
            return UsdShade.NodeGraph(known)
        usd_graph = UsdShade.NodeGraph.Define(self._stage, path)
        for node_input in graph.getInputs():
            self._input(usd_graph, node_input, parent)
        for output in graph.getOutputs():
            source = output.getConnectedNode()
            usd_output = usd_graph.CreateOutput(output.getName(), self._types.get(output.getType()) or _token())
            if source is not None:
                shader = self._shader(source, path)
                usd_output.ConnectToSource(shader.ConnectableAPI(), output.getOutputString() or "out")
        return usd_graph

    def _value(self, usd_input: Any, node_input: Any) -> None:
        kind = node_input.getType()
        if not node_input.hasValueString():
            return
        if kind == "filename":
            from pxr import Sdf

            file = node_input.getResolvedValueString()
            path = file if "://" in file else os.path.normpath(os.path.join(self._folder, file))
            usd_input.Set(Sdf.AssetPath(path))
        else:
            value = _usd_value(kind, node_input)
            if value is None:
                return
            usd_input.Set(value)
        space = node_input.getActiveColorSpace()
        if space and kind in ("filename", "color3", "color4"):
            # What a file inherits from its document says nothing about its pixels unless its node gives a colour.
            if kind == "filename" and node_input.getParent().getType() not in ("color3", "color4"):
                return
            usd_input.GetAttr().SetColorSpace(space)


def _token() -> Any:
    from pxr import Sdf

    return Sdf.ValueTypeNames.Token


def _usd_value(kind: str, node_input: Any) -> Any:
    from pxr import Gf

    text = node_input.getValueString()
    if kind == "string":
        return text
    if kind == "boolean":
        return text.strip().lower() == "true"
    try:
        numbers = [float(x) for x in text.replace(",", " ").split()]
    except ValueError:
        return None
    makers = {
        "float": (1, lambda v: v[0]),
        "integer": (1, lambda v: int(v[0])),
        "color3": (3, lambda v: Gf.Vec3f(*v)),
        "color4": (4, lambda v: Gf.Vec4f(*v)),
        "vector2": (2, lambda v: Gf.Vec2f(*v)),
        "vector3": (3, lambda v: Gf.Vec3f(*v)),
        "vector4": (4, lambda v: Gf.Vec4f(*v)),
        "matrix33": (9, lambda v: Gf.Matrix3d(*v)),
        "matrix44": (16, lambda v: Gf.Matrix4d(*v)),
    }
    if kind not in makers or len(numbers) != makers[kind][0]:
        return None
    return makers[kind][1](numbers)
