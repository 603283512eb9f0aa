# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Meshes and their primvars: what is authored arrives."""

from __future__ import annotations

import numpy as np
from usda import QUAD, primvars_of


def test_a_mesh_arrives_as_authored(translated):
    delegate, diagnostics = translated(
        f"""
def Mesh "m" {{ {QUAD}
    uniform token subdivisionScheme = "loop"
    uniform token orientation = "leftHanded"
    int[] holeIndices = [0]
    int[] creaseIndices = [0, 1]
    int[] creaseLengths = [2]
    float[] creaseSharpnesses = [3.5]
    uniform bool doubleSided = 1
    normal3f[] normals = [(0, 0, 1)] (interpolation = "constant")
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1)] (interpolation = "faceVarying")
    int[] primvars:st:indices = [0, 1, 2, 0]
    string[] primvars:names = ["a", "b"] (interpolation = "uniform")
}}""",
        refine_level=2,
    )
    mesh = delegate.told["/m"]
    topology = mesh["topology"]
    assert (topology["scheme"], topology["orientation"]) == ("loop", "leftHanded")
    assert list(topology["faceVertexIndices"]) == [0, 1, 2, 3] and list(topology["holeIndices"]) == [0]
    assert list(topology["creaseLengths"]) == [2] and topology["creaseSharpnesses"][0] == 3.5
    assert mesh["points"].shape == (4, 3) and mesh["double_sided"] is True and mesh["refine_level"] == 2
    primvars = primvars_of(mesh)
    assert set(primvars) == {"st", "normals"}  # strings are nothing that a material reads
    assert primvars["st"][1] == "faceVarying" and list(primvars["st"][3]) == [0, 1, 2, 0]
    assert primvars["st"][2].shape == (3, 2) and primvars["st"][2].dtype == np.float32
    assert primvars["normals"][1] == "constant"
    assert not list(diagnostics)


def test_primvars_normals_win_over_normals(translated):
    delegate, _ = translated(
        f"""def Mesh "m" {{ {QUAD}
    normal3f[] normals = [(0, 0, 1)] (interpolation = "constant")
    normal3f[] primvars:normals = [(1, 0, 0)] (interpolation = "constant")
}}"""
    )
    normals = [p for p in delegate.told["/m"]["primvars"] if p[0] == "normals"]
    assert len(normals) == 1 and list(normals[0][2][0]) == [1, 0, 0]


def test_element_size_that_contradicts_the_indices(translated):
    """Seen in files of Maya: the number of values as elementSize."""
    delegate, diagnostics = translated(
        """
def Mesh "m" {
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (
        elementSize = 3
        interpolation = "faceVarying"
    )
    int[] primvars:st:indices = [0, 2, 1]
}
"""
    )
    (st,) = [p for p in delegate.told["/m"]["primvars"] if p[0] == "st"]
    assert st[2].shape == (3, 2) and list(st[3]) == [0, 2, 1]
    assert [(d.code, d.location) for d in diagnostics] == [("primvar-bad-size", "/m.primvars:st")]
