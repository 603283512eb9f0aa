# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""A stage of 500 materials, of 20 topologies: ten kinds of standard_surface, five of OpenPBR, five with procedural
patterns. Materials of one topology differ in values only. `python many_materials.py FILE` writes it."""

from __future__ import annotations

import colorsys
import sys
from collections.abc import Sequence
from pathlib import Path

_STANDARD = "ND_standard_surface_surfaceshader"
_OPENPBR = "ND_open_pbr_surface_surfaceshader"

# What each topology wakes besides a coloured base: input lines; `{v}` is the material's number in its topology, 0 to 1.
_STANDARD_KINDS = (
    "float inputs:specular = 0",
    "float inputs:specular_roughness = {v}",
    "float inputs:metalness = 1\nfloat inputs:specular_roughness = {v}",
    "float inputs:coat = 0.8\nfloat inputs:coat_roughness = {v}",
    "float inputs:sheen = 0.6\nfloat inputs:sheen_roughness = {v}",
    "float inputs:transmission = 1\nfloat inputs:specular_roughness = {v}",
    "float inputs:transmission = 0.5\nfloat inputs:coat = 0.5\nfloat inputs:specular_roughness = {v}",
    "float inputs:emission = {e}\nfloat inputs:specular_roughness = 0.4",
    "float inputs:metalness = {m}\nfloat inputs:coat = 0.5\nfloat inputs:specular_roughness = {v}",
    "color3f inputs:opacity = (0.6, 0.7, {v})",
)
_OPENPBR_KINDS = (
    "float inputs:specular_roughness = {v}",
    "float inputs:coat_weight = 0.7\nfloat inputs:coat_roughness = {v}",
    "float inputs:base_metalness = 1\nfloat inputs:specular_roughness = {v}",
    "float inputs:transmission_weight = 1\nfloat inputs:specular_roughness = {v}",
    "float inputs:fuzz_weight = 0.5\nfloat inputs:fuzz_roughness = {v}",
)
# Nodes that end in one called "pattern", of type float.
_PATTERNS = (
    ("ND_fractal3d_float", "int inputs:octaves = 3\nfloat inputs:amplitude = {v}"),
    ("ND_noise3d_float", "float inputs:amplitude = {v}"),
    ("ND_cellnoise3d_float", ""),
    ("ND_worleynoise3d_float", "float inputs:jitter = {v}"),
    ("ND_unifiednoise3d_float", "int inputs:type = 0\nfloat inputs:outmax = {v}"),
)
TOPOLOGIES = len(_STANDARD_KINDS) + len(_OPENPBR_KINDS) + len(_PATTERNS)


def _indented(text: str, spaces: int) -> str:
    return "".join(" " * spaces + line + "\n" for line in text.splitlines() if line)


def _material(index: int) -> str:
    kind, number = index % TOPOLOGIES, index // TOPOLOGIES
    v = 0.15 + 0.7 * ((number * 0.618034) % 1.0)
    values = {"v": f"{v:.4f}", "e": f"{0.2 + v:.4f}", "m": f"{0.2 + 0.6 * v:.4f}"}
    color = "({:.4f}, {:.4f}, {:.4f})".format(*colorsys.hsv_to_rgb((index * 0.381966) % 1.0, 0.2 + 0.6 * v, 0.8))
    path = f"/World/Materials/m{index}"
    pattern = ""
    if kind < len(_STANDARD_KINDS):
        shader, lines = _STANDARD, _STANDARD_KINDS[kind]
    elif kind < len(_STANDARD_KINDS) + len(_OPENPBR_KINDS):
        shader, lines = _OPENPBR, _OPENPBR_KINDS[kind - len(_STANDARD_KINDS)]
    else:
        node, inputs = _PATTERNS[kind - len(_STANDARD_KINDS) - len(_OPENPBR_KINDS)]
        shader = _STANDARD
        lines = f"float inputs:specular_roughness.connect = <{path}/pattern.outputs:out>"
        pattern = (
            f'            def Shader "pattern"\n            {{\n                uniform token info:id = "{node}"\n'
            + _indented(inputs.format(**values), 16)
            + "                float outputs:out\n            }\n"
        )
    return (
        f'        def Material "m{index}"\n        {{\n'
        f"            token outputs:mtlx:surface.connect = <{path}/surface.outputs:out>\n"
        f'            def Shader "surface"\n            {{\n                uniform token info:id = "{shader}"\n'
        f"                color3f inputs:base_color = {color}\n"
        + _indented(lines.format(**values), 16)
        + "                token outputs:out\n            }\n"
        + pattern
        + "        }\n"
    )


def _tile(place: int, index: int, columns: int) -> str:
    x, y = place % columns - (columns - 1) / 2, place // columns
    return (
        f'    def Sphere "s{index}" (\n        prepend apiSchemas = ["MaterialBindingAPI"]\n    )\n    {{\n'
        f"        rel material:binding = </World/Materials/m{index}>\n        double radius = 0.46\n"
        f"        double3 xformOp:translate = ({x:.2f}, {y:.2f}, 0)\n"
        '        uniform token[] xformOpOrder = ["xformOp:translate"]\n    }\n'
    )


def stage_text(materials: Sequence[int] = range(500), columns: int = 25) -> str:
    """A sphere for each of the materials, by number: 20 i + k is of topology k."""
    rows = (len(materials) + columns - 1) // columns
    return (
        '#usda 1.0\n(\n    defaultPrim = "World"\n    upAxis = "Y"\n)\ndef Xform "World"\n{\n'
        '    def Camera "main_cam"\n    {\n        token projection = "orthographic"\n'
        f"        float horizontalAperture = {columns * 10}\n        float verticalAperture = {rows * 10}\n"
        f"        double3 xformOp:translate = (0, {(rows - 1) / 2}, 20)\n"
        '        uniform token[] xformOpOrder = ["xformOp:translate"]\n    }\n'
        '    def DomeLight "dome"\n    {\n        float inputs:intensity = 0.6\n    }\n'
        '    def DistantLight "sun"\n    {\n        float inputs:intensity = 2\n        float inputs:angle = 3\n'
        "        float3 xformOp:rotateXYZ = (-40, 30, 0)\n"
        '        uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]\n    }\n'
        + "".join(_tile(place, i, columns) for place, i in enumerate(materials))
        + '    def Scope "Materials"\n    {\n'
        + "".join(_material(i) for i in materials)
        + "    }\n}\n"
    )


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(stage_text(), encoding="utf-8")
