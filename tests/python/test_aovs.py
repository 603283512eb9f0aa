# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""AOVs that are named when they are asked for, from the command line to the layers of an EXR."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

SIZE = 12
QUAD = """
def RenderSettings "settings" {
    rel products = [</product>]
}
def RenderProduct "product" {
    token productName = "vars.exr"
    rel orderedVars = [</st>, </tint>]
}
def RenderVar "st" {
    uniform string sourceName = "st"
    uniform token sourceType = "primvar"
}
def RenderVar "tint" {
    uniform string sourceName = "primvars:tint"
}
def Mesh "quad" {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    uniform token subdivisionScheme = "none"
    color3f[] primvars:tint = [(0.25, 0.5, 2)] (
        interpolation = "uniform"
    )
    float2 primvars:st = (3, 4)
}
def Camera "cam" {
    double3 xformOp:translate = (0, 0, 5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


@pytest.fixture(scope="module")
def core() -> Any:
    try:
        from hdwavefront import _core
    except ImportError as error:
        pytest.fail(f"hdwavefront._core is not built: {error}", pytrace=False)
    return _core


def layers(path: Any) -> dict[str, np.ndarray]:
    source = oiio.ImageInput.open(str(path))
    pixels = source.read_image(oiio.FLOAT)
    return {name: pixels[..., i] for i, name in enumerate(source.spec().channelnames)}


def test_primvars_and_eye_normals_are_layers(core, stage_file, tmp_path, capfd):
    from hdwavefront.cli.main import main

    image = tmp_path / "o.exr"
    wanted = ["--aov", "primvars:tint", "--aov", "Neye", "--aov", "primvars:none"]
    stage = stage_file(QUAD)
    code = main(["record", stage, str(image), "-w", str(SIZE), "--samples", "2", *wanted, "-rs", "/settings"])
    assert code == 0, capfd.readouterr().err
    got = layers(image)
    for name, value in {"X": 0.25, "Y": 0.5, "Z": 2}.items():
        np.testing.assert_allclose(got[f"primvars:tint.{name}"], value, rtol=1e-6)
        assert (got[f"primvars:none.{name}"] == 0).all()
    np.testing.assert_allclose(got["Neye.Z"], 1, rtol=1e-6)
    # What the render vars ask for: a primvar by its source type, or by its prefix.
    products = layers(tmp_path / "vars.exr")
    assert set(products) == {f"primvars:{n}.{c}" for n in ("st", "tint") for c in "XYZ"}
    np.testing.assert_allclose(products["primvars:st.X"], 3, rtol=1e-6)
    np.testing.assert_allclose(products["primvars:st.Y"], 4, rtol=1e-6)
    assert (products["primvars:st.Z"] == 0).all()


@pytest.mark.parametrize("token", ["primvars", "primvars:", "Primvars:st", "neye"])
def test_tokens_that_are_no_aovs(core, stage_file, token):
    import hdwavefront

    with pytest.raises(hdwavefront.UsageError, match=f"no AOV '{token}'.*primvars:<name>"):
        hdwavefront.open(stage_file(QUAD), aovs=[token])


def test_more_primvars_than_fit_are_an_error(core, stage_file):
    import hdwavefront

    with pytest.raises(hdwavefront.HdWavefrontError, match="at most 4 primvars"):
        hdwavefront.open(stage_file(QUAD), aovs=[f"primvars:p{i}" for i in range(5)]).start()


def test_the_delegate_knows_primvars_by_name(core):
    import hdwavefront.api as api

    delegate = core.RenderDelegate(materialx_libraries=os.path.join(api._DATA_FOLDER, "materialx"))
    delegate.sync_camera("/camera", params={"clippingRange": (0.1, 100)}, transform=np.eye(4))
    wall = {"scheme": "none", "faceVertexCounts": [3], "faceVertexIndices": [0, 1, 2]}
    points = np.array([(-90, -90, -5), (90, -90, -5), (0, 90, -5)], dtype=np.float32)
    primvars = [("size", "constant", np.float32([7]), None)]
    delegate.sync_mesh("/wall", topology=wall, points=points, primvars=primvars)
    delegate.set_render_pass(camera="/camera", width=SIZE, height=SIZE, aovs=["primvars:other", "primvars:size"])
    delegate.set_setting("samples", 1)
    delegate.commit()
    delegate.start()
    assert delegate.wait(120)
    assert delegate.map("primvars:size").shape == (SIZE, SIZE, 3)
    np.testing.assert_allclose(delegate.map("primvars:size"), 7, rtol=1e-6)
    film = delegate.read_film()
    assert np.array_equal(film.resolve("primvars:size"), delegate.map("primvars:size"))
    assert (film.resolve("primvars:other") == 0).all()
    for resolve in (delegate.map, film.resolve):
        with pytest.raises(ValueError, match="primvars:third"):
            resolve("primvars:third")
