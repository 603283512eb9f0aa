# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""RenderSettings, RenderProduct, RenderVar and RenderPass prims: what they ask for is done, or said."""

from __future__ import annotations

import pytest
from hdwavefront.errors import Diagnostics, HdWavefrontError
from hdwavefront.stage_adapters.render_settings import (
    Shot,
    find_render_settings,
    read_render_settings,
    settings_of_pass,
)
from pxr import Sdf, Usd
from usda import said

STAGE = """#usda 1.0
(
    METADATA
)
def RenderSettings "s" {
    SETTINGS
}
def RenderSettings "other" {
}
def RenderProduct "p" {
    PRODUCT
}
VARS
def Camera "a" {
}
def Camera "b" {
}
"""
PRODUCTS = "rel products = [</p>]"
NAMED = 'token productName = "p.exr"; rel orderedVars = [</v>]'
VAR = 'def RenderVar "v" { uniform string sourceName = "depth" }'


def opened(settings: str = "", product: str = "", variables: str = VAR, metadata: str = "") -> Usd.Stage:
    text = STAGE
    for mark, lines in (("SETTINGS", settings), ("PRODUCT", product), ("VARS", variables), ("METADATA", metadata)):
        text = text.replace(mark, lines)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    text = text.replace("{ ", "{\n").replace(" }", "\n}").replace("; ", "\n").replace("} def", "}\ndef")
    assert layer.ImportFromString(text)
    return Usd.Stage.Open(layer)


def read(settings: str = "", product: str = "", variables: str = VAR, time: float | None = None):
    stage, diagnostics = opened(settings, product, variables), Diagnostics()
    code = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
    return read_render_settings(find_render_settings(stage, "/s", diagnostics), code, diagnostics), diagnostics


@pytest.mark.parametrize(
    ("line", "field", "value"),
    [
        ("rel camera = </b>", "camera", "/b"),
        ("uniform int2 resolution = (30, 12)", "resolution", (30, 12)),
        ("uniform float pixelAspectRatio = 2", "pixel_aspect_ratio", 2),
        ('uniform token aspectRatioConformPolicy = "adjustApertureWidth"', "window_policy", "adjustApertureWidth"),
        ('uniform token[] includedPurposes = ["render"]', "purposes", {"default", "render"}),
        ('uniform token[] materialBindingPurposes = ["preview", ""]', "material_purpose", "preview"),
        ('uniform token[] materialBindingPurposes = [""]', "material_purpose", ""),
        ('uniform token renderingColorSpace = "acescg"', "rendering_space", "acescg"),
        ("uniform float4 dataWindowNDC = (0, 0, 0.5, 1)", "data_window", (0, 0, 0.5, 1)),
        ("uniform bool disableDepthOfField = 1", "disable_depth_of_field", True),
        ("float pixelAspectRatio.timeSamples = { 1: 1, 2: 3 }", "pixel_aspect_ratio", 3),
        ("custom int wavefront:samples = 5", "settings", {"samples": 5}),
        ("custom int wavefront:samples.timeSamples = { 1: 7, 2: 9 }", "settings", {"samples": 9}),
    ],
)
def test_every_attribute_is_read(line, field, value):
    got, diagnostics = read(line, time=2)
    assert getattr(got if hasattr(got, field) else got.shot, field) == value
    assert not list(diagnostics)


def test_what_is_not_authored_is_left_to_the_defaults():
    got, _ = read()
    assert (got.shot.camera, got.shot.resolution, got.shot.pixel_aspect_ratio, got.shot.window_policy) == (
        "",
        None,
        None,
        "",
    )
    assert (got.purposes, got.material_purpose, got.rendering_space) == (None, None, "")
    assert got.shot.disable_depth_of_field is False and got.products == [] and got.settings == {}


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("uniform float4 dataWindowNDC = (0, 0, -0.5, 1)", "render-settings-bad-value"),
        ("uniform float4 dataWindowNDC = (0, 0, 1e9, 1)", "render-settings-bad-value"),
        ("uniform float pixelAspectRatio = -1", "render-settings-bad-value"),
        ("uniform float pixelAspectRatio = 0", "render-settings-bad-value"),
        ('uniform token aspectRatioConformPolicy = "stretch"', "render-settings-bad-value"),
        ('uniform token[] includedPurposes = ["beauty", "render"]', "render-settings-bad-value"),
    ],
)
def test_what_cannot_be_done_is_said_and_stops_nothing(line, code):
    got, diagnostics = read(line)
    assert said(diagnostics) == [(code, "/s")]
    assert got.shot.pixel_aspect_ratio is None and got.shot.window_policy == ""


def test_a_data_window_that_is_the_whole_image_is_nothing_to_say():
    assert not list(read("uniform float4 dataWindowNDC = (0, 0, 1, 1)")[1])


@pytest.mark.parametrize(
    ("name", "aov"),
    [
        ("Ci", "color"),
        ("color", "color"),
        ("C.*[LO]", None),
        ("lpe:C.*[LO]", "color"),
        ("depth", "depth"),
        ("Z", "cameraDepth"),
        ("cameraDepth", "cameraDepth"),
        ("N", "normal"),
        ("albedo", "albedo"),
        ("primId", "primId"),
        ("instanceId", "instanceId"),
        ("elementId", "elementId"),
        ("sampleCount", "sampleCount"),
    ],
)
def test_vars_name_aovs(name, aov):
    got, diagnostics = read(PRODUCTS, NAMED, f'def RenderVar "v" {{ uniform string sourceName = "{name}" }}')
    assert [p.aovs for p in got.products] == ([(aov,)] if aov else [])
    if aov is None:
        assert said(diagnostics) == [("render-var-unsupported", "/v"), ("render-product-empty", "/p")]


def test_a_var_without_a_source_is_its_own_name_and_doubles_count_once():
    variables = 'def RenderVar "depth" {} def RenderVar "v" { uniform string sourceName = "depth" }'
    got, diagnostics = read(PRODUCTS, 'token productName = "p.exr"; rel orderedVars = [</depth>, </v>]', variables)
    assert not list(diagnostics)
    assert [(p.path, p.name, p.aovs) for p in got.products] == [("/p", "p.exr", ("depth",))]


@pytest.mark.parametrize(
    ("settings", "product", "expected"),
    [
        ("rel products = [</a>]", NAMED, [("render-product-missing", "/a")]),
        (PRODUCTS, f'token productType = "deepRaster"; {NAMED}', [("render-product-type", "/p")]),
        (PRODUCTS, "rel orderedVars = [</v>]", [("render-product-name", "/p")]),
        (PRODUCTS, 'token productName = "p.exr"', [("render-product-empty", "/p")]),
        (
            PRODUCTS,
            'token productName = "p.exr"; rel orderedVars = [</a>, </v>]',
            [("render-var-missing", "/a")],
        ),
        (PRODUCTS, f"custom int wavefront:samples = 4; {NAMED}", [("render-product-setting", "/p")]),
        (PRODUCTS, f"float pixelAspectRatio = 0; {NAMED}", [("render-settings-bad-value", "/p")]),
        (PRODUCTS, f"float4 dataWindowNDC = (1, 0, 0, 1); {NAMED}", [("render-settings-bad-value", "/p")]),
        (f"rel camera = </a>; {PRODUCTS}", f"rel camera = </b>; {NAMED}", []),
    ],
)
def test_what_products_cannot_have_is_said(settings, product, expected):
    _, diagnostics = read(settings, product)
    assert said(diagnostics) == expected


def test_a_product_looks_where_it_says_and_else_where_its_settings_say():
    settings = f"rel camera = </a>; int2 resolution = (8, 8); float pixelAspectRatio = 2; {PRODUCTS}"
    product = (
        'int2 resolution = (4, 8); token aspectRatioConformPolicy = "cropAperture"; '
        f"float4 dataWindowNDC = (0, 0, 1, 0.5); bool disableDepthOfField = 1; {NAMED}"
    )
    got, diagnostics = read(settings, product)
    assert not list(diagnostics)
    assert got.shot == Shot("/a", (8, 8), 2)
    assert got.products[0].shot == Shot("/a", (4, 8), 2, "cropAperture", (0, 0, 1, 0.5), True)


def test_a_products_camera_counts_where_the_settings_have_none():
    assert read(PRODUCTS, f"rel camera = </b>; {NAMED}")[0].shot.camera == "/b"
    assert read(f"rel camera = </a>; {PRODUCTS}", f"rel camera = </b>; {NAMED}")[0].shot.camera == "/a"


def test_settings_are_found_by_name_by_metadata_or_not_at_all():
    diagnostics = Diagnostics()
    stage = opened(metadata='renderSettingsPrimPath = "/s"')
    assert str(find_render_settings(stage, "", diagnostics).GetPath()) == "/s"
    assert str(find_render_settings(stage, "/other", diagnostics).GetPath()) == "/other"
    assert find_render_settings(opened(), "", diagnostics) is None and not list(diagnostics)
    for wrong in ("/a", "/nobody", "s"):
        with pytest.raises(HdWavefrontError, match=rf"'{wrong}' in the stage. The stage has: /s, /other"):
            find_render_settings(stage, wrong, diagnostics)
    for wrong in ("/a", "/nobody"):
        diagnostics = Diagnostics()
        assert find_render_settings(opened(metadata=f'renderSettingsPrimPath = "{wrong}"'), "", diagnostics) is None
        assert said(diagnostics) == [("render-settings-missing", wrong)]


def test_a_pass_names_its_settings():
    diagnostics = Diagnostics()
    stage = opened(variables='def RenderPass "pass" { rel renderSource = </s> } def RenderPass "empty" {}')
    assert settings_of_pass(stage, "/pass", diagnostics) == "/s"
    assert said(diagnostics) == [("render-pass-partial", "/pass")]
    with pytest.raises(HdWavefrontError, match="names no renderSource"):
        settings_of_pass(stage, "/empty", diagnostics)
    for wrong in ("/s", "pass", "/nobody"):
        with pytest.raises(HdWavefrontError, match="no RenderPass prim"):
            settings_of_pass(stage, wrong, diagnostics)


def rendered(stage_file, recorded, settings: str, camera: str = "", **options):
    """Prepared over the recording delegate."""
    import hdwavefront

    text = 'def RenderSettings "s" {\n' + settings.replace("; ", "\n") + '\n}\ndef Camera "c" {\n' + camera + "\n}\n"
    render = hdwavefront.open(stage_file(text), width=8, render_settings="/s", **options)
    render.prepare()
    return render, recorded[-1]


def test_depth_of_field_can_be_switched_off(stage_file, recorded):
    lens = "float fStop = 2"
    off = rendered(stage_file, recorded, "uniform bool disableDepthOfField = 1", lens)[1]
    assert off.told["/c"]["params"]["fStop"] == 0
    on = rendered(stage_file, recorded, "uniform bool disableDepthOfField = 0", lens)[1]
    assert on.told["/c"]["params"]["fStop"] == 2


def test_the_rendering_space_of_the_prim_counts_unless_a_flag_says_otherwise(stage_file, recorded):
    space = 'uniform token renderingColorSpace = "acescg"'
    assert rendered(stage_file, recorded, space)[0].colors.rendering_space == "acescg"
    flagged = rendered(stage_file, recorded, space, rendering_space="lin_rec2020")[0]
    assert flagged.colors.rendering_space == "lin_rec2020"
    render, _ = rendered(stage_file, recorded, 'uniform token renderingColorSpace = "nowhere"')
    assert render.colors.rendering_space == "lin_rec709"
    assert said(render.diagnostics) == [("render-settings-bad-value", "/s")]


def test_a_camera_that_the_prim_misses_is_said(stage_file, recorded):
    render, delegate = rendered(stage_file, recorded, "rel camera = </nobody>")
    assert said(render.diagnostics) == [("camera-missing", "/s")] and delegate.render_pass["camera"] == "/c"


def test_a_resolution_without_pixels_is_an_error(stage_file, recorded):
    import hdwavefront

    text = 'def RenderSettings "s" {\nuniform int2 resolution = (0, 9)\n}\n'
    with pytest.raises(HdWavefrontError, match="0 x 9 has no pixels"):
        hdwavefront.open(stage_file(text), render_settings="/s").prepare()


def test_material_purposes_of_the_prim_count(stage_file, recorded):
    text = """def RenderSettings "s" {
    uniform token[] materialBindingPurposes = ["preview"]
}
def Material "full" {
    token outputs:surface.connect = </full/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
    }
}
def Material "preview" {
    token outputs:surface.connect = </full/s.outputs:surface>
}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </full>
    rel material:binding:preview = </preview>
}
"""
    import hdwavefront

    for options, expected in (({"render_settings": "/s"}, "/preview"), ({}, "/full")):
        hdwavefront.open(stage_file(text), width=8, **options).prepare()
        assert recorded[-1].told["/c"]["material"] == expected
