# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Cameras: their attributes at the frame, how they are found, and the free camera."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hdwavefront.errors import Diagnostics
from hdwavefront.stage_adapters import camera as cameras
from pxr import Gf, Sdf, Usd

ATTRIBUTES = {
    "projection": ('token projection = "orthographic"', "orthographic"),
    "horizontalAperture": ("float horizontalAperture = 30", 30),
    "verticalAperture": ("float verticalAperture = 25", 25),
    "horizontalApertureOffset": ("float horizontalApertureOffset = 2", 2),
    "verticalApertureOffset": ("float verticalApertureOffset = 3", 3),
    "focalLength": ("float focalLength = 35", 35),
    "clippingRange": ("float2 clippingRange = (0.5, 70)", (0.5, 70)),
    "fStop": ("float fStop = 4", 4),
    "focusDistance": ("float focusDistance = 6", 6),
    "exposure": ("float exposure = 7", 7),
    "exposure:time": ("float exposure:time = 8", 8),
    "exposure:iso": ("float exposure:iso = 200", 200),
    "exposure:fStop": ("float exposure:fStop = 9", 9),
    "exposure:responsivity": ("float exposure:responsivity = 0.25", 0.25),
    "shutter:open": ("double shutter:open = -0.5", -0.5),
    "shutter:close": ("double shutter:close = -0.25", -0.25),
}


def opened(text: str) -> Usd.Stage:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString("#usda 1.0\n" + text)
    return Usd.Stage.Open(layer)


def params_of(text: str, time: float | None = None):
    diagnostics = Diagnostics()
    stage = opened(text)
    camera = cameras.find_camera(stage, "/c")
    code = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
    return cameras.camera_params(camera, code, diagnostics), diagnostics


@pytest.mark.parametrize("name", ATTRIBUTES)
def test_every_attribute_arrives(name):
    text, value = ATTRIBUTES[name]
    assert params_of('def Camera "c" {\n' + text + "\n}\n")[0][name] == value


def test_attributes_and_transforms_are_those_of_the_frame():
    text = """def Xform "a" {
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 3: (4, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Camera "c" {
        float focalLength.timeSamples = { 1: 10, 3: 30 }
        double3 xformOp:translate = (0, 1, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""
    stage = opened(text)
    camera = cameras.find_camera(stage, "/a/c")
    assert cameras.camera_params(camera, Usd.TimeCode(2), Diagnostics())["focalLength"] == 20
    assert tuple(cameras.camera_transform(camera, Usd.TimeCode(2))[3, :3]) == (2, 1, 0)


def test_clipping_planes():
    params, diagnostics = params_of('def Camera "c" {\n    float4[] clippingPlanes = [(0, 0, 1, 2), (1, 0, 0, 3)]\n}\n')
    assert params["clippingPlanes"].tolist() == [[0, 0, 1, 2], [1, 0, 0, 3]]
    assert not list(diagnostics)


def test_what_cameras_do_not_do_yet_is_said():
    shutter = "    double shutter:open = -0.25\n    double shutter:close = 0.25\n"
    _, diagnostics = params_of('def Camera "c" {\n' + shutter + "}\n")
    assert [(d.code, d.location, d.severity) for d in diagnostics] == [("motion-blur-unsupported", "/c", "info")]
    assert not list(params_of('def Camera "c" {\n}\n')[1])


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"horizontalAperture": 30.0, "verticalAperture": 20.0}, 1.5),
        ({}, 20.955 / 15.2908),
        ({"verticalAperture": 0.0}, 1),
        ({"horizontalAperture": float("nan")}, 1),
        ({"horizontalAperture": -3.0}, 1),
        ({"horizontalAperture": 1e-9}, 1),
    ],
)
def test_the_aspect_of_the_aperture(params, expected):
    assert cameras.aspect_ratio(params) == pytest.approx(expected, rel=1e-6)


INSTANCED = """def Xform "rig" {
    def Camera "cam" {
    }
}
def Xform "copy" (
    instanceable = true
    prepend references = </rig>
) {
}
def Scope "cam2" {
    def Camera "cam2" {
    }
}
"""


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("cam", "/rig/cam"),
        ("rig/cam", "/rig/cam"),
        ("/copy/cam", "/copy/cam"),  # inside an instance
        ("cam2", "/cam2/cam2"),  # a name is a camera's name
        ("rig", None),
        ("/rig", None),
        ("nobody", None),
    ],
)
def test_cameras_are_found_by_name_and_path(name, path):
    stage = opened(INSTANCED)
    camera = cameras.find_camera(stage, name)
    assert (str(camera.GetPath()) if camera else None) == path


def test_cameras_inside_instances_count():
    stage = opened(INSTANCED)
    assert [str(c.GetPath()) for c in cameras.all_cameras(stage)] == ["/rig/cam", "/copy/cam", "/cam2/cam2"]


def free(text: str, purposes=("default", "proxy"), time=None):
    code = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
    params, transform = cameras.free_camera(opened(text), code, frozenset(purposes))
    return params, tuple(transform[3, :3])


CUBE = 'def Cube "c" {\n    double size = SIZE\n}\n'


def test_the_free_camera_frames_what_is_drawn_at_the_frame():
    text = (
        CUBE.replace("SIZE", "2") + 'def Sphere "g" {\n    uniform token purpose = "guide"\n    double radius = 9\n}\n'
    )
    _, plain = free(text)
    _, guides = free(text, ("default", "guide"))
    assert plain == free(CUBE.replace("SIZE", "2"))[1] and guides[2] > 3 * plain[2]
    moving = """def Cube "c" {
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (5, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
    assert free(moving, time=1)[1][0] == 0 and free(moving, time=2)[1][0] == 5


def test_the_free_camera_clips_nothing_of_the_stage():
    """By usdrecord's rule: near 1, so that a small stage is seen from 1 further; far beyond everything."""
    params, position = free(CUBE.replace("SIZE", "0.01"))
    assert params["clippingRange"] == (1, 1e6)
    assert position[2] == pytest.approx(1 + 0.005 * (2**0.5 / (20.955 / 2 / 50) + 1), rel=1e-4)
    params, position = free(CUBE.replace("SIZE", "1e6"))
    assert (
        params["clippingRange"][1] == pytest.approx(10 * position[2], rel=0.2) and params["projection"] == "perspective"
    )


def test_the_free_camera_of_an_empty_stage():
    assert free("")[1] == pytest.approx((0, 0, 2**0.5 / (20.955 / 2 / 50) + 1), rel=1e-5)


def test_the_free_camera_counts_in_single_precision():
    """As usdrecord does: the same picture to the bit."""
    _, position = free(CUBE.replace("SIZE", "2.2"))
    radius = np.float32(math.sqrt(2 * 1.1**2))
    angle = np.float32(Gf.Camera().GetFieldOfView(Gf.Camera.FOVHorizontal) / 2)
    distance = np.float32(np.float32(float(radius) / math.tan(math.radians(float(angle)))) + 1.1)
    assert position == (0, 0, float(distance))
