# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The native module's arguments: what it takes as arrays, what it refuses, and that it renders what it is told."""

from __future__ import annotations

import os
import threading
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Vt

SIZE = 32


@pytest.fixture(scope="module")
def core() -> Any:
    try:
        from hdwavefront import _core
    except ImportError as error:
        pytest.fail(f"hdwavefront._core is not built: {error}", pytrace=False)
    return _core


@pytest.fixture
def delegate(core: Any) -> Any:
    import hdwavefront.api as api

    delegate = core.RenderDelegate(materialx_libraries=os.path.join(api._DATA_FOLDER, "materialx"))
    delegate.sync_camera(
        "/camera",
        params={"horizontalAperture": 20.0, "verticalAperture": 20.0, "focalLength": 50.0, "clippingRange": (0.1, 100)},
        transform=Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(0, 0, 10)),
    )
    delegate.sync_light("/dome", params={"type": "DomeLight"})
    delegate.set_render_pass(camera="/camera", width=SIZE, height=SIZE, aovs=["primId", "instanceId", "depth"])
    delegate.set_setting("samples", 1)
    return delegate


def quad(half: float = 1.0) -> dict[str, Any]:
    return {
        "topology": {
            "scheme": "none",
            "faceVertexCounts": Vt.IntArray([4]),
            "faceVertexIndices": Vt.IntArray([0, 1, 2, 3]),
        },
        "points": Vt.Vec3fArray([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]),
    }


def render(delegate: Any) -> None:
    delegate.commit()
    delegate.start()
    assert delegate.wait(120)


def test_arrays_of_usd_and_numpy_mean_the_same(delegate: Any) -> None:
    delegate.sync_mesh("/quad", **quad(), transform=Gf.Matrix4d(1), prim_id=7)
    render(delegate)
    first = delegate.map("primId")
    assert first.dtype == np.int32 and first.shape == (SIZE, SIZE, 1)
    assert first[SIZE // 2, SIZE // 2, 0] == 7 and first[0, 0, 0] == -1
    built = delegate.counters()["meshesBuilt"]
    same = quad()
    for dtype in (np.float32, np.float64, np.float16):
        delegate.sync_mesh("/quad", points=np.array(same["points"], dtype=dtype), transform=np.eye(4))
    delegate.sync_mesh("/quad", topology={"scheme": "none", "faceVertexCounts": [4], "faceVertexIndices": range(4)})
    assert not delegate.commit()
    assert delegate.counters()["meshesBuilt"] == built


def test_point_instances_take_raw_arrays(delegate: Any) -> None:
    delegate.sync_instancer(
        "/points",
        positions=Vt.Vec3fArray([(-1, 0, 0), (1, 0, 0), (0, 1, 0)]),
        orientations=Vt.QuathArray([Gf.Quath(1, 0, 0, 0), Gf.Quath(0.7071, 0, 0, 0.7071), Gf.Quath(1, 0, 0, 0)]),
        scales=np.full((3, 3), 0.5, np.float32),
        proto_indices=Vt.IntArray([0, 0, 0]),
        ids=Vt.Int64Array([100, 200, 300]),
        invisible_ids=Vt.Int64Array([300]),
    )
    delegate.sync_mesh("/points/proto", **quad(), instancer="/points", prototype=0)
    render(delegate)
    ids = delegate.map("instanceId")[..., 0]
    assert set(np.unique(ids)) == {-1, 0, 1}
    row = ids[SIZE // 2]
    assert row[SIZE // 4] == 0 and row[3 * SIZE // 4] == 1
    assert delegate.stats()["instances"] == 2


def test_a_moving_value_is_a_list_of_samples(delegate: Any) -> None:
    delegate.sync_mesh("/quad", **quad(), transform=[(0.0, Gf.Matrix4d(1)), (1.0, Gf.Matrix4d(2))])
    with pytest.raises(ValueError, match="rising order"):
        delegate.sync_mesh("/quad", transform=[(1.0, np.eye(4)), (0.0, np.eye(4))])


@pytest.mark.parametrize(
    ("method", "arguments", "error", "words"),
    [
        ("sync_mesh", {"points": np.zeros((3, 2))}, ValueError, r"points must have the shape \(n, 3\), not \(3, 2\)"),
        ("sync_mesh", {"points": "abc"}, TypeError, "points must be an array of numbers, not str"),
        ("sync_mesh", {"pionts": 1}, TypeError, 'no argument "pionts"'),
        ("sync_mesh", {"topology": {"faces": [1]}}, ValueError, 'topology has no "faces"'),
        ("sync_mesh", {"topology": {"faceVertexCounts": [1.5]}}, TypeError, "whole numbers"),
        ("sync_mesh", {"transform": np.eye(3)}, ValueError, "4x4"),
        ("sync_mesh", {"primvars": [("st", "vertex", [1])]}, ValueError, "name, interpolation, values, indices"),
        ("sync_mesh", {"primvars": [("m", "vertex", np.zeros((2, 7)), None)]}, ValueError, "not 7"),
        ("sync_mesh", {"refine_level": float("nan")}, ValueError, "whole number"),
        ("sync_implicit", {"shape": {"type": "Torus"}}, ValueError, "Torus"),
        ("sync_implicit", {"shape": {"radius": 1}}, ValueError, "needs a type"),
        ("sync_light", {"params": {"tpye": 1}}, ValueError, "tpye"),
        ("sync_light", {"params": {"intensity": "bright"}}, TypeError, "intensity must be a number, not str"),
        ("sync_camera", {"params": {"clippingRange": (1, 2, 3)}}, ValueError, "two numbers"),
        ("sync_material", {"contexts": {"": {"nodes": [{"path": 3}]}}}, TypeError, "path must be a string, not int"),
        ("sync_material", {"contexts": {"": {"connections": [("a", "b")]}}}, ValueError, "four names"),
        ("sync_material", {"contexts": {"": {"nodes": [{"parameters": {"x": (1, 2, 3, 4, 5)}}]}}}, ValueError, "not 5"),
    ],
)
def test_what_makes_no_sense_is_refused(
    delegate: Any, method: str, arguments: dict[str, Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        getattr(delegate, method)("/prim", **arguments)


def test_pass_and_settings_are_checked(core: Any, delegate: Any) -> None:
    for arguments, words in [
        ({"width": 0}, "0 x"),
        ({"height": -5}, "1 to 65536"),
        ({"width": 10**12}, "1 to 65536"),
        ({"aovs": ["beauty"]}, "beauty"),
        ({"window_policy": "stretch"}, "stretch"),
    ]:
        with pytest.raises(ValueError, match=words):
            delegate.set_render_pass(**arguments)
    for token, value in [("samples", 0), ("samples", 1.5), ("nope", 1), ("samples", 10**30)]:
        with pytest.raises(ValueError):
            delegate.set_setting(token, value)
    assert delegate.set_setting("maxBounces", 2) and not delegate.set_setting("maxBounces", 2)
    assert delegate.setting("maxBounces") == 2
    for row in core.render_settings():
        assert delegate.set_setting(row["token"], delegate.setting(row["token"])) is False
    delegate.set_render_pass(camera="/nowhere")
    with pytest.raises(RuntimeError, match="/nowhere"):
        delegate.commit()


def test_textures_are_asked_for_and_checked(delegate: Any) -> None:
    asset = {"authored": "a.png", "resolved": "/a.png", "colorSpace": ""}
    delegate.sync_light("/dome", params={"type": "DomeLight", "texture:file": asset})
    (request,) = delegate.pending_textures()
    assert (request.resolved_path, request.location, request.is_color) == ("/a.png", "/dome", True)
    for pixels, error in [
        (np.zeros((2, 2, 3), np.uint8), ValueError),
        (np.zeros((2, 2, 4), np.int16), TypeError),
        (np.zeros((0, 2, 4), np.uint8), ValueError),
        ("pixels", TypeError),
    ]:
        with pytest.raises(error):
            delegate.set_texture(request.key, pixels)
    with pytest.raises(ValueError):
        delegate.set_texture(12345, np.zeros((2, 2, 4), np.uint8))
    delegate.sync_camera("/camera", params={"focalLength": 5.0}, transform=np.eye(4))
    for kind, one in ((np.float16, 1), (np.float32, 1), (np.uint16, 65535), (np.uint8, 255)):
        top_down = np.zeros((64, 128, 4), kind)
        top_down[:32] = one  # the upper half of the sky
        delegate.set_texture(request.key, top_down)
        assert delegate.pending_textures() == []
        render(delegate)
        color = delegate.map("color")
        assert color[2, SIZE // 2, 0] == pytest.approx(1, abs=0.05) and color[-3, SIZE // 2, 0] == 0


def test_films_merge_to_the_bit(delegate: Any) -> None:
    delegate.sync_mesh("/quad", **quad())
    films = []
    for first, samples in [(0, 4), (0, 2), (2, 2)]:
        delegate.set_setting("firstSample", first)
        delegate.set_setting("samples", samples)
        render(delegate)
        films.append(delegate.read_film())
    whole, low, high = films
    merged = high.merge(low)
    assert merged.first_sample == 0 and merged.samples == 4
    assert np.array_equal(merged.sums, whole.sums) and np.array_equal(merged.first, whole.first)
    assert np.array_equal(merged.resolve("color"), whole.resolve("color"))
    with pytest.raises(ValueError):
        low.merge(low)


def test_the_gil_is_free_while_waiting(delegate: Any) -> None:
    delegate.sync_mesh("/quad", **quad())
    delegate.set_setting("samples", 4096)
    delegate.commit()
    delegate.start()
    waited = threading.Event()

    def wait() -> None:
        delegate.wait(60)
        waited.set()

    thread = threading.Thread(target=wait)
    thread.start()
    assert delegate.progress()["pathsTotal"] > 0
    delegate.stop()
    thread.join(60)
    assert waited.is_set()
