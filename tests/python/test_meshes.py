# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Meshes and their primvars: what is authored arrives."""

from __future__ import annotations

import numpy as np
import pytest
from usda import QUAD, primvars_of, said


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


TAGS = {
    "interpolateBoundary": ('token interpolateBoundary = "edgeOnly"', "edgeOnly"),
    "faceVaryingLinearInterpolation": ('token faceVaryingLinearInterpolation = "all"', "all"),
    "triangleSubdivisionRule": ('token triangleSubdivisionRule = "smooth"', "smooth"),
    "cornerIndices": ("int[] cornerIndices = [2]", [2]),
    "cornerSharpnesses": ("float[] cornerSharpnesses = [4]", [4]),
    "creaseIndices": ("int[] creaseIndices = [0, 1]", [0, 1]),
    "creaseLengths": ("int[] creaseLengths = [2]", [2]),
    "creaseSharpnesses": ("float[] creaseSharpnesses = [5]", [5]),
}


@pytest.mark.parametrize("name", TAGS)
def test_every_subdivision_tag_arrives(translated, name):
    line, value = TAGS[name]
    told = translated(f'def Mesh "m" {{ {QUAD}; {line} }}')[0].told["/m"]["topology"]
    assert told["scheme"] == "catmullClark"  # what UsdGeomMesh is where nothing is said
    assert (told[name] if isinstance(value, str) else list(told[name])) == value
    polygons = f'def Mesh "m" {{ {QUAD}; {line}; uniform token subdivisionScheme = "none" }}'
    assert name not in translated(polygons)[0].told["/m"]["topology"]  # they mean nothing to polygons


def test_what_is_not_authored_is_the_schemas(translated):
    delegate, _ = translated(f'def Mesh "m" {{ {QUAD} }}', refine_level=0)
    mesh = delegate.told["/m"]
    assert mesh["topology"]["orientation"] == "rightHanded" and mesh["topology"]["holeIndices"].size == 0
    assert mesh["primvars"] == [] and mesh["subset_materials"] == [] and mesh["refine_level"] == 0


def test_topology_and_subsets_are_those_of_the_frame(translated):
    delegate, _ = translated(
        """def Mesh "m" {
    int[] faceVertexCounts.timeSamples = { 1: [3], 2: [4] }
    int[] faceVertexIndices.timeSamples = { 1: [0, 1, 2], 2: [0, 1, 2, 3] }
    int[] holeIndices.timeSamples = { 1: [], 2: [0] }
    point3f[] points.timeSamples = { 1: [(0, 0, 0)], 2: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)] }
    def GeomSubset "s" {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices.timeSamples = { 1: [], 2: [0] }
    }
    def GeomSubset "other" {
        uniform token elementType = "face"
        uniform token familyName = "pieces"
        int[] indices = [0]
    }
}""",
        time=2,
    )
    mesh = delegate.told["/m"]
    topology = mesh["topology"]
    assert list(topology["faceVertexCounts"]) == [4] and list(topology["holeIndices"]) == [0]
    assert len(mesh["points"]) == 4
    assert [(path, list(indices)) for path, indices in topology["subsets"]] == [("/m/s", [0])]


@pytest.mark.parametrize(
    ("line", "interpolation", "count"),
    [
        ("normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]", "vertex", 4),
        ('normal3f[] normals = [(0, 0, 1)] (interpolation = "uniform")', "uniform", 1),
        ("normal3f[] normals.timeSamples = { 1: [(0, 0, 1)] }", "vertex", 1),
    ],
)
def test_normals_and_their_interpolation(translated, line, interpolation, count):
    (normals,) = translated(f'def Mesh "m" {{ {QUAD}; {line} }}', time=1)[0].told["/m"]["primvars"]
    assert (normals[0], normals[1], len(normals[2])) == ("normals", interpolation, count)


PRIMVARS = [
    ("float", "1", (1, 1)),
    ("float[]", "[1, 2]", (2, 1)),
    ("double2[]", "[(1, 2)]", (1, 2)),
    ("half3", "(1, 2, 3)", (1, 3)),
    ("color3f[]", "[(1, 2, 3)]", (1, 3)),
    ("color4f[]", "[(1, 2, 3, 4)]", (1, 4)),
    ("int[]", "[1, 2, 3]", (3, 1)),
    ("bool[]", "[1, 0]", (2, 1)),
    ("matrix4d", "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))", None),
    ("matrix4d[]", "[((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))]", None),
    ("quatf[]", "[(1, 0, 0, 0)]", (1, 4)),
    ("string", '"a"', None),
    ("token[]", '["a"]', None),
    ("asset", "@a.png@", None),
    ("float[]", "[]", None),
]


@pytest.mark.parametrize(("kind", "value", "shape"), PRIMVARS)
def test_primvars_of_every_type_that_a_material_can_read(translated, kind, value, shape):
    """What no material reads (a reader of such a type is reported with the material) does not come along."""
    delegate, _ = translated(f'def Mesh "m" {{ {QUAD}; {kind} primvars:p = {value} }}')
    told = primvars_of(delegate.told["/m"])
    assert (told["p"][2].shape if "p" in told else None) == shape


def test_primvars_and_indices_are_those_of_the_frame(translated):
    delegate, _ = translated(
        f"""def Mesh "m" {{ {QUAD}
    float[] primvars:p (interpolation = "uniform")
    float[] primvars:p.timeSamples = {{ 1: [1, 2], 2: [3, 4] }}
    int[] primvars:p:indices.timeSamples = {{ 1: [0], 2: [1] }}
}}""",
        time=2,
    )
    (_, interpolation, values, indices) = primvars_of(delegate.told["/m"])["p"]
    assert (interpolation, values.tolist(), list(indices)) == ("uniform", [[3], [4]], [1])


def test_elements_of_several_values(translated):
    delegate, diagnostics = translated(
        f"""def Mesh "m" {{ {QUAD}
    float[] primvars:pair = [1, 2, 3, 4] (
        elementSize = 2
        interpolation = "uniform"
    )
    float[] primvars:odd = [1, 2, 3] (
        elementSize = 2
        interpolation = "uniform"
    )
}}"""
    )
    assert primvars_of(delegate.told["/m"])["pair"][2].tolist() == [[1, 2], [3, 4]]
    assert "odd" not in primvars_of(delegate.told["/m"])
    assert said(diagnostics) == [("primvar-bad-size", "/m.primvars:odd")]


def test_other_renderers_settings_are_no_primvars(translated):
    lines = "; ".join(f"float primvars:{p}:x = 1" for p in ("arnold", "ri", "prman", "karma", "cycles", "skel", "my"))
    assert list(primvars_of(translated(f'def Mesh "m" {{ {QUAD}; {lines} }}')[0].told["/m"])) == ["my:x"]


@pytest.mark.parametrize(
    ("line", "reported"),
    [
        ("int[] points = [1]", True),
        ("float2[] points = [(1, 2)]", True),
        ('string[] points = ["a"]', True),
        ("point3f[] points = []", False),
    ],
)
def test_points_that_are_no_points(translated, line, reported):
    delegate, diagnostics = translated(f'def Mesh "m" {{ {line} }}')
    assert delegate.told["/m"]["points"].shape == (0, 3)
    assert said(diagnostics) == ([("attribute-bad-type", "/m.points")] if reported else [])
