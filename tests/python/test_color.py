# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Colour: names, conversions into the rendering space, displays, and OCIO's GPU text."""

from __future__ import annotations

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
