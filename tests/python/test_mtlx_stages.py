# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What a stage may do with .mtlx files: looks, variants, overrides through layers, instances; and what they hold."""

from __future__ import annotations

import gc
import weakref

import pytest

pytest.importorskip("MaterialX", reason="the materialx package comes with the [usd] extra")


def material(name, body="", extra=""):
    return f"""
  <standard_surface name="S_{name}" type="surfaceshader">{body}</standard_surface>
  <surfacematerial name="{name}" type="material" {extra}>
    <input name="surfaceshader" type="surfaceshader" nodename="S_{name}"/>
  </surfacematerial>"""


def document(body, attributes='version="1.39"'):
    return f'<?xml version="1.0"?>\n<materialx {attributes}>{body}</materialx>\n'


def value(name, number, kind="float"):
    return f'<input name="{name}" type="{kind}" value="{number}"/>'


LOOKS = document(
    material("red", value("metalness", 0.1) + value("specular_roughness", 0.3))
    + material("blue", value("metalness", 0.2))
    + """
  <variantset name="finish">
    <variant name="matte"><input name="specular_roughness" type="float" value="0.9"/></variant>
    <variant name="shiny"><input name="specular_roughness" type="float" value="0.1"/></variant>
  </variantset>
  <collection name="left" includegeom="/a, /b" excludegeom="/b/c"/>
  <collection name="both" includecollection="left" includegeom="/d"/>
  <look name="base">
    <materialassign name="m1" material="red" geom="*"/>
  </look>
  <look name="day" inherit="base">
    <variantassign name="v" variantset="finish" variant="shiny"/>
    <materialassign name="m2" material="blue" collection="both">
      <variantassign name="v" variantset="finish" variant="matte"/>
    </materialassign>
    <materialassign name="m3" material="red" geom="/e"/>
  </look>
  <look name="broken">
    <materialassign name="m1" material="nobody" geom="/a"/>
    <materialassign name="m2" material="red" collection="nobody"/>
    <materialassign name="m3" material="red" geom="/a[0-9]"/>
    <materialassign name="m4" material="red" geom="/b" exclusive="false"/>
    <materialassign name="m5" material="red" geom="/d" exclusive="true"/>
    <visibility name="v" vistype="camera" visible="false" geom="/a"/>
  </look>
  <lookgroup name="group" looks="day, base" default="base"/>
"""
)
GEOMETRY = """
    def Cube "a" { }
    def Xform "b" { def Cube "c" { } def Cube "x" { } }
    def Cube "d" { }
    def Cube "e" { }
    def Cube "f" { }
"""


def look_stage(look):
    variants = f'variants = {{ string LookVariant = "{look}" }}' if look else ""
    text = f'def Xform "world" (\n prepend references = @./m.mtlx@</ModelRoot>\n {variants}\n) {{ {GEOMETRY} }}'
    return text.replace("{ ", "{\n").replace(" }", "\n}").replace("} def", "}\ndef")


def bound(delegate):
    """What each cube is bound to: (metalness, roughness) of its material; None where it has none."""
    found = {}
    for path in delegate.named("implicit"):
        name = delegate.told[path]["material"]
        nodes = delegate.told[name]["mtlx"]["nodes"] if name else []
        (surface,) = [n for n in nodes if n["identifier"].endswith("surfaceshader")] or [None]
        wanted = surface and tuple(surface["parameters"].get(k) for k in ("metalness", "specular_roughness"))
        found[path.removeprefix("/world/")] = wanted and tuple(x and round(x, 6) for x in wanted)
    return found


def test_a_look_binds_its_materials_by_collection_with_its_variants(looks):
    delegate, diagnostics = looks(LOOKS, look_stage("day"))
    day, blue = (0.1, 0.1), (0.2, 0.9)  # the variant counts more than the document's own roughness of 0.3
    assert bound(delegate) == {"a": blue, "b/x": blue, "b/c": (0.1, 0.3), "d": blue, "e": day, "f": (0.1, 0.3)}
    assert {d.code for d in diagnostics} == {"mtlx-bad-reference", "mtlx-geometry-unsupported", "mtlx-look-unsupported"}


@pytest.mark.parametrize("look", ["base", "group"])
def test_a_look_group_is_its_default_look(looks, look):
    delegate, _ = looks(LOOKS, look_stage(look))
    assert set(bound(delegate).values()) == {(0.1, 0.3)} and len(bound(delegate)) == 6


def test_no_look_is_taken_unless_the_stage_chooses_one(looks):
    delegate, diagnostics = looks(LOOKS, look_stage(""))
    assert set(bound(delegate).values()) == {None}
    (said,) = [d for d in diagnostics if d.code == "mtlx-look-unselected"]
    assert said.location == "/world" and "day" in said.message


def test_what_is_wrong_with_a_look_is_said(looks):
    _, diagnostics = looks(LOOKS, look_stage("broken"))
    text = "\n".join(f"{d.location} {d.message}" for d in diagnostics)
    assert "material nobody" in text and "collection nobody" in text and "/a[0-9]" in text and "visibility" in text
    (layered,) = [d for d in diagnostics if "exclusive" in d.message]
    assert layered.code == "mtlx-look-unsupported" and "broken/m4" in layered.message
    assert all(d.location == "/world" and "m.mtlx" in d.message for d in diagnostics)


CYCLES = document(
    material("red")
    + """
  <collection name="p" includecollection="q"/><collection name="q" includecollection="p" includegeom="/a"/>
  <look name="one" inherit="two"/><look name="two" inherit="one">
    <materialassign name="m" material="red" collection="q"/>
  </look>"""
)


def test_cycles_of_looks_and_collections_end(looks):
    from pxr import Plug

    if Plug.Registry().GetPluginWithName("usdMtlx"):
        pytest.skip("UsdMtlx, which reads the file first, ends the process")
    delegate, diagnostics = looks(CYCLES, look_stage("two"))
    assert bound(delegate)["a"] == (None, None) and bound(delegate)["f"] is None
    assert {d.code for d in diagnostics} == {"mtlx-bad-reference"}


def test_materials_inherit(looks):
    text = document(material("base", value("metalness", 0.5)) + material("derived", "", 'inherit="base"'))
    stage = """def "looks" (
    references = @./m.mtlx@</MaterialX/Materials>
) {
}
def Cube "a" {
    rel material:binding = </looks/derived>
}
"""
    delegate, _ = looks(text, stage)
    assert bound(delegate) == {"/a": (0.5, None)}


INNER = """
def Xform "asset" (
    %s
) {
    def "looks" (
        %s = @./m.mtlx@</MaterialX/Materials>
    ) {
        over "red" {
            float inputs:specular_roughness = 0.7
        }
    }
    def Cube "c" (apiSchemas = ["MaterialBindingAPI"]) {
        rel material:binding = </asset/looks/red>
    }
}
"""
RED = document(material("red", value("metalness", 0.1) + value("specular_roughness", 0.3)))


@pytest.mark.parametrize("arc", ["references", "payload"])
def test_what_a_referenced_layer_says_over_its_materials_counts(looks, tmp_path, arc):
    """A reference of the session layer would be stronger than what stands in the referenced file."""
    (tmp_path / "inner.usda").write_text("#usda 1.0\n" + INNER % ("", arc))
    delegate, diagnostics = looks(RED, 'def "world" (\n references = @./inner.usda@</asset>\n) {\n}\n')
    assert bound(delegate) == {"c": (0.1, 0.7)} and not list(diagnostics)


INSTANCES = """
def Xform "world" {
    def "one" (
        instanceable = true
        references = @./inner.usda@</asset>
    ) {
    }
    def "two" (
        instanceable = true
        references = @./inner.usda@</asset>
    ) {
    }
}
"""
NESTED = """
def Xform "group" {
    def "i" (
        instanceable = true
        references = @./inner.usda@</asset>
    ) {
    }
}
def Xform "world" {
    def "one" (
        instanceable = true
        references = </group>
    ) {
    }
    def "two" (
        instanceable = true
        references = </group>
    ) {
    }
}
"""


@pytest.mark.parametrize(("stage", "prototypes"), [(INSTANCES, 1), (NESTED, 2)])
def test_materials_inside_of_instances_are_made_and_stay_shared(looks, tmp_path, stage, prototypes):
    (tmp_path / "inner.usda").write_text("#usda 1.0\n" + INNER % ("", "references"))
    delegate, diagnostics = looks(RED, stage)
    assert not list(diagnostics) and set(bound(delegate).values()) == {(0.1, 0.7)}
    assert len(delegate.stage.GetPrototypes()) == prototypes


def test_a_variant_that_is_chosen_later_brings_its_file(looks, tmp_path):
    from hdwavefront.errors import Diagnostics
    from hdwavefront.mtlx import replace_references
    from pxr import UsdShade

    (tmp_path / "n.mtlx").write_text(document(material("red", value("metalness", 0.8))))
    stage = """
def Xform "looks" (
    prepend variantSets = "v"
    variants = {
        string v = "one"
    }
) {
    variantSet "v" = {
        "one" (
            references = @./m.mtlx@</MaterialX/Materials>
        ) {
        }
        "two" (
            references = @./n.mtlx@</MaterialX/Materials>
        ) {
        }
    }
}
"""
    delegate, _ = looks(RED, stage)
    prim = delegate.stage.GetPrimAtPath("/looks")

    def metalness():
        return UsdShade.Material(prim.GetChild("red")).GetInput("metalness").Get()

    assert metalness() == pytest.approx(0.1)
    prim.GetVariantSets().SetSelection("v", "two")
    replace_references(delegate.stage, Diagnostics())
    assert metalness() == pytest.approx(0.8)
    prim.GetVariantSets().SetSelection("v", "one")
    replace_references(delegate.stage, Diagnostics())
    assert metalness() == pytest.approx(0.1)


def test_sublayers_are_replaced_too(looks):
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage

    cube = 'def Cube "c" {\n rel material:binding = </MaterialX/Materials/red>\n}\n'
    delegate, diagnostics = looks(RED, "(\n subLayers = [@./m.mtlx@]\n)\n" + cube)
    assert bound(delegate) == {"/c": (0.1, 0.3)} and not list(diagnostics)
    said = Diagnostics()
    path = delegate.stage.GetRootLayer().realPath
    outer = path.replace(".usda", "_outer.usda")
    with open(outer, "w") as file:
        file.write(f'#usda 1.0\ndef "x" (\n references = @{path}@</c>\n) {{\n}}\n')
    open_stage(outer, said)
    assert [(d.code, d.location) for d in said] == [("mtlx-reference-unsupported", path)]


def test_converted_layers_live_as_long_as_their_stage(looks):
    from pxr import Sdf

    def converted():
        gc.collect()
        return [layer for layer in Sdf.Layer.GetLoadedLayers() if ".mtlx" in layer.identifier and layer.anonymous]

    before = len(converted())
    delegate, _ = looks(RED, look_stage("").replace("ModelRoot", "MaterialX"))
    assert len(converted()) == before + 1
    stage = weakref.ref(delegate.stage)
    del delegate.stage
    assert stage() is None and len(converted()) == before


def test_every_input_of_the_surface_is_the_materials(looks):
    """Also those that the document leaves at their defaults, as UsdMtlx has it."""
    stage = """def "looks" (
    references = @./m.mtlx@</MaterialX/Materials>
) {
    over "red" {
        float inputs:coat = 0.25
    }
}
def Cube "a" {
    rel material:binding = </looks/red>
}
"""
    delegate, _ = looks(RED, stage)
    (surface,) = delegate.told["/looks/red"]["mtlx"]["nodes"]
    assert surface["parameters"]["coat"] == 0.25


def test_nodes_outside_of_graphs_stand_where_usdmtlx_puts_them(looks):
    text = document(
        '<constant name="c" type="color3"><input name="value" type="color3" value="1, 0, 0"/></constant>'
        + material("red", '<input name="base_color" type="color3" nodename="c"/>')
    )
    delegate, _ = looks(text, look_stage("").replace("ModelRoot", "MaterialX").replace("world", "w"))
    assert delegate.stage.GetPrimAtPath("/w/Materials/red/NodeGraphs/c").GetTypeName() == "Shader"
    assert delegate.stage.GetPrimAtPath("/w/Materials/red/S_red").GetTypeName() == "Shader"


def network_of(looks, text, name="red", **options):
    stage = 'def "l" (\n references = @./m.mtlx@</MaterialX/Materials>\n) {\n}\n'
    cube = f'def Cube "a" {{\n rel material:binding = </l/{name}>\n}}\n'
    delegate, diagnostics = looks(text, stage + cube, **options)
    network = delegate.told[f"/l/{name}"].get("mtlx", {"nodes": []})
    return {n["path"].rsplit("/", 1)[1]: n for n in network["nodes"]}, diagnostics


def test_included_files_and_prefixes_resolve(looks, tmp_path):
    """An image's prefix is its graph's, over the document's; an included file's images may lie beside it."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/beside.png").touch()
    image = '<image name="{0}" type="color3"><input name="file" type="filename" value="{0}.png"/></image>'
    included = document(
        '<nodegraph name="g" fileprefix="">' + image.format("beside") + '<output name="out" type="color3" '
        'nodename="beside"/></nodegraph>'
    )
    (tmp_path / "sub/included.mtlx").write_text(included)
    text = document(
        '<xi:include href="sub/included.mtlx"/>'
        '<nodegraph name="h" fileprefix="deep/">' + image.format("b") + '<output name="out" type="color3" '
        'nodename="b"/></nodegraph>'
        + image.format("a")
        + material(
            "red",
            '<input name="base_color" type="color3" nodegraph="g"/>'
            '<input name="coat_color" type="color3" nodegraph="h" output="out"/>'
            '<input name="specular_color" type="color3" nodename="a"/>',
        ),
        'version="1.39" fileprefix="maps/" xmlns:xi="http://www.w3.org/2001/XInclude"',
    )
    nodes, diagnostics = network_of(looks, text)
    files = {name: nodes[name]["parameters"]["file"]["authored"] for name in ("a", "b", "beside")}
    assert files == {
        "a": str(tmp_path / "maps/a.png"),
        "b": str(tmp_path / "deep/b.png"),
        "beside": str(tmp_path / "sub/beside.png"),
    }
    assert not list(diagnostics)


def test_images_are_looked_for_in_materialx_search_path(looks, tmp_path, monkeypatch):
    (tmp_path / "far").mkdir()
    (tmp_path / "far/a.png").touch()
    monkeypatch.setenv("MATERIALX_SEARCH_PATH", str(tmp_path / "far"))
    image = '<image name="i" type="color3"><input name="file" type="filename" value="a.png"/></image>'
    text = document(image + material("red", '<input name="base_color" type="color3" nodename="i"/>'))
    nodes, _ = network_of(looks, text)
    assert nodes["i"]["parameters"]["file"]["authored"] == str(tmp_path / "far/a.png")


def test_colour_spaces_come_from_the_input_the_graph_or_the_document(looks):
    text = document(
        '<nodegraph name="g" colorspace="lin_adobergb"><constant name="c" type="color3">'
        '<input name="value" type="color3" value="1, 2, 3"/></constant>'
        '<output name="out" type="color3" nodename="c"/></nodegraph>'
        + material(
            "red",
            value("base_color", "1, 2, 3", "color3")
            + '<input name="coat_color" type="color3" value="4, 5, 6" colorspace="srgb_texture"/>'
            + '<input name="specular_color" type="color3" nodegraph="g" output="out"/>',
        ),
        'version="1.39" colorspace="acescg"',
    )
    nodes, _ = network_of(looks, text, convert_color=lambda rgb, space: (space, *rgb))
    assert nodes["S_red"]["parameters"]["base_color"] == ("acescg", 1, 2, 3)
    assert nodes["S_red"]["parameters"]["coat_color"] == ("srgb_texture", 4, 5, 6)
    assert nodes["c"]["parameters"]["value"] == ("lin_adobergb", 1, 2, 3)


@pytest.mark.parametrize("back", ["before", "after", "alone"])
def test_the_front_shows_and_a_back_is_said(looks, back):
    inputs = [
        '<input name="surfaceshader" type="surfaceshader" nodename="front"/>',
        '<input name="backsurfaceshader" type="surfaceshader" nodename="back"/>',
    ]
    inputs = {"before": inputs[::-1], "after": inputs, "alone": inputs[1:]}[back]
    shaders = "".join(f'<standard_surface name="{n}" type="surfaceshader"/>' for n in ("front", "back"))
    text = document(shaders + f'<surfacematerial name="red" type="material">{"".join(inputs)}</surfacematerial>')
    nodes, diagnostics = network_of(looks, text)
    assert list(nodes) == ([] if back == "alone" else ["front"])
    (said,) = [d for d in diagnostics if d.code == "mtlx-unsupported"]
    assert "material red" in said.message and "backsurfaceshader" in said.message


OLD = {
    "1.36": """<materialx version="1.36">
  <nodegraph name="g"><image name="i" type="color3"><parameter name="file" type="filename" value="a.png"/></image>
    <swizzle name="s" type="float"><input name="in" type="color3" nodename="i"/>
      <parameter name="channels" type="string" value="g"/></swizzle>
    <output name="out" type="float" nodename="s"/></nodegraph>
  <material name="red"><shaderref name="S_red" node="standard_surface">
    <bindinput name="metalness" type="float" nodegraph="g" output="out"/>
    <bindinput name="coat" type="float" value="0.5"/></shaderref></material></materialx>""",
    "1.38": """<materialx version="1.38">
  <image name="i" type="color3"><input name="file" type="filename" value="a.png"/></image>
  <standard_surface name="S_red" type="surfaceshader">
    <input name="metalness" type="float" nodename="i" channels="g"/>
    <input name="coat" type="float" value="0.5"/></standard_surface>
  <surfacematerial name="red" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S_red"/></surfacematerial></materialx>""",
}


@pytest.mark.parametrize("version", OLD)
def test_old_versions_are_upgraded(looks, version):
    nodes, diagnostics = network_of(looks, f'<?xml version="1.0"?>\n{OLD[version]}')
    surface = next(n for n in nodes.values() if n["identifier"] == "ND_standard_surface_surfaceshader")
    assert surface["parameters"]["coat"] == 0.5
    kinds = {n["identifier"] for n in nodes.values()}
    assert "ND_image_color3" in kinds and {k for k in kinds if "separate3" in k or "extract" in k}
    assert not list(diagnostics)


DEFINED = """
  <nodedef name="ND_twice" node="twice">
    <input name="in" type="color3" value="0.25, 0.5, 1"/><output name="out" type="color3"/></nodedef>
  <nodegraph name="NG_twice" nodedef="ND_twice"><multiply name="mul" type="color3">
    <input name="in1" type="color3" interfacename="in"/><input name="in2" type="float" value="2"/></multiply>
    <output name="out" type="color3" nodename="mul"/></nodegraph>
  <nodedef name="ND_four" node="four"><input name="in" type="color3" value="1, 1, 1"/>
    <output name="out" type="color3"/></nodedef>
  <nodegraph name="NG_four" nodedef="ND_four">
    <twice name="a" type="color3"><input name="in" type="color3" interfacename="in"/></twice>
    <twice name="b" type="color3"><input name="in" type="color3" nodename="a"/></twice>
    <output name="out" type="color3" nodename="b"/></nodegraph>
"""


def test_own_definitions_nest_and_have_defaults(looks):
    text = document(
        DEFINED
        + '<four name="f" type="color3"/><twice name="t" type="color3"/>'
        + material(
            "red",
            '<input name="base_color" type="color3" nodename="f"/>'
            '<input name="coat_color" type="color3" nodename="t"/>',
        )
    )
    nodes, diagnostics = network_of(looks, text)
    multiplies = [n for n in nodes.values() if n["identifier"] == "ND_multiply_color3FA"]
    assert len(multiplies) == 3 and not list(diagnostics)
    firsts = sorted(n["parameters"]["in1"] for n in multiplies if "in1" in n["parameters"])
    assert firsts == [(0.25, 0.5, 1), (1, 1, 1)]


def test_a_studios_own_definitions_are_found(looks, tmp_path, monkeypatch):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib/own.mtlx").write_text(document(DEFINED))
    monkeypatch.setenv("PXR_MTLX_PLUGIN_SEARCH_PATHS", str(tmp_path / "lib"))
    text = document(
        '<twice name="t" type="color3"/>' + material("red", '<input name="base_color" type="color3" nodename="t"/>')
    )
    nodes, diagnostics = network_of(looks, text)
    assert "ND_multiply_color3FA" in {n["identifier"] for n in nodes.values()} and not list(diagnostics)


def test_a_document_without_materials_has_its_surfaces(looks):
    """Those of its graphs: a surface that a graph gives out, and one in a material inside of a graph."""
    inner = '<standard_surface name="s" type="surfaceshader">' + value("metalness", 0.5) + "</standard_surface>"
    text = document(
        f'<nodegraph name="g">{inner}<output name="out" type="surfaceshader" nodename="s"/></nodegraph>'
        f'<nodegraph name="h">{inner}<surfacematerial name="m" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
        '<output name="out" type="material" nodename="m"/></nodegraph>'
    )
    for name in ("g_out", "h_out"):
        nodes, diagnostics = network_of(looks, text, name)
        assert nodes["s"]["parameters"]["metalness"] == 0.5 and not list(diagnostics)
    nodes, _ = network_of(looks, document(inner), "s_material")
    assert nodes["s"]["parameters"]["metalness"] == 0.5


def test_a_surface_inside_of_a_graph_is_the_material(looks):
    text = document(
        '<nodegraph name="g"><standard_surface name="s" type="surfaceshader">'
        + value("metalness", 0.5)
        + '</standard_surface><output name="out" type="surfaceshader" nodename="s"/></nodegraph>'
        '<surfacematerial name="red" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodegraph="g" output="out"/></surfacematerial>'
    )
    nodes, diagnostics = network_of(looks, text)
    assert nodes["s"]["parameters"]["metalness"] == 0.5 and not list(diagnostics)
