# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Reads .mtlx documents and makes them whole: includes, old versions, file prefixes, nodes that they define."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

# (code, text): what is wrong with a document that is rendered all the same.
Say = Callable[[str, str], None]

# More nodes than this, after the graphs of a document's own definitions are put in, are no material but an accident.
MAX_NODES = 20000

_LIBRARY: list[Any] = []


def standard_library(mx: Any) -> Any:
    """MaterialX's own definitions, which the renderer knows by name."""
    if not _LIBRARY:
        library = mx.createDocument()
        mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
        _LIBRARY.append(library)
    return _LIBRARY[0]


def read_document(path: str, say: Say) -> Any:
    """The document in a file that a resolver finds. Raises what the materialx package and the resolver raise."""
    import MaterialX as mx

    document = mx.createDocument()
    document.setDataLibrary(standard_library(mx))
    search = mx.FileSearchPath(os.path.dirname(os.path.abspath(path)))
    search.append(mx.getEnvironmentPath())
    search.append(mx.getDefaultDataSearchPath())
    if os.path.exists(path):
        mx.readFromXmlFile(document, path, search)
    else:
        mx.readFromXmlString(document, _text_of_asset(path), search)
    for file in _plugin_files():
        extra = mx.createDocument()
        mx.readFromXmlFile(extra, file, search)
        document.importLibrary(extra)
    _resolve_file_names(mx, document, os.path.dirname(os.path.abspath(path)))
    _expand_own_nodes(mx, document, say)
    if not document.getMaterialNodes():
        _make_materials(mx, document)
    return document


def _text_of_asset(path: str) -> str:
    """A file that only the resolver can open: one inside of a package, say."""
    from pxr import Ar

    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if not asset:
        raise FileNotFoundError(f"there is no file {path}")
    return bytes(asset.GetBuffer()).decode("utf-8")


def _plugin_files() -> Iterator[str]:
    """A studio's own definitions, where UsdMtlx looks for them too."""
    for folder in os.environ.get("PXR_MTLX_PLUGIN_SEARCH_PATHS", "").split(os.pathsep):
        for root, _, names in sorted(os.walk(folder)) if folder else ():
            yield from (os.path.join(root, name) for name in sorted(names) if name.endswith(".mtlx"))


def _resolve_file_names(mx: Any, document: Any, folder: str) -> None:
    """File names become whole before nodes move: the prefixes stand on the elements around them.

    Names are relative to the document; where nothing is there, to the included file that holds them, and to the folders
    of MATERIALX_SEARCH_PATH.
    """
    search = [path for path in os.environ.get("MATERIALX_SEARCH_PATH", "").split(os.pathsep) if path]
    prefixed = []
    for element in document.traverseTree():
        if element.hasFilePrefix():
            prefixed.append(element)
        if not element.isA(mx.ValueElement) or element.getType() != "filename" or not element.hasValueString():
            continue
        name = element.getResolvedValueString()
        if "://" not in name:
            places = [folder, os.path.dirname(element.getActiveSourceUri()), *search]
            candidates = [os.path.normpath(os.path.join(folder, place, name)) for place in places]
            name = next((c for c in candidates if _is_there(c)), candidates[0])
        element.setValueString(name)
    for element in prefixed:
        element.removeAttribute(element.FILE_PREFIX_ATTRIBUTE)


def _is_there(path: str) -> bool:
    return os.path.exists(path) or ("<" in path and os.path.isdir(os.path.dirname(path.split("<")[0])))


def _expand_own_nodes(mx: Any, document: Any, say: Say) -> None:
    """Nodes that the document defines by graphs become the nodes of those graphs: nobody else knows their names."""
    expandable = _expandable(mx, document, say)
    if not expandable:
        return

    def is_own(node: Any) -> bool:
        definition = node.getNodeDef()
        return definition is not None and definition.getName() in expandable

    for graph in [document, *_own(document, mx.NodeGraph)]:
        if graph is not document and graph.getNodeDef() is not None:
            continue
        sizes = [expandable[node.getNodeDef().getName()] for node in graph.getNodes() if is_own(node)]
        if sum(sizes) > MAX_NODES:
            say(
                "mtlx-too-large",
                f"{graph.getName() or 'the document'} holds more than {MAX_NODES} nodes once the definitions of the "
                "document are put in; nodes of its own are not replaced by their graphs",
            )
        elif sizes:
            graph.flattenSubgraphs("", is_own)


def _expandable(mx: Any, document: Any, say: Say) -> dict[str, int]:
    """The document's own definitions that graphs implement, and how many nodes each comes to. Not those that hold
    themselves: they would never end."""
    graphs: dict[str, Any] = {}
    for definition in _own(document, mx.NodeDef):
        graph = definition.getImplementation()
        if graph is not None and graph.isA(mx.NodeGraph):
            graphs[definition.getName()] = graph
    inner = {name: _definitions_in(graph, graphs) for name, graph in graphs.items()}
    sizes: dict[str, int] = {}
    endless: set[str] = set()
    for start in graphs:
        if start in sizes:
            continue
        stack = [(start, iter(inner[start]))]
        while stack:
            name, children = stack[-1]
            child = next(children, None)
            if child is None:
                stack.pop()
                sizes[name] = len(graphs[name].getNodes()) + sum(sizes.get(c, 0) for c in inner[name])
                if any(c in endless for c in inner[name]):
                    endless.add(name)
            elif child in (open_names := [n for n, _ in stack]):
                endless.update(open_names[open_names.index(child) :])
            elif child not in sizes:
                stack.append((child, iter(inner[child])))
    for name in sorted(endless):
        say("mtlx-recursive-definition", f"the definition {name} holds itself; nodes of it are not rendered")
    return {name: size for name, size in sizes.items() if name not in endless}


def _make_materials(mx: Any, document: Any) -> None:
    """A document without materials gets one for each surface that it gives out, as MaterialX's viewer shows them.

    Of its graphs (named <graph>_<output>) and of itself (<output>_material), else of its shader nodes
    (<node>_material).
    """
    places = [document, *(g for g in _own(document, mx.NodeGraph) if g.getNodeDef() is None)]
    found = [(place, o) for place in places for o in place.getOutputs() if o.getType() in ("surfaceshader", "material")]
    if not found:
        found = [(document, n) for n in document.getNodes() if n.getType() == "surfaceshader"]
    for place, element in found:
        name = element.getName()
        label = f"{name}_material" if place is document else f"{place.getName()}_{name}"
        if element.getType() == "material":  # its surface gets an output of its own
            material = element.getConnectedNode()
            port = material.getInput("surfaceshader") if material is not None else None
            if port is None or place is document:
                continue
            element = place.addOutput(place.createValidChildName(f"{name}_surface"), "surfaceshader")
            element.setNodeName(port.getNodeName())
        material = document.addNode("surfacematerial", document.createValidChildName(label), "material")
        port = material.addInput("surfaceshader", "surfaceshader")
        if place is not document:
            port.setNodeGraphString(place.getName())
            port.setOutputString(element.getName())
        elif element.isA(mx.Node):
            port.setNodeName(name)
        else:
            port.setNodeName(element.getNodeName())
            if element.getOutputString():
                port.setOutputString(element.getOutputString())


def _own(document: Any, kind: Any) -> list[Any]:
    """The document's children of a kind; getChildrenOfType gives those of the library too."""
    return [child for child in document.getChildren() if child.isA(kind)]


def _definitions_in(graph: Any, own: dict[str, Any]) -> list[str]:
    definitions = (node.getNodeDef() for node in graph.getNodes())
    return [d.getName() for d in definitions if d is not None and d.getName() in own]
