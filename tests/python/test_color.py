# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Colour: names, conversions into the rendering space, displays, and OCIO's GPU text."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import PyOpenColorIO as ocio
import pytest
from hdwavefront.color.manager import DEFAULT_CONFIG, ColorManager, gpu_shader
from hdwavefront.errors import HdWavefrontError, UsageError

SMALL_CONFIG = """ocio_profile_version: 2
roles:
  default: mine
  scene_linear: mine
  aces_interchange: ap0
displays:
  Wall:
    - !<View> {name: Plain, colorspace: mine}
active_displays: [Wall]
active_views: [Plain]
colorspaces:
  - !<ColorSpace>
    name: mine
    encoding: scene-linear
    from_scene_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: ap0
    encoding: scene-linear
  - !<ColorSpace>
    name: numbers
    isdata: true
"""


@pytest.fixture(autouse=True)
def no_environment(monkeypatch):
    monkeypatch.delenv("OCIO", raising=False)


@pytest.fixture
def small_config(tmp_path):
    path = tmp_path / "small.ocio"
    path.write_text(SMALL_CONFIG)
    return str(path)


def test_constants_enter_the_rendering_space():
    colors = ColorManager()
    assert colors.convert_color((1, 0.5, 0.2), "") == (1, 0.5, 0.2)
    assert colors.convert_color((1, 0.5, 0.2), "raw") == (1, 0.5, 0.2)
    assert colors.convert_color((0.5, 0.5, 0.5), "sRGB") == pytest.approx((0.2140,) * 3, abs=1e-4)
    # AP1 to Rec. 709: the matrix of ACES' transform (Bradford from ACES white to D65), first column.
    assert colors.convert_color((1, 0, 0), "acescg") == pytest.approx((1.70505, -0.13026, -0.02400), abs=1e-4)
    in_acescg = ColorManager(rendering_space="acescg")
    assert in_acescg.convert_color((1, 0, 0), "") == pytest.approx((0.61310, 0.07019, 0.02062), abs=1e-4)


@pytest.mark.parametrize(
    "name", ["raw", "sRGB", "lin_rec709_scene", "srgb_rec709_scene", "lin_ap1_scene", "lin_rec2020_scene"]
)
def test_names_of_usd_are_known_with_every_configuration(name, small_config):
    assert ColorManager().knows(name) and ColorManager(small_config).knows(name)


def test_data_is_never_converted(small_config):
    colors = ColorManager(small_config)
    assert colors.is_data("numbers") and colors.is_data("Raw") and not colors.is_data("mine")
    assert colors.convert_color((1, 2, 3), "numbers") == (1, 2, 3)


def test_a_configuration_of_ones_own(small_config, monkeypatch):
    monkeypatch.setenv("OCIO", small_config)
    colors = ColorManager()
    assert (colors.config_name, colors.origin) == (small_config, "$OCIO")
    assert colors.display_and_view() == ("Wall", "Plain")
    # `mine` is twice ap0, so a white of it is 0.5 in linear Rec. 709 as well.
    assert colors.convert_color((1, 1, 1), "mine") == pytest.approx((0.5,) * 3, abs=1e-3)
    # lin_rec709 is not in it: the display is reached through scene_linear.
    out = colors.display_processor("Wall", "Plain").getDefaultCPUProcessor().applyRGB([0.5, 0.5, 0.5])
    assert out == pytest.approx([1, 1, 1], abs=1e-3)
    assert ColorManager(rendering_space="mine").convert_color((0.25,) * 3, "lin_rec709") == pytest.approx(
        (0.5,) * 3, abs=1e-3
    )


def test_wrong_names_are_said_with_the_choices():
    colors = ColorManager()
    with pytest.raises(UsageError, match=r"no display 'Wall'.*sRGB - Display"):
        colors.display_and_view("Wall")
    with pytest.raises(UsageError, match=r"no view 'Nice'.*ACES 1.0 - SDR Video"):
        colors.display_and_view("", "Nice")
    with pytest.raises(UsageError, match="'nowhere'"):
        ColorManager(rendering_space="nowhere")
    with pytest.raises(HdWavefrontError, match="named by --ocio"):
        ColorManager("missing.ocio")


def test_the_default_display_is_the_configurations():
    config = ocio.Config.CreateFromBuiltinConfig(DEFAULT_CONFIG)
    display = config.getDefaultDisplay()
    assert ColorManager().display_and_view() == (display, config.getDefaultView(display))


@pytest.mark.parametrize("name", [DEFAULT_CONFIG, "cg-config-v4.0.0_aces-v2.0_ocio-v2.5"])
def test_gpu_text_is_for_vulkan_and_names_its_luts(name):
    colors = ColorManager(name)
    shader = gpu_shader(colors.display_processor(*colors.display_and_view()))
    assert shader["function"] in shader["glsl"]
    for lut in shader["luts"]:
        assert lut["sampler"] in shader["glsl"]
        size = lut["width"] * lut["height"] * (lut["depth"] if lut["dimension"] == 3 else 1) * lut["components"]
        assert lut["values"].dtype == np.float32 and lut["values"].size == size
    assert shader["glsl"].count("uniform sampler") == len(shader["luts"])


# USD's and other programs' names for what OpenColorIO's built-in configuration calls otherwise.
NAMES = [
    ("srgb_rec709_scene", "srgb_texture"),
    ("sRGB", "srgb_texture"),
    ("linear", "lin_rec709"),
    ("lin_srgb", "lin_rec709"),
    ("lin_rec709_scene", "lin_rec709"),
    ("lin_ap1_scene", "ACEScg"),
    ("lin_p3d65_scene", "Linear P3-D65"),
    ("lin_displayp3", "Linear P3-D65"),
    ("lin_rec2020_scene", "Linear Rec.2020"),
    ("g22_rec709_scene", "Gamma 2.2 Rec.709 - Texture"),
    ("g18_rec709_scene", "Gamma 1.8 Rec.709 - Texture"),
    ("lin_adobergb_scene", "Linear AdobeRGB"),
]


@pytest.mark.parametrize(("name", "canonical"), NAMES)
def test_names_mean_what_the_configuration_has(name, canonical):
    colors = ColorManager()
    color = (0.2, 0.5, 0.8)
    assert colors.convert_color(color, name) == colors.convert_color(color, canonical)
    if "lin" not in canonical.lower() or canonical != "lin_rec709":
        assert colors.convert_color(color, name) != color


@pytest.mark.parametrize("name", ["Raw", "data", "none", "identity", "unknown", "Utility - Raw", "Non-Color"])
def test_names_of_data(name):
    colors = ColorManager()
    assert colors.is_data(name) and colors.knows(name) and colors.convert_color((1, 2, 3), name) == (1, 2, 3)


@pytest.mark.parametrize(
    ("name", "own"),
    [
        ("srgb", "srgb_texture"),
        ("srgb_rec709_scene", "srgb_texture"),
        ("linear", "lin_rec709"),
        ("lin_srgb", "lin_rec709"),
        ("lin_rec709_scene", "lin_rec709"),
        ("acescg", "lin_ap1"),
        ("lin_ap1_scene", "lin_ap1"),
        ("lin_p3d65_scene", "lin_p3d65"),
        ("lin_displayp3", "lin_p3d65"),
        ("lin_rec2020_scene", "lin_rec2020"),
        ("g22_rec709_scene", "g22_rec709"),
        ("g18_rec709_scene", "g18_rec709"),
        ("lin_adobergb_scene", "lin_adobergb"),
    ],
)
def test_the_configurations_own_spaces_come_first(tmp_path, name, own):
    """Its lin_ap1 is what acescg means there, whatever the built-in configuration says."""
    path = tmp_path / "own.ocio"
    path.write_text(
        SMALL_CONFIG.replace("name: mine", f"name: {own}").replace("scene_linear: mine", "scene_linear: ap0")
    )
    colors = ColorManager(str(path), rendering_space="ap0")
    assert colors.origin == "--ocio"
    assert colors.convert_color((1, 1, 1), name) == pytest.approx((0.5,) * 3)


def test_unknown_spaces_leave_colours_alone():
    assert ColorManager().convert_color((1, 2, 3), "nowhere") == (1, 2, 3)
    assert not ColorManager().knows("nowhere") and not ColorManager().is_data("nowhere")


def test_into_a_space_of_data_nothing_is_converted(small_config):
    assert ColorManager(small_config, rendering_space="numbers").convert_color((1, 2, 3), "acescg") == (1, 2, 3)


def test_encoding_goes_from_the_rendering_space():
    processor = ColorManager().encoding_processor("sRGB").getDefaultCPUProcessor()
    assert processor.applyRGB([0.2140, 0.2140, 0.2140]) == pytest.approx([0.5] * 3, abs=1e-3)


def test_a_space_that_is_the_rendering_space_costs_nothing():
    assert ColorManager().to_rendering("lin_rec709_scene") is None and ColorManager().to_rendering("sRGB") is not None


@pytest.mark.parametrize("space", ["lin_rec709", "ACEScg"])
def test_names_that_convert_nothing(space, small_config):
    for colors in (ColorManager(rendering_space=space), ColorManager(small_config)):
        names = colors.unconverted_names()
        assert all(colors.to_rendering(name) is None for name in names)
        assert {"raw", "data", colors.rendering_space} <= set(names) and "srgb" not in names
    names = ColorManager(rendering_space=space).unconverted_names()
    assert ("lin_rec709_scene" in names, "lin_ap1" in names) == (space == "lin_rec709", space == "ACEScg")


def test_a_configuration_without_displays():
    colors = ColorManager()
    colors._config = SimpleNamespace(getDisplays=lambda: [])
    with pytest.raises(HdWavefrontError, match="has no display"):
        colors.display_and_view()


LUT_CONFIG = """ocio_profile_version: 2
search_path: .
roles:
  default: a
  scene_linear: a
displays:
  Wall:
    - !<View> {name: Plain, colorspace: looked_up}
colorspaces:
  - !<ColorSpace>
    name: a
  - !<ColorSpace>
    name: looked_up
    from_scene_reference: !<FileTransform> {src: FILE, interpolation: FILTER}
"""


def lut_of(folder, name, text, filter_name="linear"):
    """The shader of a display that is one table, and the table as it is handed over."""
    (folder / name).write_text(text)
    (folder / "lut.ocio").write_text(LUT_CONFIG.replace("FILE", name).replace("FILTER", filter_name))
    shader = gpu_shader(ColorManager(str(folder / "lut.ocio"), "a").display_processor("Wall", "Plain"))
    (lut,) = shader["luts"]
    assert f"sampler{lut['dimension']}D {lut['sampler']}" in shader["glsl"]
    assert lut["values"].size == lut["width"] * lut["height"] * lut["depth"] * lut["components"]
    return lut


@pytest.mark.parametrize(("entries", "components"), [(16, 1), (16, 3), (9000, 1)])
def test_curves_arrive_as_the_shader_declares_them(tmp_path, entries, components):
    """Long ones are folded into two dimensions."""
    values = np.linspace(0, 1, entries) ** 2
    rows = "\n".join(" ".join(f"{v * (1 + i / 9):.6f}" for i in range(components)) for v in values)
    text = f"Version 1\nFrom 0.0 1.0\nLength {entries}\nComponents {components}\n{{\n{rows}\n}}\n"
    lut = lut_of(tmp_path, "curve.spi1d", text)
    assert lut["components"] == components and lut["linear"] is True and (lut["height"] > 1) is (entries > 4096)


@pytest.mark.parametrize(("filter_name", "linear"), [("linear", True), ("tetrahedral", False)])
def test_cubes_arrive_as_the_shader_declares_them(tmp_path, filter_name, linear):
    rng = np.random.default_rng(5)
    rows = "\n".join(" ".join(f"{v:.6f}" for v in rng.random(3)) for _ in range(27))
    lut = lut_of(tmp_path, "cube.cube", f"LUT_3D_SIZE 3\n{rows}\n", filter_name)
    assert (lut["dimension"], lut["width"], lut["height"], lut["depth"]) == (3, 3, 3, 3)
    assert lut["components"] == 3 and lut["linear"] is linear
