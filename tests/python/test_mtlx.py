# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Stages that reference .mtlx files: the materials arrive as networks, whichever pxr there is."""

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


def test_the_materials_arrive_as_networks(looks, tmp_path, capfd):
    delegate, diagnostics = looks(DOCUMENT, STAGE)
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
    delegate, _ = looks(DOCUMENT, STAGE)
    identifiers = {n["identifier"] for n in delegate.told["/world/looks/own_node"]["mtlx"]["nodes"]}
    assert identifiers == {"ND_standard_surface_surfaceshader", "ND_multiply_color3FA"}


UNITS = """<?xml version="1.0"?>
<materialx version="1.39">
  <standard_surface name="surface" type="surfaceshader">
    <input name="subsurface_scale" type="float" value="3" unit="millimeter" unittype="distance"/>
    <input name="transmission_depth" type="float" value="2"/>
    <input name="thin_film_thickness" type="float" value="0.5" unit="furlong" unittype="distance"/>
    <input name="base_color" type="color3" nodename="turned"/>
  </standard_surface>
  <tiledimage name="turned" type="color3">
    <input name="texcoord" type="vector2" nodename="rotate"/>
    <input name="realworldimagesize" type="vector2" value="1, 2" unit="inch"/>
    <input name="realworldtilesize" type="vector2" nodename="tile"/>
  </tiledimage>
  <constant name="tile" type="vector2">
    <input name="value" type="vector2" value="1, 1" unit="yard" unittype="distance"/>
  </constant>
  <rotate2d name="rotate" type="vector2">
    <input name="amount" type="float" value="0.5" unit="radian" unittype="angle"/>
  </rotate2d>
  <dielectric_bsdf name="film" type="BSDF">
    <input name="thinfilm_thickness" type="float" value="0.5" unit="micron" unittype="distance"/>
  </dielectric_bsdf>
  <surface name="filmed" type="surfaceshader">
    <input name="bsdf" type="BSDF" nodename="film"/>
  </surface>
  <surfacematerial name="textured" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="surface"/>
  </surfacematerial>
  <surfacematerial name="own_node" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="filmed"/>
  </surfacematerial>
</materialx>
"""


@pytest.mark.parametrize("meters", [1.0, 0.01, 0.0254])
def test_values_with_units_become_scene_units(looks, meters):
    delegate, diagnostics = looks(UNITS, f"(\n    metersPerUnit = {meters}\n)\n{STAGE}")
    assert [d.code for d in diagnostics] == ["mtlx-bad-unit"] and "furlong" in next(iter(diagnostics)).message

    def parameters(material):
        return {n["path"].rsplit("/", 1)[1]: n["parameters"] for n in delegate.told[material]["mtlx"]["nodes"]}

    nodes = parameters("/world/looks/textured")
    assert nodes["surface"]["subsurface_scale"] == pytest.approx(0.003 / meters)
    assert nodes["surface"]["transmission_depth"] == 2 and nodes["surface"]["thin_film_thickness"] == 0.5
    assert nodes["turned"]["realworldimagesize"] == pytest.approx((0.0254 / meters, 0.0508 / meters))
    assert nodes["tile"]["value"] == pytest.approx((0.9144 / meters,) * 2)
    assert nodes["rotate"]["amount"] == pytest.approx(28.6479, abs=1e-3)
    # What a definition says in nanometres stays in them, whatever the scene's unit.
    assert parameters("/world/looks/own_node")["film"]["thinfilm_thickness"] == pytest.approx(500)


@pytest.mark.parametrize("document", [None, "", "<no xml", "<other/>"])
def test_files_that_cannot_be_read_are_said(looks, document):
    delegate, diagnostics = looks(document, STAGE)
    assert {d.code for d in diagnostics} & {"mtlx-reference-unsupported", "material-missing"}
    assert delegate.told["/world/a"]["material"] == ""


def test_a_missing_package_is_said(looks, monkeypatch):
    monkeypatch.setitem(sys.modules, "MaterialX", None)
    _, diagnostics = looks(DOCUMENT, STAGE)
    assert any("pip install materialx" in d.message for d in diagnostics)


def test_third_party_documents_are_converted(assets):
    from hdwavefront.mtlx import convert_file

    files = sorted(assets.rglob("*.mtlx"))
    for file in files:
        convert_file(str(file))
    assert len(files) > 100


# What MaterialX's own documents ask for and do not get, by document and code.
KNOWN_OF_MATERIALX = {
    ("open_pbr_glass", "material-unsupported-feature"),  # dispersion
    ("surfacematerial_with_graph", "material-no-surface"),  # M_EmptySurface and M_EmptyVolume
}


def test_materialxs_own_documents_arrive_as_kernels(assets, tmp_path):
    """All of them in one stage, through the converter, the translation and the generator; nothing is compiled here
    (tests/materialgen/documents_test.cpp compiles what they say, read by MaterialX itself)."""
    pytest.importorskip("hdwavefront._core", reason="the native module is not built")
    from hdwavefront.api import create_delegate
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd, UsdShade

    files = sorted((assets / "materialx").rglob("*.mtlx"))
    if not files:
        pytest.skip("MaterialX's documents are not among the third-party assets")
    names = {f"d{i}": file.stem for i, file in enumerate(files)}
    text = [f'def "d{i}" (\n references = @{file}@</MaterialX/Materials>\n) {{\n}}' for i, file in enumerate(files)]
    path = tmp_path / "all.usda"
    path.write_text("\n".join(["#usda 1.0", *text, ""]))
    diagnostics, delegate = Diagnostics(), create_delegate()
    stage = open_stage(str(path), diagnostics)
    materials = [prim for prim in stage.Traverse() if prim.IsA(UsdShade.Material)]
    for i, prim in enumerate(materials):
        cube = stage.DefinePrim(f"/cube{i}", "Cube")
        UsdShade.MaterialBindingAPI.Apply(cube).Bind(UsdShade.Material(prim))
    translate(stage, Options(time=Usd.TimeCode(0)), delegate, diagnostics)
    delegate.pending_textures()  # generates the kernels' sources

    def document(location):
        return names[str(location).split("/")[1]]

    said = [*diagnostics, *delegate.diagnostics()]
    assert not [d for d in said if d.severity == "error"]
    # The assets are without most of MaterialX's pictures.
    assert {(document(d.location), d.code) for d in said if d.code != "texture-missing"} == KNOWN_OF_MATERIALX
    assert (len(files), len(materials)) == (77, 124)
    sources = {str(prim.GetPath()): delegate.material_source(str(prim.GetPath())) for prim in materials}
    without = [path.rsplit("/", 1)[1] for path, source in sources.items() if not source.get("surface")]
    assert without == ["M_EmptySurface", "M_EmptyVolume"]
    assert len({s["surface"] for s in sources.values() if s}) > 70  # of each its own, not one that stands in for all


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


def networks_of(looks, body, stage=STAGE):
    """Nodes by name of the material "textured", whose document is `body`."""
    document = f'<?xml version="1.0"?>\n<materialx version="1.39">{body}</materialx>\n'
    delegate, diagnostics = looks(document, stage)
    network = delegate.told["/world/looks/textured"]["mtlx"]
    return {n["path"].rsplit("/", 1)[1]: n for n in network["nodes"]}, network, delegate, diagnostics


SURFACE = """
  <standard_surface name="surface" type="surfaceshader">{}</standard_surface>
  <surfacematerial name="textured" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="surface"/>{}
  </surfacematerial>"""


def test_values_of_every_type_arrive(looks, tmp_path):
    nodes, *_ = networks_of(
        looks,
        f"""
  <place2d name="place" type="vector2">
    <input name="texcoord" type="vector2" value="1, 2"/>
    <input name="operationorder" type="integer" value="1"/>
  </place2d>
  <image name="picture" type="color3">
    <input name="file" type="filename" value="{tmp_path}/absolute.png"/>
    <input name="texcoord" type="vector2" nodename="place"/>
    <input name="uaddressmode" type="string" value="clamp"/>
  </image>
  <constant name="four" type="color4"><input name="value" type="color4" value="1, 2, 3, 4"/></constant>
  <convert name="three" type="color3"><input name="in" type="color4" nodename="four"/></convert>
  <transformmatrix name="turned" type="vector3">
    <input name="in" type="vector3" value="1, 2, 3"/>
    <input name="mat" type="matrix44" value="1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16"/>
  </transformmatrix>
  <separate3 name="parts" type="multioutput"><input name="in" type="vector3" nodename="turned"/></separate3>
"""
        + SURFACE.format(
            """
    <input name="base_color" type="color3" nodename="picture"/>
    <input name="specular_color" type="color3" nodename="three"/>
    <input name="metalness" type="float" nodename="parts" output="outy"/>
    <input name="thin_walled" type="boolean" value="false"/>""",
            "",
        ),
    )
    parameters = {name: node["parameters"] for name, node in nodes.items()}
    order = parameters["place"]["operationorder"]
    assert order == 1 and isinstance(order, int) and parameters["place"]["texcoord"] == (1, 2)
    assert parameters["picture"]["file"]["authored"] == f"{tmp_path}/absolute.png"
    assert parameters["picture"]["uaddressmode"] == "clamp" and parameters["four"]["value"] == (1, 2, 3, 4)
    assert parameters["turned"]["mat"] == tuple(range(1, 17)) and parameters["turned"]["in"] == (1, 2, 3)
    assert parameters["surface"]["thin_walled"] is False


def test_outputs_are_named(looks):
    _, network, *_ = networks_of(
        looks,
        """<separate3 name="parts" type="multioutput"><input name="in" type="vector3" value="1, 2, 3"/></separate3>"""
        + SURFACE.format('<input name="metalness" type="float" nodename="parts" output="outy"/>', ""),
    )
    assert [c[1] for c in network["connections"]] == ["outy"]


def test_colour_spaces_stay_with_their_values(looks):
    """Also through the material's own input, where the surface's values are promoted to."""
    delegate, _ = looks(
        f"""<?xml version="1.0"?><materialx version="1.39" colorspace="lin_rec709">
        {SURFACE.format('<input name="base_color" type="color3" value="1, 0, 0" colorspace="acescg"/>', "")}
        </materialx>""",
        STAGE,
        convert_color=lambda rgb, space: (space, *rgb),
    )
    (node,) = delegate.told["/world/looks/textured"]["mtlx"]["nodes"]
    assert node["parameters"]["base_color"] == ("acescg", 1, 0, 0)


def test_displacement_is_a_terminal(looks):
    nodes, network, _, diagnostics = networks_of(
        looks,
        """<displacement name="bumps" type="displacementshader">
          <input name="displacement" type="float" value="0.5"/></displacement>"""
        + SURFACE.format("", '<input name="displacementshader" type="displacementshader" nodename="bumps"/>'),
    )
    assert network["displacement"] == ("/world/looks/textured/bumps", "displacement")
    assert nodes["bumps"]["parameters"]["displacement"] == 0.5
    assert not [d for d in diagnostics if "displacement" in d.code]


def test_payloads_are_replaced_as_references_are(looks):
    stage = STAGE.replace("references = @", "payload = @")
    value = '<input name="metalness" type="float" value="0.75"/>'
    nodes, *_ = networks_of(looks, SURFACE.format(value, ""), stage)
    assert nodes["surface"]["parameters"]["metalness"] == 0.125


def test_other_references_of_the_prim_stay_stronger(looks):
    other = """def Scope "overrides" {
    over "textured" {
        float inputs:metalness = 0.5
    }
}
"""
    arcs = "references = [</overrides>, @./m.mtlx@</MaterialX/Materials>]"
    stage = other + STAGE.replace("references = @./m.mtlx@</MaterialX/Materials>", arcs)
    stage = stage.replace("            float inputs:metalness = 0.125\n", "")
    nodes, *_ = networks_of(looks, SURFACE.format('<input name="metalness" type="float" value="0.75"/>', ""), stage)
    assert nodes["surface"]["parameters"]["metalness"] == 0.5


def test_files_that_a_resolver_finds_keep_their_names(looks):
    image = '<image name="i" type="color3"><input name="file" type="filename" value="store://a/b.png"/></image>'
    use = '<input name="base_color" type="color3" nodename="i"/>'
    nodes, *_ = networks_of(looks, image + SURFACE.format(use, ""))
    assert nodes["i"]["parameters"]["file"]["authored"] == "store://a/b.png"
