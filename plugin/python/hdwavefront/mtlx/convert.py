# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""A .mtlx document as a layer, laid out as UsdMtlx does it.

/MaterialX/Materials/<material>                   Material; its shaders' inputs are its own, for stages to override
/MaterialX/Materials/<material>/<shader>          Shader, a terminal or what feeds one
/MaterialX/Materials/<material>/NodeGraphs/<node> nodes that stand in no graph of the document
/MaterialX/Materials/<material>/<graph>/<node>    nodes of the document's graphs
A document without materials gets some: see document.py.
/MaterialX/Collections, /MaterialX/Looks, /ModelRoot: see looks.py
"""

from __future__ import annotations

import os
from typing import Any

from pxr import Sdf, Tf

from .document import Say, read_document
from .looks import write_looks
from .units import Units
from .values import OPAQUE_TYPE, TYPES, usd_value

MATERIALS = Sdf.Path("/MaterialX/Materials")
_TERMINALS = {"surfaceshader": "surface", "displacementshader": "displacement", "volumeshader": "volume"}
_BACK = "backsurfaceshader"
_SHADER_TYPES = _TERMINALS.keys() | {"lightshader"}


def convert_file(path: str, say: Say = lambda code, text: None, meters_per_unit: float = 1.0) -> Any:
    """An anonymous Sdf.Layer with what a .mtlx file holds, for stages of that metersPerUnit. Raises what the materialx
    package and resolvers raise.
    """
    document = read_document(path, say)
    units = Units(document, document.getDataLibrary(), meters_per_unit)
    layer = Sdf.Layer.CreateAnonymous(os.path.basename(path) + ".usda")
    _prim(layer, Sdf.Path("/MaterialX"))
    _prim(layer, MATERIALS)
    materials = {}
    for node in document.getMaterialNodes():
        writer = _MaterialWriter(layer, document, node, say, units)
        materials[node.getName()] = writer.write()
    _write_inherits(layer, document, materials, say)
    has_looks = write_looks(layer, document, materials, say)
    layer.defaultPrim = "ModelRoot" if has_looks else "MaterialX"
    return layer


def usd_name(element: Any) -> str:
    """A name that USD takes; namespaces become a prefix."""
    return Tf.MakeValidIdentifier(element.getName().replace(":", "__"))


def _port(kind: str, name: str) -> str:
    return f"{kind}:{name if Sdf.Path.IsValidNamespacedIdentifier(name) else Tf.MakeValidIdentifier(name)}"


def _prim(layer: Any, path: Any, type_name: str = "") -> Any:
    spec = Sdf.CreatePrimInLayer(layer, path)
    spec.specifier = Sdf.SpecifierDef
    if type_name:
        spec.typeName = type_name
    return spec


def _attribute(prim: Any, name: str, kind: Any) -> Any:
    return prim.attributes.get(name) or Sdf.AttributeSpec(prim, name, kind)


def _write_inherits(layer: Any, document: Any, materials: dict[str, Any], say: Say) -> None:
    for node in document.getMaterialNodes():
        base = node.getInheritString()
        if not base:
            continue
        if base in materials:
            layer.GetPrimAtPath(materials[node.getName()]).specializesList.prependedItems = [materials[base]]
        else:
            say("mtlx-bad-reference", f"material {node.getName()} inherits from {base}, which does not exist")


class _MaterialWriter:
    """One material, and copies of all nodes and graphs that it needs: stages may reference single materials."""

    def __init__(self, layer: Any, document: Any, node: Any, say: Say, units: Units) -> None:
        self._layer = layer
        self._document = document
        self._node = node
        self._say = say
        self._units = units
        self._root = MATERIALS.AppendChild(usd_name(node))
        self._paths: dict[str, Any] = {}  # element's name path -> prim path, of what is written or pending
        self._pending: list[tuple[Any, Any]] = []

    def write(self) -> Any:
        material = _prim(self._layer, self._root, "Material")
        terminals = self._terminals()
        for name, terminal in terminals.items():
            source = self._source(terminal, name)
            if source is not None:
                _attribute(material, f"outputs:mtlx:{name}", OPAQUE_TYPE).connectionPathList.explicitItems = [source]
        self._write_pending()
        for terminal in terminals.values():
            if not terminal.getNodeGraphString():
                self._promote(material, terminal.getConnectedNode())
        return self._root

    def _terminals(self) -> dict[str, Any]:
        """The material's inputs by the terminals that they are: by their names, which MaterialX's material nodes share
        with the types. Of a studio's own material nodes, the first of a type.
        """
        found: dict[str, Any] = {}
        shaders = [p for p in self._node.getInputs() if p.getType() in _TERMINALS]
        for port in sorted(shaders, key=lambda p: p.getName() != p.getType()):  # sorting keeps the order of equals
            name = _TERMINALS[port.getType()]
            if port.getName() != _BACK and name not in found:
                found[name] = port
            elif port.getNodeName() or port.getNodeGraphString() or port.getOutputString():
                what = f"material {self._node.getName()}: its {port.getName()} is not read"
                shown = "; both sides have the surfaceshader" if port.getName() == _BACK else ""
                self._say("mtlx-unsupported", what + shown)
        return found

    def _write_pending(self) -> None:
        while self._pending:
            element, path = self._pending.pop()
            prim = self._layer.GetPrimAtPath(path)
            for element_input in element.getInputs():
                self._input(prim, element, element_input)
            if prim.typeName == "NodeGraph":
                self._graph_outputs(prim, element)

    def _place(self, element: Any) -> Any:
        """The path of a node's or graph's prim, which is written later if it is new."""
        key = element.getNamePath()
        known = self._paths.get(key)
        if known is not None:
            return known
        parent = element.getParent()
        is_graph = element.getCategory() == "nodegraph"
        if not is_graph and parent.getCategory() == "nodegraph":
            base = self._place(parent)
        elif is_graph or element.getType() in _SHADER_TYPES:
            base = self._root
        else:
            base = self._root.AppendChild("NodeGraphs")
            if not self._layer.GetPrimAtPath(base):
                _prim(self._layer, base)
        path = base.AppendChild(usd_name(element))
        while self._layer.GetPrimAtPath(path):  # names that differ in MaterialX may be one in USD
            path = path.ReplaceName(path.name + "_")
        self._paths[key] = path
        prim = _prim(self._layer, path, "NodeGraph" if is_graph else "Shader")
        if not is_graph:
            definition = element.getNodeDef()
            identifier = definition.getName() if definition is not None else element.getCategory()
            spec = Sdf.AttributeSpec(prim, "info:id", Sdf.ValueTypeNames.Token, Sdf.VariabilityUniform)
            spec.default = identifier
        self._pending.append((element, path))
        return path

    def _input(self, prim: Any, element: Any, element_input: Any) -> None:
        kind = element_input.getType()
        attribute = _attribute(prim, _port("inputs", element_input.getName()), TYPES.get(kind, OPAQUE_TYPE))
        source = self._source(element_input)
        if source is not None:
            attribute.connectionPathList.explicitItems = [source]
            if kind == "filename":
                self._color_space(attribute, element, element_input)
        else:
            self._value(attribute, element, element_input)

    def _source(self, port: Any, terminal: str = "") -> Any:
        """The path of the output or interface input that feeds an input or output; None where nothing does."""
        parent = port.getParent()
        if interface := port.getInterfaceName():
            graph = parent if parent.getCategory() == "nodegraph" else parent.getParent()
            if graph.getCategory() == "nodegraph" and graph.getInput(interface) is not None:
                return self._place(graph).AppendProperty(_port("inputs", interface))
            return self._nothing(port, f"interface input {interface}")
        if name := port.getNodeGraphString():
            graph = self._document.getNodeGraph(name)
            if graph is None:
                return self._nothing(port, f"graph {name}")
            output = port.getOutputString() or next((o.getName() for o in graph.getOutputs()), "out")
            if graph.getOutput(output) is None:
                return self._nothing(port, f"output {output} of graph {name}")
            return self._place(graph).AppendProperty(_port("outputs", output))
        if not port.getNodeName() and not port.getOutputString():
            return None
        node = port.getConnectedNode()
        if node is None:
            return self._nothing(port, f"node {port.getNodeName() or port.getOutputString()}")
        inner = None if port.getNodeName() else port.getConnectedOutput()  # an output of the document names the node
        output = (inner if inner is not None else port).getOutputString()
        name = _port("outputs", self._output_name(node, output, terminal))
        prim = self._layer.GetPrimAtPath(self._place(node))
        return _attribute(prim, name, TYPES.get(port.getType(), OPAQUE_TYPE)).path

    def _output_name(self, node: Any, output: str, terminal: str) -> str:
        definition = node.getNodeDef()
        outputs = [o.getName() for o in definition.getActiveOutputs()] if definition is not None else []
        if len(outputs) > 1:
            return output or outputs[0]
        return terminal or (outputs[0] if outputs else output or "out")

    def _nothing(self, port: Any, what: str) -> None:
        self._say("mtlx-bad-connection", f"{port.getNamePath()} is connected to {what}, which does not exist")

    def _graph_outputs(self, prim: Any, graph: Any) -> None:
        for output in graph.getOutputs():
            attribute = _attribute(prim, _port("outputs", output.getName()), TYPES.get(output.getType(), OPAQUE_TYPE))
            source = self._source(output)
            if source is not None:
                attribute.connectionPathList.explicitItems = [source]

    def _value(self, attribute: Any, element: Any, element_input: Any) -> None:
        if not element_input.hasAttribute("value"):
            return
        kind, text = element_input.getType(), element_input.getAttribute("value")
        value = usd_value(kind, text)
        if value is None:
            if text:
                where = element_input.getNamePath()
                self._say("mtlx-bad-value", f"{where} has a value that is no {kind}: {text[:60]!r}; it is left out")
            return
        factor = self._units.factor(element, element_input)
        if factor is None or (factor != 1 and not kind.startswith(("float", "vector"))):
            where, unit = element_input.getNamePath(), element_input.getUnit()
            self._say("mtlx-bad-unit", f"{where} is a {kind} in {unit!r}, which is left as it is")
            factor = 1
        attribute.default = value if factor == 1 else value * factor
        if kind in ("filename", "color3", "color4"):
            self._color_space(attribute, element, element_input)

    def _color_space(self, attribute: Any, element: Any, element_input: Any) -> None:
        space = element_input.getActiveColorSpace()
        # What a file inherits from its document says nothing about its pixels unless its node gives a colour.
        if element_input.getType() == "filename" and not element_input.hasColorSpace() and not _gives_color(element):
            return
        if space:
            attribute.SetInfo("colorSpace", space)

    def _promote(self, material: Any, shader: Any) -> None:
        """All inputs of a terminal's shader that are not connected become the material's."""
        definition = shader.getNodeDef() if shader is not None else None
        path = self._paths.get(shader.getNamePath()) if shader is not None else None
        if definition is None or path is None:
            return
        prim = self._layer.GetPrimAtPath(path)
        for port in definition.getActiveInputs():
            if port.getType() not in TYPES:
                continue
            name = _port("inputs", port.getName())
            attribute = _attribute(prim, name, TYPES[port.getType()])
            if attribute.connectionPathList.explicitItems:
                continue
            public = _attribute(material, name, attribute.typeName)
            if attribute.HasInfo("default"):
                if public.HasInfo("default"):
                    continue  # another shader of the material has an input of this name; each keeps its value
                public.default = attribute.default
                if attribute.HasInfo("colorSpace"):
                    public.SetInfo("colorSpace", attribute.GetInfo("colorSpace"))
            attribute.ClearInfo("default")
            attribute.ClearInfo("colorSpace")
            attribute.connectionPathList.explicitItems = [public.path]


def _gives_color(element: Any) -> bool:
    kinds = [element.getType()]
    if kinds[0] == "multioutput" and element.getCategory() != "nodegraph":
        definition = element.getNodeDef()
        kinds = [o.getType() for o in definition.getActiveOutputs()] if definition is not None else []
    return any(kind in ("color3", "color4") for kind in kinds)
