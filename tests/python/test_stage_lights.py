# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Lights: raw inputs, and what of them is not rendered."""

from __future__ import annotations

import pytest


def test_shadows_that_no_light_casts_are_said(translated):
    _, diagnostics = translated(
        """
def SphereLight "odd" { color3f inputs:shadow:color = (1, 0, 0); float inputs:shadow:distance = 3 }
def SphereLight "plain" { color3f inputs:shadow:color = (0, 0, 0); float inputs:shadow:falloff = -1 }
"""
    )
    assert [(d.code, d.location) for d in diagnostics] == [("light-unsupported-input", "/odd")] * 2


def test_lights_that_the_camera_shall_not_see(translated):
    """UsdLux has no attribute for it; the ones that stages carry are understood, and the first one found counts."""
    delegate, _ = translated(
        """
def SphereLight "plain" {}
def SphereLight "usd" { custom bool inputs:visibility:camera = 0; bool primvars:arnold:visibility:camera = 1 }
def SphereLight "arnold" { bool primvars:arnold:visibility:camera = 0 }
def SphereLight "renderman" { int primvars:ri:attributes:visibility:camera = 0 }
def SphereLight "seen" { float primvars:arnold:camera = 1 }
def SphereLight "odd" { string primvars:arnold:camera = "no" }
"""
    )
    seen = {name: delegate.told["/" + name]["params"].get("visibleToCamera") for name in ("plain", "usd", "arnold")}
    assert seen == {"plain": None, "usd": False, "arnold": False}
    seen = {name: delegate.told["/" + name]["params"].get("visibleToCamera") for name in ("renderman", "seen", "odd")}
    assert seen == {"renderman": False, "seen": True, "odd": None}


def test_lights_come_raw(translated):
    delegate, diagnostics = translated(
        """
def RectLight "r" (prepend apiSchemas = ["ShapingAPI"]) {
    float inputs:intensity = 3
    float inputs:exposure = 2
    color3f inputs:color = (1, 0.5, 0.25)
    float inputs:width = 4
    asset inputs:texture:file = @missing.exr@
    float inputs:shaping:cone:angle = 30
}
def SphereLight "s" { bool inputs:normalize = 1; bool treatAsPoint = 1 }
def DistantLight "d" { float inputs:angle = 1 }
def Cube "c" {}
"""
    )
    rect = delegate.told["/r"]["params"]
    assert rect["type"] == "RectLight" and (rect["intensity"], rect["exposure"], rect["width"]) == (3, 2, 4)
    assert rect["color"] == (1, 0.5, 0.25) and rect["shaping:cone:angle"] == 30
    assert rect["texture:file"]["authored"] == "missing.exr"
    sphere = delegate.told["/s"]["params"]
    assert sphere["normalize"] is True and sphere["treatAsPoint"] is True and sphere["radius"] == 0.5
    assert "shaping:cone:angle" not in sphere
    assert not list(diagnostics)


@pytest.mark.parametrize(("up", "axis", "expected"), [("Y", "scene", "Y"), ("Z", "scene", "Z"), ("Y", "Z", "Z")])
def test_the_pole_of_a_dome(translated, up, axis, expected):
    delegate, _ = translated(f'( upAxis = "{up}" )\ndef DomeLight_1 "d" {{ uniform token poleAxis = "{axis}" }}')
    assert delegate.told["/d"]["params"]["poleAxis"] == expected
    delegate, _ = translated(f'( upAxis = "{up}" )\ndef DomeLight "d" {{}}')
    assert delegate.told["/d"]["params"]["poleAxis"] == "Y"
