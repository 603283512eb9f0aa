# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Bindings and networks."""

from __future__ import annotations

import pytest
from usda import MATERIALS, QUAD, said


def test_bindings_are_inherited_and_subsets_have_their_own(translated):
    delegate, _ = translated(
        MATERIALS
        + f"""
def Xform "a" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </red>
    def Cube "c" {{}}
    def Mesh "m" {{ {QUAD}
        def GeomSubset "top" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
            uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [0]
            rel material:binding = </blue>
        }}
    }}
}}
def Cube "bare" {{}}
"""
    )
    assert delegate.told["/a/c"]["material"] == "/red" and delegate.told["/bare"]["material"] == ""
    mesh = delegate.told["/a/m"]
    assert mesh["material"] == "/red" and mesh["subset_materials"] == ["/blue"]
    assert mesh["topology"]["subsets"][0][0] == "/a/m/top" and list(mesh["topology"]["subsets"][0][1]) == [0]
    assert set(delegate.named("material")) == {"/red", "/blue"}


def test_binding_purpose_strength_and_collection(translated):
    text = (
        MATERIALS
        + """
def Xform "strong" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </red> (bindMaterialAs = "strongerThanDescendants")
    def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </blue> }
}
def Cube "both" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </red>
    rel material:binding:preview = </blue>
}
def Xform "collected" (prepend apiSchemas = ["MaterialBindingAPI", "CollectionAPI:some"]) {
    rel collection:some:includes = </collected/in>
    rel material:binding:collection:some = [</collected.collection:some>, </red>]
    def Cube "in" {}
    def Cube "out" {}
}
"""
    )
    delegate, _ = translated(text)
    assert delegate.told["/strong/c"]["material"] == "/red"
    assert delegate.told["/both"]["material"] == "/red"
    assert delegate.told["/collected/in"]["material"] == "/red"
    assert delegate.told["/collected/out"]["material"] == ""
    delegate, _ = translated(text, material_purpose="preview")
    assert delegate.told["/both"]["material"] == "/blue"


def test_a_binding_to_nothing_is_said(translated):
    delegate, diagnostics = translated(
        'def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </none> }'
    )
    assert delegate.told["/c"]["material"] == ""
    assert [(d.code, d.location) for d in diagnostics] == [("material-missing", "/c")]


def test_networks_lose_node_graphs_and_interfaces(translated):
    delegate, diagnostics = translated(
        """
def Material "m" {
    float inputs:rough = 0.3
    asset inputs:file = @nowhere.png@
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/graph.outputs:result>
        float inputs:roughness.connect = </m.inputs:rough>
        token outputs:surface
    }
    def NodeGraph "graph" {
        color3f outputs:result.connect = </m/graph/t.outputs:rgb>
        asset inputs:file.connect = </m.inputs:file>
        def Shader "t" { uniform token info:id = "UsdUVTexture"
            asset inputs:file.connect = </m/graph.inputs:file>
            token inputs:wrapS = "mirror"
            float4 inputs:scale = (2, 2, 2, 1)
            color3f outputs:rgb
        }
    }
}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </m> }
"""
    )
    network = delegate.told["/m"][""]
    nodes = {n["path"]: n for n in network["nodes"]}
    assert set(nodes) == {"/m/s", "/m/graph/t"} and network["surface"] == ("/m/s", "surface")
    assert network["connections"] == [("/m/graph/t", "rgb", "/m/s", "diffuseColor")]
    assert nodes["/m/s"]["parameters"]["roughness"] == pytest.approx(0.3)
    texture = nodes["/m/graph/t"]["parameters"]
    assert texture["file"]["authored"] == "nowhere.png" and texture["file"]["resolved"] == ""
    assert texture["wrapS"] == "mirror" and texture["scale"] == (2, 2, 2, 1)
    assert not list(diagnostics)


def test_contexts_stay_apart_and_colours_are_converted(translated):
    delegate, _ = translated(
        """
def Material "m" {
    token outputs:surface.connect = </m/p.outputs:surface>
    token outputs:mtlx:surface.connect = </m/x.outputs:surface>
    def Shader "p" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0)
        normal3f inputs:normal = (0, 0, 1)
        token outputs:surface
    }
    def Shader "x" { uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color = (0, 1, 0) (colorSpace = "acescg")
        token outputs:surface
    }
}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </m> }
""",
        convert_color=lambda rgb, space: tuple(x / 2 if space == "acescg" else x + 1 for x in rgb),
    )
    contexts = delegate.told["/m"]
    assert set(contexts) == {"mtlx", ""}
    assert contexts["mtlx"]["nodes"][0]["parameters"]["base_color"] == (0, 0.5, 0)
    preview = contexts[""]["nodes"][0]["parameters"]
    assert preview["diffuseColor"] == (2, 1, 1) and preview["normal"] == (0, 0, 1)


def test_a_colour_space_that_nobody_knows_is_said(translated):
    delegate, diagnostics = translated(
        """
def Material "m" {
    token outputs:surface.connect = </m/p.outputs:surface>
    def Shader "p" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0) (colorSpace = "nowhere")
        color3f inputs:emissiveColor = (0, 1, 0) (colorSpace = "acescg")
        token outputs:surface
    }
}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </m> }
""",
        knows_color_space=lambda space: space == "acescg",
    )
    assert delegate.told["/m"][""]["nodes"][0]["parameters"]["diffuseColor"] == (1, 0, 0)
    said = [(d.code, d.location) for d in diagnostics]
    assert said == [("color-space-unknown", "/m/p.inputs:diffuseColor")]


def test_a_cycle_of_connections_ends(translated):
    delegate, _ = translated(
        """
def Material "m" { token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/a.outputs:out>
        token outputs:surface
    }
    def Shader "a" { uniform token info:id = "A"
        color3f inputs:in.connect = </m/b.outputs:out>
        color3f outputs:out
    }
    def Shader "b" { uniform token info:id = "B"
        color3f inputs:in.connect = </m/a.outputs:out>
        color3f outputs:out
    }
}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </m> }
"""
    )
    assert len(delegate.told["/m"][""]["nodes"]) == 3


def material(surface: str, extra: str = "", outputs: str = "") -> str:
    """A bound material of one UsdPreviewSurface with more said on it, beside it, and on the Material."""
    return f"""
def Material "m" {{ token outputs:surface.connect = </m/s.outputs:surface>; {outputs}
    def Shader "s" {{ uniform token info:id = "UsdPreviewSurface"; token outputs:surface; {surface} }}
    {extra}
}}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </m> }}
"""


def only_parameters(delegate):
    (node,) = delegate.told["/m"][""]["nodes"]
    return node["parameters"]


def test_values_are_those_of_the_frame(translated):
    text = material("float inputs:roughness.timeSamples = { 1: 0, 3: 1 }")
    assert only_parameters(translated(text, time=2)[0]) == {"roughness": 0.5}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("color4f inputs:x = (1, 2, 3, 4)", (10, 20, 30, 4)),  # alpha is no colour
        ("float3 inputs:x = (1, 2, 3)", (1, 2, 3)),
        ("float4 inputs:x = (1, 2, 3, 4)", (1, 2, 3, 4)),
        ("double2 inputs:x = (1, 2)", (1, 2)),
        ("bool inputs:x = 1", True),
        ("int inputs:x = 3", 3),
        ('token inputs:x = "clamp"', "clamp"),
        ('string inputs:x = "clamp"', "clamp"),
        ("matrix3d inputs:x = ((1, 2, 3), (4, 5, 6), (7, 8, 9))", tuple(range(1, 10))),
        ("color3f inputs:x.connect = </m.inputs:plain>", (10, 20, 30)),  # the shader's type counts
        ("asset inputs:x = @@", None),
    ],
)
def test_values_of_every_type(translated, line, expected):
    delegate, diagnostics = translated(
        material(line, outputs="float3 inputs:plain = (1, 2, 3)"),
        convert_color=lambda rgb, space: tuple(x * 10 for x in rgb),
    )
    assert only_parameters(delegate) == ({} if expected is None else {"x": expected})
    assert not list(diagnostics)


def test_values_that_no_network_takes_are_said(translated):
    delegate, diagnostics = translated(material("float[] inputs:x = [1, 2]"))
    assert only_parameters(delegate) == {} and said(diagnostics) == [("material-value-type", "/m/s.inputs:x")]


@pytest.mark.parametrize(
    ("target", "value"),
    [
        ("</m/g.outputs:set>", None),  # a value, but no shader's output
        ("</nowhere.outputs:rgb>", None),
        ("</m/s.outputs:missing>", None),
        ("</c.size>", None),
        ("</nowhere.outputs:rgb>", (1, 2, 3)),
    ],
)
def test_a_connection_to_no_shader_is_said(translated, target, value):
    """The input's own value counts then, where there is one."""
    own = f"color3f inputs:diffuseColor = {value}; " if value else ""
    text = material(
        f"{own}color3f inputs:diffuseColor.connect = {target}",
        'def NodeGraph "g" { color3f outputs:set = (1, 0, 0); color3f outputs:unset }',
    )
    delegate, diagnostics = translated(text)
    assert only_parameters(delegate) == ({"diffuseColor": value} if value else {})
    assert delegate.told["/m"][""]["connections"] == []
    assert said(diagnostics) == [("material-bad-connection", "/m/s.inputs:diffuseColor")]


def test_an_interface_without_a_value_leaves_the_default(translated):
    text = material("float inputs:roughness.connect = </m.inputs:r>", outputs="float inputs:r")
    delegate, diagnostics = translated(text)
    assert only_parameters(delegate) == {} and not list(diagnostics)


TEXTURE = """def Shader "t" { uniform token info:id = "UsdUVTexture"; color3f outputs:rgb; FILE }"""


@pytest.mark.parametrize(
    ("file", "interface", "space"),
    [
        ('asset inputs:file = @a.png@ (colorSpace = "sRGB")', "", "sRGB"),
        ("asset inputs:file = @a.png@", "", ""),
        (
            'asset inputs:file (colorSpace = "raw"); asset inputs:file.connect = </m.inputs:f>',
            "asset inputs:f = @a.png@",
            "raw",
        ),
        (
            'asset inputs:file (colorSpace = "raw"); asset inputs:file.connect = </m.inputs:f>',
            'asset inputs:f = @a.png@ (colorSpace = "sRGB")',
            "sRGB",
        ),
    ],
)
def test_the_colour_space_of_files(translated, file, interface, space):
    text = material(
        "color3f inputs:diffuseColor.connect = </m/t.outputs:rgb>", TEXTURE.replace("FILE", file), interface
    )
    nodes = {n["path"]: n for n in translated(text)[0].told["/m"][""]["nodes"]}
    assert nodes["/m/t"]["parameters"]["file"] == {"authored": "a.png", "resolved": "", "colorSpace": space}


def test_files_are_resolved_and_tiles_anchored_where_they_are_written(tmp_path):
    """The resolver finds files; patterns of tiles are no files, and stand beside the layer that names them."""
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.assets import asset_value, open_asset
    from pxr import Usd

    (tmp_path / "below").mkdir()
    (tmp_path / "below/a.png").write_bytes(b"bytes")
    (tmp_path / "below/inner.usda").write_text(
        """#usda 1.0
def Shader "s" {
    asset inputs:found = @./a.png@
    asset inputs:tiles = @./t.<UDIM>.png@
    asset inputs:searched = @s/t.<UDIM>.png@
    asset inputs:gone = @./gone.png@
    asset inputs:moving.timeSamples = { 1: @./gone.png@, 2: @./a.png@ }
    asset inputs:none = @@
    asset inputs:blocked
}
"""
    )
    (tmp_path / "outer.usda").write_text("#usda 1.0\n(\n    subLayers = [@./below/inner.usda@]\n)\n")
    stage = open_stage(str(tmp_path / "outer.usda"), Diagnostics())
    prim = stage.GetPrimAtPath("/s")

    def value(name, time=1.0):
        return asset_value(prim.GetAttribute("inputs:" + name), Usd.TimeCode(time))

    assert value("found")["resolved"] == str(tmp_path / "below/a.png")
    assert value("tiles")["resolved"] == str(tmp_path / "below/t.<UDIM>.png")
    assert value("searched")["resolved"] == str(tmp_path / "below/s/t.<UDIM>.png")
    assert value("gone") == {"authored": "./gone.png", "resolved": "", "colorSpace": ""}
    assert value("moving", 2)["resolved"] == str(tmp_path / "below/a.png")
    assert value("none") is None and value("blocked") is None
    assert open_asset(str(tmp_path / "nothing.png")) is None


def test_nodes_without_an_id_are_named_by_their_source(translated):
    text = material(
        "color3f inputs:diffuseColor.connect = </m/o.outputs:rgb>",
        'def Shader "o" { uniform token info:implementationSource = "sourceAsset"; color3f outputs:rgb }',
    )
    nodes = {n["path"]: n["identifier"] for n in translated(text)[0].told["/m"][""]["nodes"]}
    assert nodes["/m/o"] == "(sourceAsset)"


def test_one_surface_for_two_contexts_is_told_once(translated):
    text = material("", outputs="token outputs:mtlx:surface.connect = </m/s.outputs:surface>")
    assert list(translated(text)[0].told["/m"]) == ["mtlx"]


def test_our_own_context_is_read(translated):
    text = material(
        "",
        'def Shader "own" { uniform token info:id = "Own"; token outputs:surface }',
        "token outputs:wavefront:surface.connect = </m/own.outputs:surface>",
    )
    assert set(translated(text)[0].told["/m"]) == {"wavefront", ""}


@pytest.mark.parametrize(
    ("outputs", "expected"),
    [
        ("token outputs:displacement.connect = </m/s.outputs:displacement>", []),
        ("token outputs:volume.connect = </m/d.outputs:out>", ["material-volume-unsupported"]),
        ("token outputs:volume", []),
    ],
)
def test_other_terminals_are_said_where_they_do_something(translated, outputs, expected):
    other = 'def Shader "d" { uniform token info:id = "D"; token outputs:out }'
    _, diagnostics = translated(material("token outputs:displacement", other, outputs))
    assert said(diagnostics) == [(code, "/m") for code in expected]


@pytest.mark.parametrize(
    ("context", "outputs", "told"),
    [
        ("", "token outputs:displacement.connect = </m/s.outputs:displacement>", ("/m/s", "displacement")),
        ("", "token outputs:displacement.connect = </m/d.outputs:out>", ("/m/d", "out")),
        ("mtlx", "token outputs:mtlx:displacement.connect = </m/d.outputs:out>", ("/m/d", "out")),
        ("", "token outputs:displacement", None),
    ],
)
def test_the_displacement_terminal_is_handed_over(translated, context, outputs, told):
    other = 'def Shader "d" { uniform token info:id = "D"; token outputs:out }'
    networks = translated(material("token outputs:displacement", other, outputs))[0].told["/m"]
    assert networks[context].get("displacement") == told
    assert networks[""]["surface"] == ("/m/s", "surface")
    if told:
        assert told[0] in {node["path"] for node in networks[context]["nodes"]}
        assert ("surface" in networks[context]) is (context == "")


@pytest.mark.parametrize("outputs", ["", "token outputs:ri:surface.connect = </m/s.outputs:surface>"])
def test_a_material_without_a_surface_is_said(translated, outputs):
    text = f"""def Material "m" {{ {outputs}
    def Shader "s" {{ uniform token info:id = "PxrSurface"; token outputs:surface }}
}}
def Cube "c" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </m> }}"""
    delegate, diagnostics = translated(text)
    assert delegate.told["/m"] == {} and said(diagnostics) == [("material-no-surface", "/m")]
    assert ("ri:surface" in next(iter(diagnostics)).message) is bool(outputs)


@pytest.mark.parametrize(
    ("surface", "shines"),
    [
        ("", False),
        ("color3f inputs:emissiveColor = (0, 0, 0)", False),
        ("color3f inputs:emissiveColor = (0, 0, 1)", True),
        ("float inputs:emission = 0", False),
        ("float inputs:emission = 0.5", True),
        ("color3f inputs:emissiveColor.connect = </m/t.outputs:rgb>", True),
        ("color3f inputs:diffuseColor.connect = </m/t.outputs:rgb>", False),
    ],
)
def test_whether_a_material_may_shine(translated, surface, shines):
    """Decides on the camera light; any used material will do, whatever comes after it."""
    text = material(surface, TEXTURE.replace("FILE", "")) + MATERIALS
    text += 'def Cube "z" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </red> }'
    assert translated(text)[0].translation.has_emission is shines
