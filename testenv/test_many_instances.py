# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""More instances than 16 bits number: bodies must be told apart all the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np

COUNT = 0xFFFF
SCENE = """#usda 1.0
def Camera "cam"
{
    token projection = "orthographic"
    float horizontalAperture = 0.2
    float verticalAperture = 0.2
    float2 clippingRange = (0.1, 100)
    float3 xformOp:rotateXYZ = (-90, 0, 0)
    double3 xformOp:translate = (0, 5, 0)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}

def DomeLight "dome"
{
    float inputs:intensity = 1
}

def Material "wax"
{
    token outputs:mtlx:surface.connect = </wax/surface.outputs:out>

    def Shader "surface"
    {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        float inputs:base = 0
        float inputs:specular = 0
        float inputs:subsurface = 1
        color3f inputs:subsurface_color = (0.8, 0.5, 0.2)
        color3f inputs:subsurface_radius = (0.05, 0.05, 0.05)
        token outputs:out
    }
}

def Cube "a" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    double size = 4
    rel material:binding = </wax>
}

def PointInstancer "b"
{
    rel prototypes = </b/speck>

    def Mesh "speck"
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (0.001, 0, 0), (0, 0.001, 0)]
    }
}

def Cube "c" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    double size = 3.96
    rel material:binding = </wax>
}
"""


def picture(folder: Path) -> np.ndarray:
    """Instances are numbered by path: a block of wax, 65,535 specks far below, and inside of the block another one."""
    import hdwavefront
    from pxr import Usd, UsdGeom, Vt

    path = folder / "many.usda"
    path.write_text(SCENE)
    stage = Usd.Stage.Open(str(path))
    specks = UsdGeom.PointInstancer(stage.GetPrimAtPath("/b"))
    positions = np.random.default_rng(1).uniform(-1, 1, (COUNT, 3)).astype(np.float32) - np.float32((0, 50, 0))
    specks.CreateProtoIndicesAttr(Vt.IntArray(COUNT, 0))
    specks.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(positions))
    stage.Save()
    render = hdwavefront.open(str(path), width=12, height=12, camera="/cam", complexity="low")
    render.start(samples=256)
    assert render.wait(200), "the render does not end"
    assert render.stats()["errorFlags"] == 0 and not render.diagnostics
    return render.map()[..., :3]


def test_a_walk_leaves_through_the_instance_that_it_entered(tmp_path):
    """A walk passes what stands inside of its body, whose number here is 65,536 more: the colour is the wax's."""
    np.testing.assert_allclose(picture(tmp_path).mean((0, 1)), (0.8, 0.5, 0.2), rtol=0.025)
