# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Images that are written, frames in their names, and progress."""

from __future__ import annotations

import io

import numpy as np
import OpenImageIO as oiio
import pytest
from hdwavefront.cli import frames
from hdwavefront.cli.progress import ProgressDisplay, describe
from hdwavefront.errors import HdWavefrontError, UsageError
from hdwavefront.image_io import writer


def read(path, kind=oiio.FLOAT):
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    return source.spec(), source.read_image(kind)


def test_exr_holds_layers_exactly(tmp_path):
    rng = np.random.default_rng(1)
    color = rng.random((6, 8, 4), dtype=np.float32) * 1e5
    ids = rng.integers(-1, 1 << 24, (6, 8, 1), dtype=np.int32)
    matrix = rng.random((4, 4))
    path = tmp_path / "a.exr"
    writer.write_linear(
        str(path),
        {"color": color, "normal": color[..., :3], "primId": ids},
        {"worldToCamera": matrix, "hdwavefront:samples": 3},
        "lin_rec709",
    )
    spec, pixels = read(path)
    at = {name: i for i, name in enumerate(spec.channelnames)}
    assert all(str(f) in ("float", "") for f in spec.channelformats) and str(spec.format) == "float"
    np.testing.assert_array_equal(pixels[..., [at[c] for c in "RGBA"]], color)
    np.testing.assert_array_equal(pixels[..., [at[f"normal.{c}"] for c in "XYZ"]], color[..., :3])
    np.testing.assert_array_equal(pixels[..., at["primId.id"]].astype(np.int32), ids[..., 0])
    assert np.allclose(np.reshape(spec.getattribute("worldToCamera"), (4, 4)), matrix)
    assert "rec709" in spec.getattribute("oiio:ColorSpace") and spec.getattribute("chromaticities")[0] == pytest.approx(
        0.64
    )


@pytest.mark.parametrize("kind", [".png", ".tif", ".tga"])
def test_display_images_keep_straight_alpha(tmp_path, kind):
    pixels = np.random.default_rng(2).random((4, 5, 4), dtype=np.float32)
    path = tmp_path / ("a" + kind)
    writer.write_display(str(path), pixels, {})
    _, got = read(path)
    np.testing.assert_allclose(got, pixels, atol=0.51 / 255)


def test_jpeg_has_no_alpha_and_odd_values_are_clipped(tmp_path):
    pixels = np.full((8, 8, 4), 0.5, dtype=np.float32)
    pixels[:, :4, 0], pixels[:, 4:, 0] = 7, -3
    pixels[0, 0, 1] = np.nan
    writer.write_display(str(tmp_path / "a.jpg"), pixels, {})
    writer.write_display(str(tmp_path / "a.png"), pixels, {})
    assert read(tmp_path / "a.jpg")[0].nchannels == 3
    _, got = read(tmp_path / "a.png")
    assert got[5, 0, 0] == 1 and got[5, 7, 0] == 0 and got[0, 0, 1] == 0


def test_sixteen_bit_tiff(tmp_path):
    writer.write_display(str(tmp_path / "a.tif"), np.full((2, 2, 4), 1 / 3, dtype=np.float32), {})
    spec, got = read(tmp_path / "a.tif", oiio.UINT16)
    assert str(spec.format) == "uint16" and got[0, 0, 0] == round(65535 / 3)


def test_nothing_is_left_when_writing_fails(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"the old picture")
    monkeypatch.setattr(writer.os, "replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(HdWavefrontError, match="No space left"):
        writer.write_display(str(path), np.zeros((2, 2, 4), dtype=np.float32), {})
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"] and path.read_bytes() == b"the old picture"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("123", [123]),
        ("101:103", [101, 102, 103]),
        ("103:101", [103, 102, 101]),
        ("101:106x2", [101, 103, 105]),
        ("5:1x-2", [5, 3, 1]),
        ("1:2x0.25", [1, 1.25, 1.5, 1.75, 2]),
        ("0:0.3x0.1", [0, 0.1, 0.2, 0.3]),
        ("1,-2:-1", [1, -2, -1]),
    ],
)
def test_frame_specs(text, expected):
    assert frames.parse_frames(text) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("text", ["", "a", "1:2:3", "1x2", "1:2x", "1:2x0", "2:1x1", "nan", "1,,2", "inf:2"])
def test_wrong_frame_specs(text):
    with pytest.raises(UsageError):
        frames.parse_frames(text)


def test_frame_specs_agree_with_openusd():
    from pxr import UsdUtils

    for text in ("1:10x3", "10:1", "1:2x0.25", "-3:3x1.5"):
        theirs = [code.GetValue() for code in UsdUtils.TimeCodeRange.CreateFromFrameSpec(text)]
        assert frames.parse_frames(text) == pytest.approx(theirs)


@pytest.mark.parametrize(
    ("path", "frame", "expected"),
    [
        ("a.####.png", 7, "a.0007.png"),
        ("a.##.##.png", 1.5, "a.01.50.png"),
        ("a.#.png", 1234, "a.1234.png"),
        ("a.png", 3, "a.png"),
    ],
)
def test_frame_numbers_in_paths(path, frame, expected):
    assert frames.frame_path(path, frame) == expected


def test_progress_tells_samples_rate_and_time_left():
    state = {"pathsDone": 2_500_000, "pathsTotal": 10_000_000, "samplesDone": 16, "seconds": 10.0}
    fraction, words = describe(state, 64)
    assert fraction == 0.25 and words == "16/64 samples, 0.25 Mpaths/s, 30 s left"
    done = {"pathsDone": 5, "pathsTotal": 5, "samplesDone": 64, "seconds": 1.0}
    assert "left" not in describe(done, 64)[1]
    assert describe({"pathsDone": 0, "pathsTotal": 0, "samplesDone": 0, "seconds": 0}, 64)[0] == 0


def test_progress_is_a_bar_on_a_terminal_and_lines_elsewhere():
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    state = {"pathsDone": 1, "pathsTotal": 2, "samplesDone": 1, "seconds": 1.0}
    terminal, file = Terminal(), io.StringIO()
    ProgressDisplay(2, terminal).update(state)
    assert terminal.getvalue().startswith("\r") and "#" in terminal.getvalue() and "50%" in terminal.getvalue()
    display = ProgressDisplay(2, file)
    display.update(state)
    assert file.getvalue() == ""  # not before some seconds
    display._last_line -= 60
    display.update(state)
    assert file.getvalue() == "50% 1/2 samples, 0.00 Mpaths/s, 1 s left\n"


def test_hdr_holds_linear_colour(tmp_path):
    color = np.full((4, 5, 4), 7.5, dtype=np.float32)
    writer.write_linear(str(tmp_path / "a.hdr"), {"color": color}, {}, "lin_rec709")
    spec, pixels = read(tmp_path / "a.hdr")
    assert spec.nchannels == 3 and pixels[0, 0].tolist() == [7.5] * 3


@pytest.mark.parametrize(
    ("name", "linear", "alpha"),
    [
        ("a.exr", True, True),
        ("a.EXR", True, True),
        ("a.hdr", True, False),
        ("a.png", False, True),
        ("a.jpg", False, False),
        ("a.jpeg", False, False),
        ("a.tif", False, True),
        ("a.tiff", False, True),
        ("a.bmp", False, False),
        ("a.tga", False, True),
    ],
)
def test_what_formats_hold(tmp_path, name, linear, alpha):
    assert writer.is_scene_linear(name) is linear and writer.holds_alpha(name) is alpha
    pixels = np.full((8, 8, 4), 0.5, dtype=np.float32)
    (writer.write_linear if linear else lambda p, c, m, s: writer.write_display(p, c["color"], m))(
        str(tmp_path / name), {"color": pixels}, {}, "lin_rec709"
    )
    spec, got = read(tmp_path / name)
    assert spec.nchannels == (4 if alpha else 3) and spec.alpha_channel == (3 if alpha else -1)
    np.testing.assert_allclose(got, 0.5, atol=2 / 255)
    bits = {"tif": "uint16", "tiff": "uint16", "exr": "float", "hdr": "float"}.get(name[2:].lower(), "uint8")
    assert str(spec.format) == bits
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_every_aov_has_its_channels(tmp_path):
    tokens = {"color": 4, "albedo": 3, "normal": 3, "depth": 1, "cameraDepth": 1, "primId": 1}
    tokens |= {"instanceId": 1, "elementId": 1, "sampleCount": 1}
    layers = {t: np.full((2, 2, n), i, dtype=np.float32) for i, (t, n) in enumerate(tokens.items())}
    writer.write_linear(str(tmp_path / "a.exr"), layers, {}, "")
    spec, pixels = read(tmp_path / "a.exr")
    at = {name: pixels[0, 0, i] for i, name in enumerate(spec.channelnames)}
    expected = {**dict.fromkeys("RGBA", 0), **{f"albedo.{c}": 1 for c in "RGB"}, **{f"normal.{c}": 2 for c in "XYZ"}}
    expected |= {"depth.Z": 3, "cameraDepth.Z": 4, "primId.id": 5, "instanceId.id": 6, "elementId.id": 7}
    assert at == {**expected, "sampleCount.samples": 8}


@pytest.mark.parametrize(
    ("space", "red", "white"),
    [
        ("lin_rec709", (0.64, 0.33), (0.3127, 0.3290)),
        ("lin_ap1", (0.713, 0.293), (0.32168, 0.33767)),
        ("ACEScg", (0.713, 0.293), (0.32168, 0.33767)),
        ("lin_rec2020", (0.708, 0.292), (0.3127, 0.3290)),
        ("lin_p3d65", (0.680, 0.320), (0.3127, 0.3290)),
    ],
)
def test_chromaticities_of_rendering_spaces(tmp_path, space, red, white):
    path = str(tmp_path / "a.exr")
    writer.write_linear(path, {"color": np.zeros((2, 2, 4), dtype=np.float32)}, {}, space)
    numbers = read(path)[0].getattribute("chromaticities")
    assert numbers[:2] == pytest.approx(red) and numbers[6:] == pytest.approx(white)


def test_infinities_are_the_ends_of_the_range(tmp_path):
    pixels = np.array([[[np.inf, -np.inf, np.nan, 1]]], dtype=np.float32)
    writer.write_display(str(tmp_path / "a.png"), pixels, {})
    assert read(tmp_path / "a.png")[1][0, 0].tolist() == [1, 0, 0, 1]


def test_jpegs_are_of_good_quality(tmp_path):
    grey = np.random.default_rng(3).random((64, 64, 1), dtype=np.float32).repeat(4, axis=2)
    writer.write_display(str(tmp_path / "a.jpg"), grey, {})
    difference = read(tmp_path / "a.jpg")[1] - grey[..., :3]
    assert np.sqrt((difference**2).mean()) < 0.02  # noise is the worst case; at quality 5 it is .2


def test_a_writer_that_fails_is_an_error(tmp_path, monkeypatch):
    class Broken:
        def open(self, *_):
            return False

        def geterror(self):
            return "no such luck"

        def close(self):
            return True

    monkeypatch.setattr(oiio.ImageOutput, "create", lambda *_: Broken())
    with pytest.raises(HdWavefrontError, match=r"a\.png cannot be written: no such luck"):
        writer.write_display(str(tmp_path / "a.png"), np.zeros((2, 2, 4), dtype=np.float32), {})


def test_an_output_that_exists_and_is_locked(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"")
    monkeypatch.setattr(writer.os, "access", lambda p, mode: p != str(path))
    with pytest.raises(HdWavefrontError, match="exists and cannot be overwritten"):
        writer.check_output(str(path))
    monkeypatch.setattr(writer.os, "access", lambda p, mode: False)
    with pytest.raises(HdWavefrontError, match="cannot be written to"):
        writer.check_output(str(tmp_path / "b.png"))


@pytest.mark.parametrize(
    ("seconds", "words"), [(0, "0 s"), (59.4, "59 s"), (61, "1 min 01 s"), (3599, "59 min 59 s"), (3720, "1 h 02 min")]
)
def test_time_left_in_words(seconds, words):
    half = {"pathsDone": 1, "pathsTotal": 2, "samplesDone": 1, "seconds": seconds}
    assert describe(half, 2)[1].endswith(f", {words} left") is (seconds > 0)


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(("done", "marks"), [(0, 0), (1, 7), (4, 30)])
def test_the_bar_grows(done, marks):
    terminal = Terminal()
    ProgressDisplay(4, terminal).update({"pathsDone": done, "pathsTotal": 4, "samplesDone": done, "seconds": 1.0})
    assert (terminal.getvalue().count("#"), terminal.getvalue().count(".", 0, 40)) == (marks, 30 - marks)


def test_the_bar_makes_room_for_other_lines():
    terminal, file = Terminal(), io.StringIO()
    state = {"pathsDone": 1, "pathsTotal": 4, "samplesDone": 1, "seconds": 1.0}
    for stream in (terminal, file):
        display = ProgressDisplay(4, stream)
        display.clear()
        assert stream.getvalue() == ""  # there is nothing to clear yet
        display.update(state)
        display.clear()
        display.clear()
    assert terminal.getvalue().endswith("left\r\x1b[K") and file.getvalue() == ""


def test_lines_come_once_in_a_while():
    file = io.StringIO()
    display = ProgressDisplay(2, file)
    display._last_line -= 60
    for _ in range(3):
        display.update({"pathsDone": 1, "pathsTotal": 2, "samplesDone": 1, "seconds": 1.0})
    assert file.getvalue().count("\n") == 1
