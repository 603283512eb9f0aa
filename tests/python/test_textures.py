# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Textures: formats, channels, colour spaces, strips, and files that are broken."""

from __future__ import annotations

import collections
import os
import zipfile
from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio
import pytest
from hdwavefront.color.manager import ColorManager
from hdwavefront.errors import Diagnostics
from hdwavefront.image_io import textures
from hdwavefront.image_io.texture_loading import load_pending
from hdwavefront.image_io.textures import Conversion, TextureError, load_texture, tile_files


@pytest.fixture(scope="module")
def colors():
    return ColorManager()


@pytest.fixture
def load(colors):
    def call(path, space="auto", is_color=True, manager=None):
        call.diagnostics = Diagnostics()
        conversions = [Conversion(space, is_color)]
        return load_texture(str(path), conversions, manager or colors, call.diagnostics)[0]

    return call


@pytest.fixture
def pending(colors):
    """Answers requests (path, space) or (path, space, is_color); gives the answers by number."""

    def call(*asked):
        requests = [
            SimpleNamespace(
                key=k, resolved_path=str(path), color_space=space, is_color=(*rest, True)[0], location=f"/m/{k}"
            )
            for k, (path, space, *rest) in enumerate(asked)
        ]
        answers, decoded = {}, []
        delegate = SimpleNamespace(
            pending_textures=lambda: requests,
            count_decoded_image=lambda: decoded.append(1),
            set_texture=answers.__setitem__,
            set_texture_tiles=lambda key, numbers, pixels: answers.__setitem__(
                key, dict(zip(numbers, pixels, strict=True))
            ),
            set_texture_missing=answers.__setitem__,
        )
        call.diagnostics = Diagnostics()
        load_pending(delegate, colors, call.diagnostics)
        call.decoded = len(decoded)
        return answers

    return call


@pytest.fixture
def opened(monkeypatch):
    """How often OpenImageIO has opened each file."""
    count = collections.Counter()
    open_ = oiio.ImageInput.open

    def spy(path, *rest):
        count[os.path.basename(path)] += 1
        return open_(path, *rest)

    monkeypatch.setattr(oiio, "ImageInput", SimpleNamespace(open=spy))
    return count


def write(path, pixels, names=None, tile=0, **attributes):
    kinds = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kinds[str(pixels.dtype)])
    if names:
        spec.channelnames = names
    if tile:
        spec.tile_width = spec.tile_height = tile
    for key, value in attributes.items():
        spec.attribute(key, value)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(pixels)
    output.close()
    return path


def gradient(channels, dtype=np.uint8, size=(5, 7)):
    top = 255 if dtype == np.uint8 else 65535 if dtype == np.uint16 else 2.0
    values = np.linspace(0, top, size[0] * size[1] * channels).reshape(*size, channels)
    return values.astype(dtype)


def linear(byte):
    value = np.asarray(byte, dtype=np.float64) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def test_raw_bytes_stay_bytes_with_row_0_at_the_top(load, tmp_path):
    pixels = gradient(4)
    got = load(write(tmp_path / "a.png", pixels), "raw")
    assert got.dtype == np.uint8 and (got == pixels).all()  # the alpha is not multiplied in


def test_srgb_bytes_become_linear_halves(load, tmp_path):
    pixels = gradient(4)
    for space in ("sRGB", "auto", ""):
        got = load(write(tmp_path / "a.png", pixels), space)
        assert got.dtype == np.float16
        np.testing.assert_allclose(got[..., :3], linear(pixels[..., :3]), atol=6e-4)
        np.testing.assert_allclose(got[..., 3], pixels[..., 3] / 255, atol=5e-4)


@pytest.mark.parametrize(("space", "power"), [("sRGB", 0), ("g22_rec709", 2.2), ("g18_rec709", 1.8)])
def test_every_byte_becomes_the_half_that_the_hydra_plugin_makes_of_it(load, tmp_path, space, power):
    """To the bit: the same formula stands in tests/hydra/texture_loader_test.cpp."""
    ramp = np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(1, 256, 3)
    value = (np.arange(256, dtype=np.float32) / np.float32(255)).astype(np.float64)
    end = 0.055 / 1.4
    slope = ((end + 0.055) / 1.055) ** 2.4 / end
    srgb = np.where(value <= end, value * slope, ((value + 0.055) / 1.055) ** 2.4)
    expected = (value**power if power else srgb).astype(np.float32).astype(np.float16)
    got = load(write(tmp_path / "ramp.png", ramp), space)
    assert (got[0, :, :3].view(np.uint16) == expected.view(np.uint16)[:, None]).all()


@pytest.mark.parametrize("channels", [1, 2])
def test_grey_fills_the_colours_and_a_second_channel_is_alpha(load, tmp_path, channels):
    pixels = gradient(channels)
    got = load(write(tmp_path / "a.png", pixels), "auto")  # auto: fewer than three channels are no colours
    assert got.dtype == np.uint8
    for channel in range(3):
        assert (got[..., channel] == pixels[..., 0]).all()
    assert (got[..., 3] == (pixels[..., 1] if channels == 2 else 255)).all()
    stated = load(write(tmp_path / "a.png", pixels), "sRGB")
    np.testing.assert_allclose(stated[..., 0], linear(pixels[..., 0]), atol=6e-4)


def test_sixteen_bits_and_floats_are_raw_unless_stated(load, tmp_path):
    for name, dtype, one in (
        ("a.png", np.uint16, 65535),
        ("a.exr", np.float32, 1),
        ("b.exr", np.float16, 1),
        ("c.tif", np.float32, 1),
    ):
        pixels = gradient(3, dtype)
        got = load(write(tmp_path / name, pixels))
        assert got.dtype == dtype and (got[..., :3] == pixels).all() and (got[..., 3] == one).all()


def test_sixteen_bits_of_a_stated_space_become_halves(load, tmp_path):
    deep = gradient(4, np.uint16)
    got = load(write(tmp_path / "a.png", deep), "sRGB")
    assert got.dtype == np.float16
    np.testing.assert_allclose(got[..., :3], linear(deep[..., :3] / 257), atol=6e-4)


@pytest.mark.parametrize("strip", [100, 1 << 20])
def test_floats_that_are_all_halves_take_a_half_of_the_memory(load, tmp_path, monkeypatch, strip):
    monkeypatch.setattr(textures, "_STRIP_BYTES", strip)
    pixels = gradient(4, np.float16, (40, 3)).astype(np.float32)
    assert load(write(tmp_path / "a.exr", pixels)).dtype == np.float16
    pixels[39, 2, 1] = 1 + 2.0**-20  # one that is none, in the last row: what came before is not lost
    got = load(write(tmp_path / "b.exr", pixels))
    assert got.dtype == np.float32 and (got == pixels).all()


def test_named_spaces_enter_the_rendering_space(load, tmp_path, colors):
    pixels = np.full((2, 2, 3), 0.5, dtype=np.float32)
    pixels[..., 1:] = 0
    got = load(write(tmp_path / "a.exr", pixels), "acescg")
    assert got[0, 0, :3] == pytest.approx(np.array(colors.convert_color((0.5, 0, 0), "acescg")), abs=1e-3)
    # Bytes, where the rendering space mixes the channels.
    bytes_ = np.zeros((2, 2, 3), dtype=np.uint8)
    bytes_[..., 0] = 255
    wide = ColorManager(rendering_space="acescg")
    got = load(write(tmp_path / "b.png", bytes_), "sRGB", manager=wide)
    assert got[0, 0, :3] == pytest.approx(np.array(wide.convert_color((1, 0, 0), "sRGB")), abs=1e-3)
    load(write(tmp_path / "c.png", bytes_), "no such space")
    assert load.diagnostics.codes() == {"texture-color-space"}


def test_data_is_not_managed(load, tmp_path):
    pixels = gradient(3)
    assert (load(write(tmp_path / "a.png", pixels), "sRGB", is_color=False)[..., :3] == pixels).all()


def test_colour_channels_are_found_by_name(load, tmp_path):
    pixels = gradient(5, np.float32)
    path = write(tmp_path / "a.exr", pixels, names=("depth.Z", "G", "B", "R", "other"))
    file = oiio.ImageInput.open(str(path))
    order = [file.spec().channelnames.index(n) for n in "RGB"]
    everything = file.read_image(oiio.FLOAT)
    np.testing.assert_allclose(load(path)[..., :3], everything[..., order], rtol=1e-3)


@pytest.mark.parametrize("tile", [0, 16])
@pytest.mark.parametrize("kind", [np.float32, np.float16, np.uint8])
def test_strips_join_without_a_seam(load, tmp_path, monkeypatch, tile, kind):
    monkeypatch.setattr(textures, "_STRIP_BYTES", 4096)
    pixels = gradient(3, kind, (100, 50))
    name = "a.tif" if kind == np.uint8 else "a.exr"
    got = load(write(tmp_path / name, pixels, tile=tile), "raw")
    np.testing.assert_allclose(got[..., :3], pixels, rtol=1e-3)


def test_values_that_no_texel_holds_are_clipped_and_said(load, tmp_path):
    pixels = np.array([[[1e6, np.inf, np.nan]]], dtype=np.float32)
    got = load(write(tmp_path / "a.exr", pixels))
    most = np.finfo(np.float32).max
    assert got[0, 0, :3].tolist() == [1e6, most, 0] and load.diagnostics.codes() == {"texture-clipped"}
    sun = np.array([[[1e6, 7, 0]]], dtype=np.float32)  # no half holds it, a float does
    assert (load(write(tmp_path / "c.exr", sun))[..., :3] == sun).all() and not load.diagnostics.codes()
    got = load(write(tmp_path / "b.exr", pixels[..., 1:].astype(np.float16).repeat(2, axis=2)))
    assert np.isfinite(got).all() and load.diagnostics.codes() == {"texture-clipped"}


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("gone.png", None, "does not exist"),
        ("empty.png", b"", "cannot be read"),
        ("text.exr", b"this is no image", "cannot be read"),
    ],
)
def test_broken_files_say_why(load, tmp_path, name, content, reason):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(TextureError, match=reason):
        load(tmp_path / name)


def test_tiles_are_found_by_their_numbers(tmp_path):
    for name in ("t.1001.png", "t.1012.png", "t.101.png", "t.0999.png", "x1003.png", "s_u1_v1.png", "s_u2_v2.png"):
        (tmp_path / name).touch()
    assert tile_files(str(tmp_path / "t.<UDIM>.png")) == {
        1001: str(tmp_path / "t.1001.png"),
        1012: str(tmp_path / "t.1012.png"),
    }
    assert list(tile_files(str(tmp_path / "s_<UVTILE>.png"))) == [1001, 1012]
    assert tile_files(str(tmp_path / "gone/t.<UDIM>.png")) == {}


@pytest.mark.parametrize(
    ("name", "dtype"), [("a.png", np.uint8), ("b.png", np.uint16), ("c.exr", np.float16), ("d.exr", np.float32)]
)
def test_a_file_is_decoded_once_for_all_conversions(pending, opened, load, tmp_path, name, dtype):
    """And each is to the bit what the file gives by itself."""
    file = write(tmp_path / name, gradient(4, dtype, (40, 30)))
    asked = [("", True), ("sRGB", True), ("SRGB", True), ("acescg", True), ("lin_rec709", True), ("raw", False)]
    answers = pending(*((file, *conversion) for conversion in asked))
    assert opened == {name: 1} and pending.decoded == 1
    for got, conversion in zip(answers.values(), asked, strict=True):
        alone = load(file, *conversion)
        assert got.dtype == alone.dtype and (got.view(np.uint8) == alone.view(np.uint8)).all(), conversion
    assert answers[1] is answers[2]
    assert not (answers[1] == answers[5]).all()


def test_tiles_plain_paths_and_links_share_a_decode(pending, opened, tmp_path):
    for tile in (1001, 1002):
        write(tmp_path / f"t.{tile}.png", gradient(3, size=(4, tile - 999)))
    os.symlink(tmp_path / "t.1002.png", tmp_path / "linked.png")
    pattern = tmp_path / "t.<UDIM>.png"
    answers = pending(
        (pattern, "sRGB"), (pattern, "raw"), (tmp_path / "t.1001.png", "sRGB"), (tmp_path / "linked.png", "raw")
    )
    assert sum(opened.values()) == pending.decoded == 2
    assert [list(answers[k]) for k in (0, 1)] == [[1001, 1002]] * 2
    assert answers[0][1001] is answers[2] and answers[1][1002] is answers[3]
    assert answers[0][1002].dtype == np.float16 and answers[3].shape == (4, 3, 4)
    # Nothing is kept: another colour space that is asked for later decodes again.
    pending((tmp_path / "t.1001.png", "acescg"))
    assert opened["t.1001.png"] == 2


def test_a_broken_file_answers_all_that_ask_for_it(pending, opened, tmp_path):
    (tmp_path / "t.1001.png").write_bytes(b"this is no image")
    answers = pending(*((tmp_path / name, "raw") for name in ("t.1001.png", "t.<UDIM>.png", "u.<UDIM>.png")))
    assert opened == {"t.1001.png": 1}
    assert "cannot be read" in answers[0] and "no tile can be used (1001: the file" in answers[1]
    assert answers[2] == "no tile of the pattern exists."


def test_missing_tiles_are_said_once(pending, tmp_path):
    for tile in (1001, 1003):
        write(tmp_path / f"t.{tile}.exr", gradient(3, np.float32, (4, 4)))
    (tmp_path / "t.1004.exr").write_bytes(b"this is no image")
    tiles = pending((tmp_path / "t.<UDIM>.exr", "raw"))[0]
    assert list(tiles) == [1001, 1003] and tiles[1001].shape == (4, 4, 4)
    assert [(d.code, d.location) for d in pending.diagnostics] == [("texture-tiles-missing", "/m/0")]
    text = next(iter(pending.diagnostics)).message
    assert "1004: the file" in text and "there is no file for 1002." in text


def test_a_cut_off_file_says_so(load, tmp_path):
    path = write(tmp_path / "a.exr", gradient(3, np.float32, (200, 200)))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(TextureError):
        load(path)


def test_files_inside_packages(load, tmp_path):
    image = write(tmp_path / "a.png", gradient(3))
    (tmp_path / "s.usda").write_text("#usda 1.0\n")
    package = tmp_path / "p.usdz"
    from pxr import UsdUtils

    with zipfile.ZipFile(package, "w"):
        pass
    (tmp_path / "s.usda").write_text('#usda 1.0\ndef Shader "x" {\n    asset inputs:file = @./a.png@\n}\n')
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "s.usda"), str(package))
    inside = next(n for n in zipfile.ZipFile(package).namelist() if n.endswith(".png"))
    assert (load(f"{package}[{inside}]", "raw") == load(image, "raw")).all()


def test_tiles_inside_packages(tmp_path, pending):
    images = {tile: write(tmp_path / f"t.{tile}.png", gradient(3) // k) for k, tile in ((1, 1001), (2, 1012))}
    write(tmp_path / "t.1002.png", gradient(3))
    package = tmp_path / "p.usdz"
    with zipfile.ZipFile(package, "w") as archive:  # as usdz wants it: nothing compressed
        archive.writestr("s.usda", "#usda 1.0\n")
        for tile, image in images.items():
            archive.write(image, f"maps/t.{tile}.png")
        archive.write(tmp_path / "t.1002.png", "t.1002.png")  # in another folder
    pattern = f"{package}[maps/t.<UDIM>.png]"
    assert tile_files(pattern) == {tile: f"{package}[maps/t.{tile}.png]" for tile in images}
    tiles = pending((pattern, "raw"))[0]
    assert (tiles[1012][..., :3] == gradient(3) // 2).all()
    assert tile_files(f"{package}[none/t.<UDIM>.png]") == tile_files(f"{tmp_path}/gone.usdz[t.<UDIM>.png]") == {}


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["A", "B", "G", "R"], [3, 2, 1, 0]),
        (["Z", "B", "G", "R"], [3, 2, 1]),
        (["A", "Y"], [1, 0]),
        (["Y"], [0]),
        (["a", "b", "c", "d", "e"], [0, 1, 2, 3]),
        (["r", "x"], [0, 1]),
    ],
)
def test_channels_are_chosen_by_name(names, expected):
    assert textures._choose_channels(names) == expected


@pytest.mark.parametrize(
    ("stated", "kind", "channels", "asked", "is_color", "expected"),
    [
        ("", "uint8", 3, "auto", True, "sRGB"),
        ("", "uint8", 4, "", True, "sRGB"),
        ("", "uint8", 3, "Auto", True, "sRGB"),
        ("", "uint8", 2, "auto", True, "raw"),
        ("", "uint16", 3, "auto", True, "raw"),
        ("lin_rec709", "uint8", 3, "auto", True, "raw"),  # the file says that its bytes are linear
        ("scene_linear", "uint8", 3, "auto", True, "raw"),
        ("srgb_rec709_scene", "uint8", 3, "auto", True, "sRGB"),
        ("lin_rec709", "uint8", 3, "sRGB", True, "sRGB"),
        ("", "uint16", 1, "acescg", True, "acescg"),
        ("", "uint8", 3, "sRGB", False, "raw"),
    ],
)
def test_the_space_of_an_image(stated, kind, channels, asked, is_color, expected):
    spec = oiio.ImageSpec(1, 1, channels, kind)
    if stated:
        spec.attribute("oiio:ColorSpace", stated)
    assert textures._resolve_space(spec, asked, is_color, channels, oiio) == expected


def test_grey_with_alpha_keeps_its_alpha_through_srgb(load, tmp_path):
    pixels = gradient(2)
    got = load(write(tmp_path / "a.png", pixels), "sRGB")
    np.testing.assert_allclose(got[..., 3], pixels[..., 1] / 255, atol=5e-4)
    np.testing.assert_allclose(got[..., 1], linear(pixels[..., 0]), atol=6e-4)


@pytest.mark.parametrize("tile", [0, 16])
def test_a_data_window_aside_of_the_origin(load, tmp_path, tile):
    pixels = gradient(3, np.float32, (40, 30))
    spec = oiio.ImageSpec(30, 40, 3, "float")
    spec.x, spec.y = 3, 5
    spec.full_width, spec.full_height = 33, 45
    if tile:
        spec.tile_width = spec.tile_height = tile
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), spec), output.geterror()
    assert output.write_image(pixels)
    output.close()
    np.testing.assert_allclose(load(tmp_path / "a.exr")[..., :3], pixels, rtol=1e-3)


def test_images_that_are_too_large(load, tmp_path, monkeypatch):
    path = write(tmp_path / "a.png", gradient(3))  # 7 x 5
    monkeypatch.setattr(textures, "_MAX_SIDE", 6)
    with pytest.raises(TextureError, match="its size 7 x 5 is not within"):
        load(path)
    monkeypatch.setattr(textures, "_MAX_SIDE", 7)
    assert load(path).shape == (5, 7, 4)


def test_packages_hold_formats_that_only_their_extension_tells(load, tmp_path, monkeypatch):
    image = write(tmp_path / "a.tga", gradient(3))
    monkeypatch.setattr(textures, "_package_bytes", lambda path: image.read_bytes())
    assert (load("scene.usdz[a.tga]", "raw") == load(image, "raw")).all()
