# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Stages that reference .mtlx files, with a pxr that has no UsdMtlx."""

from __future__ import annotations

import sys

import pytest

pytest.importorskip("MaterialX", reason="the materialx package comes with the [usd] extra")

DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709" fileprefix="maps/">
  <nodedef name="ND_twice" node="twice">
    <input name="in" type="color3" value="0, 0, 0"/>
    <output name="out" type="color3"/>
  </nodedef>
  <nodegraph name="NG_twice" nodedef="ND_twice">
    <multiply name="mul" type="color3">
      <input name="in1" type="color3" interfacename="in"/>
      <input name="in2" type="float" value="2"/>
    </multiply>
    <output name="out" type="color3" nodename="mul"/>
  </nodegraph>
  <nodegraph name="graph">
    <input name="tint" type="color3" value="0.5, 0.25, 1" colorspace="acescg"/>
    <image name="picture" type="color3">
      <input name="file" type="filename" value="a.png" colorspace="srgb_texture"/>
    </image>
    <image name="amount" type="float">
      <input name="file" type="filename" value="b.png"/>
    </image>
    <multiply name="tinted" type="color3">
      <input name="in1" type="color3" nodename="picture"/>
      <input name="in2" type="color3" interfacename="tint"/>
    </multiply>
    <output name="colour" type="color3" nodename="tinted"/>
    <output name="rough" type="float" nodename="amount"/>
  </nodegraph>
  <standard_surface name="surface" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="graph" output="colour"/>
    <input name="specular_roughness" type="float" nodegraph="graph" output="rough"/>
    <input name="metalness" type="float" value="0.75"/>
    <input name="thin_walled" type="boolean" value="true"/>
  </standard_surface>
  <twice name="doubled" type="color3">
    <input name="in" type="color3" value="0.1, 0.2, 0.3"/>
  </twice>
  <standard_surface name="plain" type="surfaceshader">
    <input name="base_color" type="color3" nodename="doubled"/>
  </standard_surface>
  <surfacematerial name="textured" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="surface"/>
  </surfacematerial>
  <surfacematerial name="own_node" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="plain"/>
  </surfacematerial>
</materialx>
"""

STAGE = """
def Xform "world" {
    def "looks" (
        references = @./m.mtlx@</MaterialX/Materials>
    ) {
        over "textured" {
            float inputs:metalness = 0.125
        }
    }
    def Cube "a" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        rel material:binding = </world/looks/textured>
    }
    def Cube "b" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        rel material:binding = </world/looks/own_node>
    }
}
"""


@pytest.fixture
def looks(stage_file, tmp_path):
    """The networks of the stage's materials, and the diagnostics."""
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd
    from recording import RecordingDelegate

    def run(document=DOCUMENT, stage=STAGE):
        if document is not None:
            (tmp_path / "m.mtlx").write_text(document)
        diagnostics, delegate = Diagnostics(), RecordingDelegate()
        translate(open_stage(stage_file(stage), diagnostics), Options(time=Usd.TimeCode(0)), delegate, diagnostics)
        return delegate, diagnostics

    return run


def test_the_materials_arrive_as_networks(looks, tmp_path, capfd):
    delegate, diagnostics = looks()
    assert not list(diagnostics) and capfd.readouterr().err == ""
    network = delegate.told["/world/looks/textured"]["mtlx"]
    nodes = {n["path"].rsplit("/", 1)[1]: n for n in network["nodes"]}
    assert nodes["surface"]["identifier"] == "ND_standard_surface_surfaceshader"
    assert nodes["picture"]["identifier"] == "ND_image_color3" and nodes["amount"]["identifier"] == "ND_image_float"
    assert nodes["surface"]["parameters"]["metalness"] == 0.125  # what the stage says over the material counts
    assert nodes["surface"]["parameters"]["thin_walled"] is True
    picture = nodes["picture"]["parameters"]["file"]
    assert picture["authored"] == str(tmp_path / "maps/a.png") and picture["colorSpace"] == "srgb_texture"
    assert nodes["amount"]["parameters"]["file"]["colorSpace"] == ""
    assert nodes["tinted"]["parameters"]["in2"] == pytest.approx((0.5, 0.25, 1))
    joins = {(c[0].rsplit("/", 1)[1], c[1], c[2].rsplit("/", 1)[1], c[3]) for c in network["connections"]}
    assert joins == {
        ("tinted", "out", "surface", "base_color"),
        ("amount", "out", "surface", "specular_roughness"),
        ("picture", "out", "tinted", "in1"),
    }


def test_nodes_that_the_file_defines_are_replaced_by_their_graphs(looks):
    delegate, _ = looks()
    identifiers = {n["identifier"] for n in delegate.told["/world/looks/own_node"]["mtlx"]["nodes"]}
    assert identifiers == {"ND_standard_surface_surfaceshader", "ND_multiply_color3FA"}


@pytest.mark.parametrize("document", [None, "", "<no xml", "<other/>"])
def test_files_that_cannot_be_read_are_said(looks, document):
    delegate, diagnostics = looks(document)
    assert {d.code for d in diagnostics} & {"mtlx-reference-unsupported", "material-missing"}
    assert delegate.told["/world/a"]["material"] == ""


def test_a_missing_package_is_said(looks, monkeypatch):
    monkeypatch.setitem(sys.modules, "MaterialX", None)
    _, diagnostics = looks()
    assert any("pip install materialx" in d.message for d in diagnostics)


def test_third_party_documents_are_converted(assets):
    from hdwavefront.mtlx import convert_file

    files = sorted(assets.rglob("*.mtlx"))
    for file in files:
        convert_file(str(file))
    assert len(files) > 100


@pytest.mark.parametrize(
    ("stage", "materials"),
    [
        ("cornellbox/mtlx-ref/cornell-box.usda", 4),
        ("wrappers/open_chess.usda", 21),
        ("wrappers/shaderball_openpbr.usda", 9),
    ],
)
def test_third_party_stages_have_their_materials(assets, stage, materials):
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd
    from recording import RecordingDelegate

    delegate, diagnostics = RecordingDelegate(), Diagnostics()
    opened = open_stage(str(assets / stage), diagnostics)
    translate(opened, Options(time=Usd.TimeCode(opened.GetStartTimeCode())), delegate, diagnostics)
    assert not list(diagnostics) and len(delegate.named("material")) == materials
