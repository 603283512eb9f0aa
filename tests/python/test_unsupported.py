# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What is not translated is said, once a prim."""

from __future__ import annotations

import pytest
from usda import said


@pytest.mark.parametrize(
    ("prim", "code"),
    [
        ('def BasisCurves "x" {}', "prim-unsupported"),
        ('def Points "x" {}', "prim-unsupported"),
        ('def Volume "x" {}', "prim-unsupported"),
        ('def NurbsPatch "x" {}', "prim-unsupported"),
        ('def TetMesh "x" {}', "prim-unsupported"),
        ('def GeometryLight "x" {}', "prim-unsupported"),
        ('def PortalLight "x" {}', "prim-unsupported"),
        ('def PluginLight "x" {}', "prim-unsupported"),
        ('def NurbsCurves "x" {}', "prim-unsupported"),
        ('def HermiteCurves "x" {}', "prim-unsupported"),
        ('def GenerativeProcedural "x" {}', "prim-unsupported"),
        ('def Volume "x" (prepend apiSchemas = ["VolumeLightAPI"]) {}', "prim-unsupported"),
        ('def Cube "x" (prepend apiSchemas = ["LightAPI"]) {}', "prim-unsupported"),
        ('def SomeonesStandIn "x" {}', "prim-unknown-type"),
        ('def Cube "x" { int[] primvars:skel:jointIndices = [0] }', "skinning-unsupported"),
        ('def Mesh "x" { rel skel:skeleton = </s> }', "skinning-unsupported"),
        ('def Mesh "x" { token[] skel:blendShapes = ["smile"] }', "skinning-unsupported"),
        ('def Xform "x" { int[] primvars:skel:jointIndices = [0]; def Mesh "m" {} }', "skinning-unsupported"),
        (
            """def Mesh "x" { def GeomSubset "edges" {
                uniform token elementType = "edge"
                uniform token familyName = "materialBind" } }""",
            "subset-unsupported",
        ),
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


@pytest.mark.parametrize(
    ("prim", "words"),
    [
        ('def BasisCurves "x" {}', "curves"),
        ('def NurbsCurves "x" {}', "NURBS curves"),
        ('def HermiteCurves "x" {}', "Hermite curves"),
        ('def NurbsPatch "x" {}', "NURBS patches"),
        ('def Points "x" {}', "points"),
        ('def TetMesh "x" {}', "tetrahedral meshes"),
        ('def Volume "x" {}', "volumes"),
        ('def PortalLight "x" {}', "portal lights"),
        ('def PluginLight "x" {}', "plug-in lights"),
        ('def GeometryLight "x" {}', "geometry lights"),
        ('def ParticleField "x" {}', "particle fields"),
        ('def ParticleField3DGaussianSplat "x" {}', "Gaussian splats"),
        ('def GenerativeProcedural "x" {}', "procedurals"),
        ('def Mesh "x" (prepend apiSchemas = ["MeshLightAPI"]) {}', "mesh lights (MeshLightAPI)"),
        ('def Cube "x" (prepend apiSchemas = ["VolumeLightAPI"]) {}', "volume lights (VolumeLightAPI)"),
        ('def Cube "x" (prepend apiSchemas = ["LightAPI"]) {}', "prims made lights (LightAPI)"),
    ],
)
def test_things_are_called_by_what_they_are(translated, prim, words):
    (diagnostic,) = translated(prim)[1]
    assert diagnostic.message.startswith(f"{words} are not rendered yet")


def test_what_is_not_drawn_anyway_is_not_said(translated):
    """Purposes that are off, scopes of no schema, lights' own LightAPI, materials' insides."""
    _, diagnostics = translated(
        """
def Points "guide" { uniform token purpose = "guide" }
def "plain" {}
def SphereLight "l" (prepend apiSchemas = ["LightAPI"]) {}
def NodeGraph "n" { def Points "inside" {} }
def Xform "list" (prepend apiSchemas = ["LightListAPI", "MotionAPI"]) { float motion:blurScale = 2 }
"""
    )
    assert not list(diagnostics)


def test_types_that_usd_replaces_are_what_it_takes(translated):
    delegate, diagnostics = translated(
        """(
    fallbackPrimTypes = {
        token[] FancyCube = ["FancierCube", "Cube"]
        token[] FancyLight = ["SphereLight"]
    }
)
def FancyCube "c" { double size = 3 }
def FancyLight "l" { float inputs:radius = 3 }
"""
    )
    assert delegate.told["/c"]["shape"] == {"type": "Cube", "size": 3}
    assert delegate.told["/l"]["params"]["type"] == "SphereLight" and delegate.told["/l"]["params"]["radius"] == 3
    assert not list(diagnostics)


@pytest.mark.parametrize("mode", ["origin", "bounds", "cards", "default", "inherited"])
def test_draw_modes_are_said(translated, mode):
    _, diagnostics = translated(
        f'def Xform "x" (prepend apiSchemas = ["GeomModelAPI"]) {{ uniform token model:drawMode = "{mode}" }}'
    )
    expected = [("draw-mode-unsupported", "/x")] if mode in ("origin", "bounds", "cards") else []
    assert said(diagnostics) == expected


@pytest.mark.parametrize(
    ("purpose", "value", "expected"),
    [
        ("proxy", "invisible", True),
        ("proxy", "inherited", False),
        ("proxy", "visible", False),
        ("render", "invisible", False),  # not drawn by default
    ],
)
def test_visibility_of_purposes_is_said(translated, purpose, value, expected):
    _, diagnostics = translated(
        f'def Xform "x" (prepend apiSchemas = ["VisibilityAPI"]) {{ uniform token {purpose}Visibility = "{value}" }}'
    )
    assert said(diagnostics) == ([("purpose-visibility-unsupported", "/x")] if expected else [])


def test_drawable_types_that_nobody_foresaw_are_said(translated, monkeypatch):
    """A plug-in's schema, say: whatever has an extent in the world."""
    from hdwavefront.stage_adapters.unsupported import UNSUPPORTED

    monkeypatch.delitem(UNSUPPORTED, "Volume")
    (diagnostic,) = translated('def Volume "x" {}')[1]
    assert diagnostic.code == "prim-unsupported" and diagnostic.message.startswith("prims of type Volume are not")
