# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdShade networks, one per render context, as plain nodes and connections.

NodeGraphs and interface inputs are resolved away: every connection ends at a node's output or at a value.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdShade

from .assets import asset_value
from .colors import rendering_color
from .context import Translation, Update

_VECTORS = (Gf.Vec2f, Gf.Vec3f, Gf.Vec4f, Gf.Vec2d, Gf.Vec3d, Gf.Vec4d, Gf.Vec2h, Gf.Vec3h, Gf.Vec4h)
_MATRICES = (Gf.Matrix3d, Gf.Matrix4d, Gf.Matrix3f, Gf.Matrix4f)


class _Network:
    """One network while it is walked."""

    def __init__(self, translation: Translation, material: UsdShade.Material) -> None:
        self.translation = translation
        self.material = material
        self.nodes: dict[str, Update] = {}
        self.connections: list[tuple[str, str, str, str]] = []

    def add(self, surface: UsdShade.Shader) -> None:
        """The node and all above it. Iterative: a chain of thousands of nodes must not end Python's stack."""
        pending = [surface]
        while pending:
            shader = pending.pop()
            path = str(shader.GetPath())
            if path in self.nodes:
                continue
            node: Update = {"path": path, "identifier": _identifier(shader), "parameters": {}}
            self.nodes[path] = node
            for shader_input in shader.GetInputs(onlyAuthored=True):
                pending += self._input(node, shader_input)

    def _input(self, node: Update, shader_input: UsdShade.Input) -> list[UsdShade.Shader]:
        name = str(shader_input.GetBaseName())
        above = []
        attributes = UsdShade.Utils.GetValueProducingAttributes(shader_input)
        if not attributes or attributes[0] == shader_input.GetAttr():
            self._report_dangling(shader_input)
        for attribute in attributes:
            attribute_name, kind = UsdShade.Utils.GetBaseNameAndType(attribute.GetName())
            if kind == UsdShade.AttributeType.Output:
                source = UsdShade.Shader(attribute.GetPrim())
                if not source:
                    self.translation.diagnostics.warning(
                        "material-bad-connection",
                        shader_input.GetAttr().GetPath(),
                        f"the input is connected to {attribute.GetPath()}, no output of a shader; it is ignored",
                    )
                    continue
                self.connections.append((str(source.GetPath()), str(attribute_name), node["path"], name))
                above.append(source)
                continue
            value = self._value(attribute, shader_input)
            if value is not None:
                node["parameters"][name] = value
        return above

    def _report_dangling(self, shader_input: UsdShade.Input) -> None:
        if not shader_input.GetAttr().HasAuthoredConnections():
            return
        for target in shader_input.GetConnectedSources()[1]:
            self.translation.diagnostics.warning(
                "material-bad-connection",
                shader_input.GetAttr().GetPath(),
                f"the input is connected to {target}, where no shader gives anything; its own value is taken",
            )

    def _value(self, attribute: Usd.Attribute, shader_input: UsdShade.Input) -> Any:
        """A constant as a plain Python value, colours in the rendering colour space."""
        time = self.translation.time
        type_name = attribute.GetTypeName()
        if type_name == Sdf.ValueTypeNames.Asset:
            value = asset_value(attribute, time)
            # The colour space may stand on the shader's input while the file comes from the material's interface.
            if value is not None and not value["colorSpace"]:
                value["colorSpace"] = str(shader_input.GetAttr().GetColorSpace())
            return value
        value = attribute.Get(time)
        if value is None:
            return None
        if isinstance(value, _VECTORS):
            components = tuple(float(x) for x in value)
            role = shader_input.GetTypeName().role or type_name.role
            if role == Sdf.ValueRoleNames.Color and len(components) >= 3:
                components = (*rendering_color(self.translation, components[:3], attribute), *components[3:])
            return components
        if isinstance(value, _MATRICES):
            return tuple(float(x) for x in np.asarray(value).reshape(-1))
        if isinstance(value, bool | int | float | str):
            return value
        self.translation.diagnostics.warning(
            "material-value-type",
            attribute.GetPath(),
            f"values of type {type_name} are not supported in material networks; the input keeps its default",
        )
        return None


def _identifier(shader: UsdShade.Shader) -> str:
    identifier = shader.GetIdAttr().Get()
    if identifier:
        return str(identifier)
    source = shader.GetImplementationSource()
    return f"({source})" if source else ""


def _terminal(output: UsdShade.Output) -> tuple[UsdShade.Shader, str] | None:
    """The shader at the end of a material's output, and the name of its own."""
    if not output or not output.GetPrim():
        return None
    sources = UsdShade.Utils.GetValueProducingAttributes(output)
    shader = UsdShade.Shader(sources[0].GetPrim()) if sources else None
    if not shader:
        return None
    name, _ = UsdShade.Utils.GetBaseNameAndType(sources[0].GetName())
    return shader, str(name)


def material_contexts(translation: Translation, material: UsdShade.Material) -> dict[str, Update]:
    """The networks of a material by render context, those that it has, with their terminals."""
    contexts: dict[str, Update] = {}
    seen: set[tuple[str, str, str]] = set()
    for context in translation.options.render_contexts:
        network = _Network(translation, material)
        terminals: Update = {}
        for kind, output in (
            ("surface", material.GetSurfaceOutput(context)),
            ("displacement", material.GetDisplacementOutput(context)),
        ):
            found = _terminal(output)
            if found is None:
                continue
            shader, name = found
            terminal = (str(shader.GetPath()), name)
            if (kind, *terminal) in seen:
                continue
            seen.add((kind, *terminal))
            network.add(shader)
            terminals[kind] = terminal
        if terminals:
            contexts[context] = {
                "nodes": list(network.nodes.values()),
                "connections": network.connections,
                **terminals,
            }
    return contexts


def _report_other_terminals(translation: Translation, material: UsdShade.Material) -> None:
    for context in translation.options.render_contexts:
        output = material.GetVolumeOutput(context)
        if output and UsdShade.Utils.GetValueProducingAttributes(output):
            translation.diagnostics.warning(
                "material-volume-unsupported", material.GetPath(), "volume is not rendered yet; it is ignored"
            )


# Inputs that make a surface shine, by the names that UsdPreviewSurface and MaterialX's surfaces give them.
_EMISSION_INPUTS = frozenset(
    {"emissiveColor", "emission", "emission_luminance", "emissive", "emissive_strength", "edf"}
)


def _may_emit(contexts: dict[str, Update]) -> bool:
    for network in contexts.values():
        if any(connection[3] in _EMISSION_INPUTS for connection in network["connections"]):
            return True
        for node in network["nodes"]:
            for name in _EMISSION_INPUTS & node["parameters"].keys():
                value = node["parameters"][name]
                if any(value) if isinstance(value, tuple) else value:
                    return True
    return False


def emit_material(translation: Translation, material: UsdShade.Material) -> None:
    path = str(material.GetPath())
    contexts = material_contexts(translation, material)
    if not any("surface" in network for network in contexts.values()):
        others = sorted(str(o.GetBaseName()) for o in material.GetOutputs() if o.HasConnectedSource())
        has = f"it has only {', '.join(others)}" if others else "it has no surface at all"
        translation.diagnostics.warning(
            "material-no-surface", path, f"the material has no surface that can be rendered: {has}; the default is used"
        )
    _report_other_terminals(translation, material)
    translation.has_emission |= _may_emit(contexts)
    translation.sink.sync_material(path, contexts)
