# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The Python API over a delegate that records: each option reaches the delegate or the file."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio
import pytest
from hdwavefront.errors import HdWavefrontError, UsageError
from recording import RecordingDelegate
from usda import QUAD, said

STAGE = """(
    startTimeCode = 3
)
def Camera "main_cam" {
    float horizontalAperture = 20
    float verticalAperture = 10
}
def Mesh "m" {
    QUAD
}
def Material "red" {
    token outputs:surface.connect = </red/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0)
        token outputs:surface
    }
}
over "m" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </red>
}
""".replace("QUAD", QUAD).replace('over "m"', 'def Cube "c"')


@pytest.fixture
def opened(recorded, stage_file):
    """A prepared render of STAGE and its delegate."""
    import hdwavefront

    def call(text=STAGE, prepare=True, **options):
        render = hdwavefront.open(stage_file(text), **{"width": 8, **options})
        if prepare:
            render.prepare()
        return render, recorded[-1]

    return call


@pytest.mark.parametrize(("complexity", "level"), [("low", 0), ("medium", 1), ("high", 2), ("veryhigh", 3)])
def test_complexity_is_the_level_of_subdivision(opened, complexity, level):
    """As UsdAppUtils has it."""
    assert opened(complexity=complexity)[1].told["/m"]["refine_level"] == level


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"complexity": "extreme"}, "complexity 'extreme'"),
        ({"color_mode": "best"}, "color correction mode 'best'"),
        ({"width": 0}, "width is 0"),
        ({"height": -1}, "height is -1"),
        ({"render_settings": "/s", "render_pass": "/p"}, "cannot both be given"),
        ({"settings": {"samples": "many"}}, "samples wants"),
    ],
)
def test_options_that_make_no_sense(opened, monkeypatch, options, words):
    def refuse(self, token, value):
        if token == "samples":
            raise ValueError("samples wants a whole number")

    monkeypatch.setattr(RecordingDelegate, "_set_setting", refuse)
    with pytest.raises(UsageError, match=words):
        opened(**options)


@pytest.mark.parametrize(
    ("purposes", "tags"),
    [(None, ["geometry", "proxy"]), ((), ["geometry"]), (("render",), ["geometry", "render"])],
)
def test_purposes_become_render_tags(opened, purposes, tags):
    assert opened(purposes=purposes)[1].render_pass["render_tags"] == tags


@pytest.mark.parametrize(
    ("options", "size"),
    [
        ({"width": 40}, (40, 20)),
        ({"width": None, "height": 40}, (80, 40)),
        ({"width": 30, "height": 40}, (30, 40)),
        ({"width": None}, (960, 480)),
        ({"width": 1}, (1, 1)),
    ],
)
def test_the_size_follows_the_cameras_aspect(opened, options, size):
    render, delegate = opened(**options)
    assert render.size == size and (delegate.render_pass["width"], delegate.render_pass["height"]) == size


@pytest.mark.parametrize(("frame", "code"), [(None, 3), ("default", None), (7, 7), ("7.5", 7.5)])
def test_the_frame(opened, frame, code):
    render, _ = opened(frame=frame)
    assert render.time.IsDefault() if code is None else render.time.GetValue() == code


def test_the_device_and_the_libraries_reach_the_delegate(opened):
    options = opened(device="some card")[1].options
    assert options["device"] == "some card" and options["materialx_libraries"].endswith("data/materialx")


def test_a_device_that_is_not_there_is_one_sentence(opened, monkeypatch):
    import hdwavefront._core as core

    def fail(**options):
        raise RuntimeError("There is no device 'x'.")

    monkeypatch.setattr(core, "RenderDelegate", fail)
    with pytest.raises(HdWavefrontError, match="There is no device 'x'"):
        opened()


def test_colours_enter_the_rendering_space(opened):
    (node,) = opened(rendering_space="acescg")[1].told["/red"][""]["nodes"]
    assert node["parameters"]["diffuseColor"] == pytest.approx((0.61310, 0.07019, 0.02062), abs=1e-4)


@pytest.mark.parametrize("visible", [True, False])
def test_whether_the_sky_is_seen(opened, visible):
    assert opened(dome_visible=visible)[1].settings["domeLightCameraVisibility"] is visible


def test_the_policy_of_the_option_wins(opened):
    text = STAGE + 'def RenderSettings "s" {\n    uniform token aspectRatioConformPolicy = "cropAperture"\n}\n'
    assert opened()[1].render_pass["window_policy"] == "expandAperture"
    assert opened(text, render_settings="/s")[1].render_pass["window_policy"] == "cropAperture"
    both = opened(text, render_settings="/s", window_policy="adjustApertureWidth")[1]
    assert both.render_pass["window_policy"] == "adjustApertureWidth"


def test_wrong_settings_of_the_stage_are_said(opened, monkeypatch):
    def refuse(self, token, value):
        if token == "nonsense":
            raise ValueError('There is no render setting "nonsense".')

    monkeypatch.setattr(RecordingDelegate, "_set_setting", refuse)
    text = STAGE + 'def RenderSettings "s" {\n    custom int wavefront:nonsense = 1\n}\n'
    assert said(opened(text, render_settings="/s")[0].diagnostics) == [("render-setting", "/s.wavefront:nonsense")]


def test_settings_given_at_the_start_count(opened):
    render, delegate = opened(settings={"samples": 5})
    assert delegate.settings["samples"] == 5
    render.start(samples=6, radianceClamp=2.0)
    assert delegate.settings["samples"] == 6 and delegate.settings["radianceClamp"] == 2.0
    commits = [name for name, _, _ in delegate.calls].count("commit")
    render.start()  # nothing new: not prepared again
    assert [name for name, _, _ in delegate.calls].count("commit") == commits


def test_another_frame_is_prepared_again(opened):
    render, delegate = opened()
    render.set_frame(9)
    render.start()
    assert render.time.GetValue() == 9 and [name for name, _, _ in delegate.calls].count("commit") == 2


def test_pause_resume_and_stop_reach_the_delegate(opened):
    render, delegate = opened()
    render.pause()
    render.resume()
    render.stop()
    assert [name for name, _, _ in delegate.calls][-3:] == ["pause", "resume", "stop"]


def test_the_delegates_diagnostics_are_passed_on_once(opened, monkeypatch):
    told = [SimpleNamespace(severity="warning", code=f"c{i}", location=f"/p{i}", message="m") for i in range(3)]
    asked = []

    def diagnostics(self, since=0):
        asked.append(since)
        return told[since:]

    monkeypatch.setattr(RecordingDelegate, "_diagnostics", diagnostics)
    fresh = []
    render, _ = opened(on_diagnostic=fresh.append)
    render.start()
    assert render.wait()
    assert asked == [0, 3] and said(fresh) == [(f"c{i}", f"/p{i}") for i in range(3)]


def test_textures_that_are_data_are_not_managed(opened, monkeypatch, tmp_path):
    path = tmp_path / "a.png"
    spec = oiio.ImageSpec(2, 2, 3, "uint8")
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(np.full((2, 2, 3), 128, dtype=np.uint8))
    output.close()
    requests = [
        SimpleNamespace(
            key=k, resolved_path=str(path), authored_path="a", color_space="sRGB", is_color=k == 1, location=""
        )
        for k in range(3)
    ]
    monkeypatch.setattr(RecordingDelegate, "_pending_textures", lambda self: requests)
    textures = opened()[1].textures
    assert textures[0].dtype == np.uint8 and textures[0][0, 0, 0] == 128
    assert textures[1].dtype == np.float16 and textures[1][0, 0, 0] == pytest.approx(0.2159, abs=1e-3)
    assert set(textures) == {0, 1, 2}


# -- Files. The delegate's pixels are colour and alpha 0.25: premultiplied white.


@pytest.fixture
def saved(opened, tmp_path, monkeypatch):
    """Saves under a name; gives (spec, pixels). The colour kernel writes 0.5 everywhere and keeps what it was given."""
    kernel = SimpleNamespace(given=None, glsl="")

    def run_kernel(self, pixels, *, glsl, **_):
        kernel.given, kernel.glsl = np.array(pixels), glsl
        return np.full_like(pixels, 0.5)

    monkeypatch.setattr(RecordingDelegate, "_run_color_kernel", run_kernel)

    def call(name, text=STAGE, aovs=None, **options):
        kernel.given = None
        render, _ = opened(text, **options)
        render.save(str(tmp_path / name), aovs)
        config = oiio.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)
        source = oiio.ImageInput.open(str(tmp_path / name), config)
        return source.spec(), source.read_image(oiio.FLOAT)

    call.kernel = kernel
    return call


@pytest.mark.parametrize(
    ("name", "options", "managed"),
    [
        ("a.exr", {}, False),
        ("a.exr", {"color_mode": "openColorIO"}, True),
        ("a.exr", {"color_mode": "sRGB"}, True),
        ("a.exr", {"color_mode": "disabled"}, False),
        ("a.exr", {"view": "Un-tone-mapped"}, True),
        ("a.exr", {"display": "sRGB - Display"}, True),
        ("a.exr", {"view": "Un-tone-mapped", "color_mode": "disabled"}, False),
        ("a.hdr", {}, False),
        ("a.png", {}, True),
        ("a.png", {"color_mode": "sRGB"}, True),
        ("a.png", {"color_mode": "disabled"}, False),
        ("a.tiff", {}, True),
    ],
)
def test_when_colour_goes_to_a_display(saved, name, options, managed):
    _, pixels = saved(name, **options)
    assert (saved.kernel.given is not None) is managed
    # Straight alpha in PNG and TIFF, premultiplied colour in EXR; the alpha itself is never managed.
    expected = (0.5 if managed else 1) if name[2:] in ("png", "tiff") else 0.125 if managed else 0.25
    assert pixels[0, 0, 0] == pytest.approx(expected, abs=3e-3)
    if pixels.shape[2] == 4:
        assert pixels[0, 0, 3] == pytest.approx(0.25, abs=3e-3)


def test_the_view_sees_straight_colour_or_colour_over_black(saved):
    saved("a.png")
    assert saved.kernel.given[0, 0].tolist() == [1, 1, 1, 0.25]
    saved("a.jpg")
    assert saved.kernel.given[0, 0].tolist() == [0.25, 0.25, 0.25, 0.25]


def test_which_transform_is_run(saved):
    from hdwavefront.color.manager import ColorManager, gpu_shader

    colors = ColorManager()
    saved("a.png", color_mode="sRGB")
    assert saved.kernel.glsl == gpu_shader(colors.encoding_processor("sRGB"))["glsl"]
    saved("a.png", view="Un-tone-mapped")
    view = colors.display_processor(colors.display_and_view()[0], "Un-tone-mapped")
    assert saved.kernel.glsl == gpu_shader(view)["glsl"]


def test_layers_of_a_managed_exr_stay_as_they_are(saved):
    spec, pixels = saved("a.exr", aovs=["color", "depth"], color_mode="sRGB")
    names = list(spec.channelnames)
    assert set(names) == {"R", "G", "B", "A", "depth.Z"} and pixels[0, 0, names.index("depth.Z")] == 0.25


def test_metadata(saved, monkeypatch):
    matrices = (np.arange(16.0).reshape(4, 4), np.arange(16.0, 32.0).reshape(4, 4))
    monkeypatch.setattr(RecordingDelegate, "_camera_matrices", lambda self: matrices)
    text = STAGE + 'def RenderSettings "s" {\n    uniform float pixelAspectRatio = 2\n}\n'
    spec, _ = saved("a.exr", text, frame=4, render_settings="/s", rendering_space="acescg", settings={"samples": 9})
    assert np.allclose(np.reshape(spec.getattribute("worldToCamera"), (4, 4)), matrices[0])
    assert np.allclose(np.reshape(spec.getattribute("worldToNDC"), (4, 4)), matrices[1])
    assert spec.get_float_attribute("hdwavefront:frame") == 4
    assert spec.get_float_attribute("PixelAspectRatio") == 2
    assert spec.get_int_attribute("hdwavefront:samples") == 9 and spec.get_int_attribute("hdwavefront:samplesDone") == 7
    assert spec.get_int_attribute("hdwavefront:enableShadows", -1) == 1
    assert spec.get_string_attribute("hdwavefront:camera") == "/main_cam"
    assert spec.get_string_attribute("hdwavefront:renderingColorSpace") == "acescg"
    assert spec.get_string_attribute("Software").startswith("hdWavefront 0.0.test")
    assert spec.getattribute("chromaticities")[:2] == pytest.approx((0.713, 0.293))
    spec, _ = saved("b.exr", frame="default")
    assert spec.getattribute("hdwavefront:frame") is None and spec.get_float_attribute("PixelAspectRatio") == 1


def test_asking_for_layers_that_the_format_cannot_hold(saved):
    with pytest.raises(UsageError, match=r"need an \.exr file"):
        saved("a.png", aovs=["color", "depth"])


def test_pixel_aspect_reaches_the_delegate(opened):
    text = STAGE + 'def RenderSettings "s" {\n    uniform float pixelAspectRatio = 2\n}\n'
    assert opened(text, render_settings="/s")[1].render_pass["pixel_aspect_ratio"] == 2
    assert opened()[1].render_pass["pixel_aspect_ratio"] == 1


def test_layers_of_products_are_rendered(opened):
    text = (
        STAGE
        + """def RenderSettings "s" {
    rel products = [</p>]
}
def RenderProduct "p" {
    token productName = "p.exr"
    rel orderedVars = [</v>]
}
def RenderVar "v" {
    uniform string sourceName = "albedo"
}
"""
    )
    assert opened(text, render_settings="/s", aovs=["depth"])[1].render_pass["aovs"] == ["color", "depth", "albedo"]
