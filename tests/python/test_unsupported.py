# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What is not translated is said, once a prim."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize(
    ("prim", "code"),
    [
        ('def BasisCurves "x" {}', "prim-unsupported"),
        ('def Points "x" {}', "prim-unsupported"),
        ('def Volume "x" {}', "prim-unsupported"),
        ('def NurbsPatch "x" {}', "prim-unsupported"),
        ('def TetMesh "x" {}', "prim-unsupported"),
        ('def GeometryLight "x" {}', "prim-unsupported"),
        ('def Mesh "x" (prepend apiSchemas = ["MeshLightAPI"]) {}', "prim-unsupported"),
        ('def Mesh "x" { int[] primvars:skel:jointIndices = [0] }', "skinning-unsupported"),
        ('def SphereLight "x" { rel light:filters = </f> } def LightFilter "f" {}', "light-filter-unsupported"),
        ('def Mesh "x" { int[] points = [1] }', "attribute-bad-type"),
        ('def PointInstancer "x" {}', "point-instancer-empty"),
    ],
)
def test_what_is_not_translated_is_said_once(translated, prim, code):
    _, diagnostics = translated(prim)
    assert [(d.code, d.location.startswith("/x")) for d in diagnostics] == [(code, True)]
