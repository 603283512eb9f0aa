# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Pieces of USD text that tests share, and how to read what a delegate was told."""

from __future__ import annotations

from typing import Any

QUAD = """
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
"""

MATERIALS = """
def Material "red" { token outputs:surface.connect = </red/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0)
        token outputs:surface
    } }
def Material "blue" { token outputs:surface.connect = </blue/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
    } }
"""


SCENE = """(
    upAxis = "Y"
    startTimeCode = 3
)
def Camera "main_cam" {
    float horizontalAperture = 20
    float verticalAperture = 10
}
def Camera "other" {
}
def Cube "c" {
}
"""


def translation_of(update: dict[str, Any]) -> tuple[float, ...]:
    return tuple(update["transform"][3, :3])


def primvars_of(update: dict[str, Any]) -> dict[str, tuple[Any, ...]]:
    return {p[0]: p for p in update["primvars"]}


def said(diagnostics: Any) -> list[tuple[str, str]]:
    """(code, location) of each diagnostic."""
    return [(d.code, d.location) for d in diagnostics]
