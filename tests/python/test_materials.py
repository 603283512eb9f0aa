# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Bindings and networks."""

from __future__ import annotations

import pytest
from usda import MATERIALS, QUAD


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
