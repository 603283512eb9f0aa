# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Lights: raw inputs, and what of them is not rendered."""

from __future__ import annotations

import pytest
from usda import said, translation_of


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


# Each light's inputs that are numbers: (type, input, value).
NUMBERS = [
    ("RectLight", "intensity", 3),
    ("RectLight", "exposure", 2),
    ("RectLight", "colorTemperature", 3000),
    ("RectLight", "diffuse", 0.5),
    ("RectLight", "specular", 0.25),
    ("RectLight", "width", 4),
    ("RectLight", "height", 5),
    ("DiskLight", "radius", 6),
    ("SphereLight", "radius", 6),
    ("CylinderLight", "radius", 6),
    ("CylinderLight", "length", 7),
    ("DistantLight", "angle", 8),
]


@pytest.mark.parametrize(("schema", "name", "value"), NUMBERS)
def test_every_number_arrives_at_the_frame(translated, schema, name, value):
    text = f'def {schema} "l" {{ float inputs:{name}.timeSamples = {{ 1: 0.125, 3: {value * 2 - 0.125} }} }}'
    params = translated(text, time=2)[0].told["/l"]["params"]
    assert params["type"] == schema and params[name] == pytest.approx(value)


@pytest.mark.parametrize(
    ("line", "schema", "name", "value"),
    [
        ("bool inputs:enableColorTemperature = 1", "RectLight", "enableColorTemperature", True),
        ("bool inputs:normalize = 1", "RectLight", "normalize", True),
        ("bool treatAsPoint = 1", "SphereLight", "treatAsPoint", True),
        ("bool treatAsLine = 1", "CylinderLight", "treatAsLine", True),
        ('token inputs:texture:format = "angular"', "DomeLight", "texture:format", "angular"),
        ("bool inputs:shadow:enable = 0", "SphereLight", "shadow:enable", False),
    ],
)
def test_every_switch_arrives(translated, line, schema, name, value):
    texture = "; asset inputs:texture:file = @t.exr@" if schema == "DomeLight" else ""
    assert translated(f'def {schema} "l" {{ {line}{texture} }}')[0].told["/l"]["params"][name] == value


def test_shaping_arrives_where_it_is_applied_or_authored(translated):
    values = """float inputs:shaping:cone:angle = 30; float inputs:shaping:cone:softness = 0.5
    float inputs:shaping:focus = 8; color3f inputs:shaping:focusTint = (1, 0, 0)
    asset inputs:shaping:ies:file = @profile.ies@"""
    delegate, _ = translated(
        f"""
def SphereLight "all" (prepend apiSchemas = ["ShapingAPI"]) {{ {values} }}
def SphereLight "authored" {{ {values} }}
def SphereLight "applied" (prepend apiSchemas = ["ShapingAPI"]) {{}}
def SphereLight "cut" {{ float inputs:shaping:focus = 8 }}
def SphereLight "none" {{}}
""",
        convert_color=lambda rgb, space: tuple(x / 2 for x in rgb),
    )

    def shaping(name):
        return {k: v for k, v in delegate.told["/" + name]["params"].items() if k.startswith("shaping:")}

    everything = {
        "shaping:cone:angle": 30,
        "shaping:cone:softness": 0.5,
        "shaping:focus": 8,
        "shaping:focusTint": (0.5, 0, 0),  # a colour: it goes to the rendering space
        "shaping:ies:file": "profile.ies",
    }
    assert shaping("all") == everything and shaping("authored") == everything
    # The schema's own fallback of 90 degrees counts only where something of it is there.
    assert shaping("applied")["shaping:cone:angle"] == 90 and shaping("cut")["shaping:cone:angle"] == 90
    assert shaping("none") == {}


def test_colours_enter_the_rendering_space_from_their_own(translated):
    delegate, _ = translated(
        'def SphereLight "l" {\n    color3f inputs:color = (1, 0.5, 0) (\n        colorSpace = "acescg"\n    )\n}\n',
        convert_color=lambda rgb, space: (*rgb[:2], 7) if space == "acescg" else rgb,
    )
    assert delegate.told["/l"]["params"]["color"] == (1, 0.5, 7)


def test_lights_stand_in_the_world_or_in_a_prototype(translated):
    delegate, _ = translated(
        """
def Xform "a" {
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def SphereLight "l" {
        double3 xformOp:translate = (0, 2, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
def PointInstancer "pi" {
    int[] protoIndices = [0, 1]
    point3f[] positions = [(0, 0, 0), (5, 0, 0)]
    rel prototypes = [</pi/cube>, </pi/lamp>]
    def Cube "cube" {}
    def SphereLight "lamp" {}
}
"""
    )
    assert translation_of(delegate.told["/a/l"]) == (1, 2, 0) and "instancer" not in delegate.told["/a/l"]
    lamp = delegate.told["/pi/lamp"]
    assert (lamp["instancer"], lamp["prototype"], translation_of(lamp)) == ("/pi", 1, (0, 0, 0))


@pytest.mark.parametrize("collection", ["lightLink", "shadowLink"])
def test_linking_is_said(translated, collection):
    _, diagnostics = translated(
        f"""
def SphereLight "all" {{ bool collection:{collection}:includeRoot = 1 }}
def SphereLight "some" {{ rel collection:{collection}:includes = </c> }}
def SphereLight "without" {{ rel collection:{collection}:excludes = </c> }}
def Cube "c" {{}}
"""
    )
    code = {"lightLink": "light-link-unsupported", "shadowLink": "shadow-link-unsupported"}[collection]
    assert said(diagnostics) == [(code, "/some"), (code, "/without")]


def test_portals_are_said(translated):
    _, diagnostics = translated('def DomeLight "d" { rel portals = </d/p>; def PortalLight "p" {} }')
    assert said(diagnostics) == [("light-portal-unsupported", "/d"), ("prim-unsupported", "/d/p")]


def test_the_camera_light_shows_a_white_surface_white(translated):
    """Irradiance pi on what faces it, from where the camera looks."""
    import numpy as np
    from hdwavefront.stage_adapters.lights import CAMERA_LIGHT_PATH, emit_camera_light
    from recording import RecordingDelegate

    class Translated:
        sink = RecordingDelegate()

    transform = np.arange(16.0).reshape(4, 4)
    emit_camera_light(Translated, transform)
    light = Translated.sink.told[CAMERA_LIGHT_PATH]
    assert light["params"]["type"] == "DistantLight" and light["params"]["normalize"] is True
    assert light["params"]["intensity"] == pytest.approx(np.pi) and light["params"]["color"] == (1, 1, 1)
    assert (light["transform"] == transform).all()
