# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Files: display-referred ones equal OpenColorIO's CPU processor over the same pixels, scene-linear ones the pixels."""

from __future__ import annotations

import json

import numpy as np
import OpenImageIO as oiio
import pytest
from harness import FOLDER

CASE = FOLDER / "Color.Display"


@pytest.fixture(scope="module")
def finished():
    import hdwavefront

    options = json.loads((CASE / "case.json").read_text(encoding="utf-8"))["render"]
    render = hdwavefront.open(
        str(CASE / "scene.usda"),
        width=options["width"],
        camera_light=False,
        aovs=["cameraDepth", "primId"],
        settings={"samples": options["samples"], "maxBounces": options["maxBounces"]},
    )
    render.start()
    assert render.wait(120)
    assert render.stats()["validationMessages"] == 0
    return render


def cpu_display(render, rgba: np.ndarray) -> np.ndarray:
    """What OpenColorIO's CPU processor makes of straight colour."""
    expected = np.ascontiguousarray(rgba, dtype=np.float32).copy()
    alpha = expected[..., 3:4].copy()
    np.divide(expected[..., :3], alpha, out=expected[..., :3], where=alpha > 0)
    processor = render.colors.display_processor(*render.colors.display_and_view()).getDefaultCPUProcessor()
    processor.applyRGBA(expected)
    return expected[..., :3]


def test_encoded_pixels_equal_the_cpu_processor(finished):
    rgba = finished.map("color")
    assert rgba[..., :3].max() > 2 and rgba[..., 3].min() == 0  # highlights and background are in it
    encoded = finished._encode(rgba, keep_alpha=True)
    seen = rgba[..., 3] > 0
    np.testing.assert_allclose(encoded[seen][:, :3], cpu_display(finished, rgba)[seen], atol=1e-3)


def test_png_equals_ocio(finished, tmp_path):
    path = str(tmp_path / "picture.png")
    finished.save(path)
    source = oiio.ImageInput.open(path)
    assert source.spec().channelnames == ("R", "G", "B", "A") or list(source.spec().channelnames) == list("RGBA")
    source.close()
    hint = oiio.ImageSpec()
    hint.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(path, hint)
    stored = source.read_image(oiio.FLOAT)
    rgba = finished.map("color")
    solid = rgba[..., 3] == 1
    assert solid.sum() > 100
    expected = np.clip(cpu_display(finished, rgba), 0, 1)
    # Half a code of rounding beside the 1e-3 of the transform.
    np.testing.assert_allclose(stored[solid][:, :3], expected[solid], atol=1e-3 + 0.51 / 255)
    np.testing.assert_allclose(stored[..., 3], rgba[..., 3], atol=0.51 / 255)


def test_exr_holds_the_scene_linear_pixels(finished, tmp_path):
    path = str(tmp_path / "picture.exr")
    finished.save(path)
    source = oiio.ImageInput.open(path)
    spec = source.spec()
    names = list(spec.channelnames)
    assert names[:4] == ["R", "G", "B", "A"]
    pixels = source.read_image(oiio.FLOAT)
    np.testing.assert_array_equal(pixels[..., :4], finished.map("color"))
    for aov in ("cameraDepth", "primId"):
        channel = next(i for i, name in enumerate(names) if name.startswith(aov))
        np.testing.assert_array_equal(pixels[..., channel], finished.map(aov)[..., 0])
    assert any("worldToCamera" in p.name for p in spec.extra_attribs)
