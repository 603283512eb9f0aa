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
