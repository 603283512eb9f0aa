# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Every pattern node of MaterialX's library: compiled, run on the device and compared with a reference of its own."""

from __future__ import annotations

import warnings
from typing import Any

import node_reference as reference
import numpy as np
import pytest
from node_cases import HEIGHTS, TEXT_READERS, TEXTS, cases_of, is_text, plain_definitions, reads_file
from node_document import DOCUMENT, document
from node_harness import Case, Network, Varying, execute, library, pattern_definitions, run, scene

# Definitions a kernel: enough to share what a kernel costs, few enough that compiling stays linear.
BATCH = 9
# float32 through long chains; lacunarity moves noise far from the origin, where its lattice is coarse.
TOLERANCE = 1e-3


def given(case: Case) -> dict[str, Any]:
    """The case's inputs as the reference takes them."""
    found: dict[str, Any] = {}
    for port in case.definition.getActiveInputs():
        name = port.getName()
        if name not in case.inputs:
            continue
        value = case.inputs[name]
        if isinstance(value, Varying):
            found[name] = value.values().astype(float)
        elif isinstance(value, str):
            found[name] = value
        else:
            side = {"matrix33": 3, "matrix44": 4}.get(port.getType())
            found[name] = np.array([value], np.float32).astype(float).reshape((1, side, side) if side else (1, -1))
    return found


def check(case: Case) -> None:
    name = f"{case.definition.getName()} ({case.label})"
    assert not case.messages, (name, case.messages)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        want = reference.evaluate(case.definition, given(case), scene())
    assert case.outputs, name
    for output, got in case.outputs.items():
        expected = np.broadcast_to(np.asarray(want[output], float), got.shape)
        assert np.isfinite(expected).all(), f"{name}: the reference of {output} is not finite"
        error = np.abs(got - expected) / (1 + np.abs(expected))
        worst = np.unravel_index(np.argmax(np.where(np.isfinite(error), error, np.inf)), error.shape)
        assert error[worst] < TOLERANCE, f"{name}: {output} is {got[worst[0]]} instead of {expected[worst[0]]}"


PLAIN = plain_definitions()
BATCHES = [PLAIN[i : i + BATCH] for i in range(0, len(PLAIN), BATCH)]


@pytest.mark.parametrize("definitions", BATCHES, ids=lambda d: d[0].getName().removeprefix("ND_"))
def test_nodes_give_what_they_should(kernel_runner, definitions):
    cases = [case for definition in definitions for case in cases_of(definition)]
    run(kernel_runner, cases)
    for case in cases:
        check(case)


def _slope(network: Network, along: str, factor: float) -> str:
    """A height that grows by `factor` over the texture coordinate."""
    network.add("/uv", "ND_texcoord_vector2")
    at = network.add(f"/{along}", "ND_extract_vector2", {"index": "uv".index(along)})
    scaled = network.add(f"/{along}/scaled", "ND_multiply_float", {"in2": factor})
    network.connect("/uv", "out", at, "in")
    network.connect(at, "out", scaled, "in1")
    return scaled


def _fair() -> np.ndarray:
    """Triangles that are no slivers in texture space, where rounding is amplified."""
    a, b = (scene()["stCorners"][:, k] - scene()["stCorners"][:, 0] for k in (1, 2))
    area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return area > 0.2 * np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)


@pytest.mark.parametrize("footprint", [0.0, 0.02])
def test_heights_become_normals(kernel_runner, footprint):
    """The plane h = a u + b v: its normal is (-k a, -k b, 1) with k = scale / 16, whatever the triangle."""
    a, b, scale = 3.0, -2.0, 4.0
    network = Network()
    total = network.add("/height", "ND_add_float")
    network.connect(_slope(network, "u", a), "out", total, "in1")
    network.connect(_slope(network, "v", b), "out", total, "in2")
    node = network.add("/node", "ND_heighttonormal_vector3", {"scale": scale})
    network.connect(total, "out", node, "in")
    result = network.shine(node, "out")
    assert result["messages"] == []
    n = np.array([-scale / 16 * a, -scale / 16 * b, 1])
    got = execute(kernel_runner, result, footprint=footprint)[0]
    # Differences of numbers up to 10 over thousandths of an edge.
    assert np.abs(got - (n / np.linalg.norm(n) * 0.5 + 0.5))[_fair()].max() < 3e-3


def test_bumps_bend_the_normal(kernel_runner):
    """The same plane by `bump`: tangent and bitangent carry the slopes."""
    slope, scale = 8.0, 0.5
    network = Network()
    node = network.add("/node", "ND_bump_vector3", {"scale": scale})
    network.connect(_slope(network, "u", slope), "out", node, "height")
    got = execute(kernel_runner, network.shine(node, "out"))[0]
    t, _ = reference.frame(scene())
    n = scene()["normalWorld"].astype(float)
    encoded = reference.normalize(np.array([[-slope / 16, 0, 1]]))
    want = reference.normalize(t * encoded[:, :1] * scale + n * encoded[:, 2:])
    assert np.abs(got - want)[_fair()].max() < 3e-3


def test_steps_are_as_soft_as_the_ray_cone_is_wide(kernel_runner):
    definition = library().getNodeDef("ND_splitlr_float")
    inputs = {"valuel": 0.0, "valuer": 1.0, "center": 0.1}
    sharp, soft = Case(definition, dict(inputs)), Case(definition, dict(inputs))
    run(kernel_runner, [sharp])
    run(kernel_runner, [soft], footprint=0.5)
    u = scene()["st"][:, :1]
    assert (sharp.outputs["out"] == (u > 0.1)).all()
    between = (soft.outputs["out"] > 0) & (soft.outputs["out"] < 1)
    assert between.any()
    assert (np.sign(soft.outputs["out"] - 0.5) == np.sign(u - 0.1)).all()


FILES = [d for d in pattern_definitions() if reads_file(d)]
FILE_BATCHES = [FILES[i : i + 6] for i in range(0, len(FILES), 6)]


@pytest.mark.parametrize("definitions", FILE_BATCHES, ids=lambda d: d[0].getName().removeprefix("ND_"))
def test_image_nodes_give_what_they_should(kernel_runner, definitions):
    cases = [case for definition in definitions for case in cases_of(definition)]
    run(kernel_runner, cases)
    for case in cases:
        check(case)


def test_every_node_is_tried_somewhere():
    tried = {d.getName() for d in PLAIN} | HEIGHTS | TEXTS | set(TEXT_READERS)
    tried |= {d.getName() for d in FILES}
    assert tried == {d.getName() for d in pattern_definitions()}
    assert len(tried) > 700
    assert all(is_text(library().getNodeDef(name)) for name in TEXTS)


@pytest.mark.parametrize("name", sorted(TEXT_READERS))
def test_text_primvars_say_that_they_are_not_read(name):
    from node_harness import generator

    definition = library().getNodeDef(name)
    key = "varname" if "UsdPrimvarReader" in name else "geomprop"
    nodes: list[Any] = [
        ("/text", name, {key: "chosen"}),
        ("/value", "ND_geompropvalue_color3", {}),
        ("/image", "ND_image_color3", {}),
        ("/surface", "ND_surface_unlit", {}),
    ]
    kind = definition.getActiveOutputs()[0].getType()
    target, port = ("/value", "geomprop") if kind == "string" else ("/image", "file")
    connections = [("/text", "out", target, port), (target, "out", "/surface", "emission_color")]
    messages = generator().generate(nodes, connections, "/surface")["messages"]
    assert messages[0][:2] == ("material-unsupported-feature", "/text")
    assert TEXT_READERS[name] in messages[0][2]


def test_texts_and_files_go_through_nodes(kernel_runner):
    """A name and a file that come from `constant` and `dot` are the name and the file that are used."""
    from node_harness import generator

    nodes: list[Any] = [
        ("/name", "ND_constant_string", {"value": "real_any_0_3"}),
        ("/through", "ND_dot_string", {}),
        ("/value", "ND_geompropvalue_color3", {}),
        ("/file", "ND_constant_filename", {"value": ("asset", "a.png", "srgb_texture")}),
        ("/fileThrough", "ND_dot_filename", {}),
        ("/image", "ND_image_color3", {}),
        ("/sum", "ND_add_color3", {}),
        ("/surface", "ND_surface_unlit", {}),
    ]
    connections = [
        ("/name", "out", "/through", "in"),
        ("/through", "out", "/value", "geomprop"),
        ("/file", "out", "/fileThrough", "in"),
        ("/fileThrough", "out", "/image", "file"),
        ("/value", "out", "/sum", "in1"),
        ("/image", "out", "/sum", "in2"),
        ("/sum", "out", "/surface", "emission_color"),
    ]
    found = generator().generate(nodes, connections, "/surface")
    assert found["messages"] == []
    assert "real_any_0_3" in found["primvars"]
    assert [(t[0], t[2], t[3]) for t in found["textures"]] == [("a.png", "srgb_texture", True)]


def test_the_document_lists_what_the_library_has():
    assert DOCUMENT.read_text() == document(), "run tests/materialgen/node_document.py to write it anew"
