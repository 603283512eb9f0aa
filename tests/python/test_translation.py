# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""From stages to updates: inherited state, instancing, bindings, and what is not translated."""

from __future__ import annotations

import numpy as np
import pytest

QUAD = """
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
"""


def translation_of(update) -> tuple[float, ...]:
    return tuple(update["transform"][3, :3])


def primvars_of(update) -> dict[str, tuple]:
    return {p[0]: p for p in update["primvars"]}


def test_a_mesh_arrives_as_authored(translated):
    delegate, diagnostics = translated(
        f"""
def Mesh "m" {{ {QUAD}
    uniform token subdivisionScheme = "loop"
    uniform token orientation = "leftHanded"
    int[] holeIndices = [0]
    int[] creaseIndices = [0, 1]
    int[] creaseLengths = [2]
    float[] creaseSharpnesses = [3.5]
    uniform bool doubleSided = 1
    normal3f[] normals = [(0, 0, 1)] (interpolation = "constant")
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1)] (interpolation = "faceVarying")
    int[] primvars:st:indices = [0, 1, 2, 0]
    string[] primvars:names = ["a", "b"] (interpolation = "uniform")
}}""",
        refine_level=2,
    )
    mesh = delegate.told["/m"]
    topology = mesh["topology"]
    assert (topology["scheme"], topology["orientation"]) == ("loop", "leftHanded")
    assert list(topology["faceVertexIndices"]) == [0, 1, 2, 3] and list(topology["holeIndices"]) == [0]
    assert list(topology["creaseLengths"]) == [2] and topology["creaseSharpnesses"][0] == 3.5
    assert mesh["points"].shape == (4, 3) and mesh["double_sided"] is True and mesh["refine_level"] == 2
    primvars = primvars_of(mesh)
    assert set(primvars) == {"st", "normals"}  # strings are nothing that a material reads
    assert primvars["st"][1] == "faceVarying" and list(primvars["st"][3]) == [0, 1, 2, 0]
    assert primvars["st"][2].shape == (3, 2) and primvars["st"][2].dtype == np.float32
    assert primvars["normals"][1] == "constant"
    assert not list(diagnostics)


def test_primvars_normals_win_over_normals(translated):
    delegate, _ = translated(
        f"""def Mesh "m" {{ {QUAD}
    normal3f[] normals = [(0, 0, 1)] (interpolation = "constant")
    normal3f[] primvars:normals = [(1, 0, 0)] (interpolation = "constant")
}}"""
    )
    normals = [p for p in delegate.told["/m"]["primvars"] if p[0] == "normals"]
    assert len(normals) == 1 and list(normals[0][2][0]) == [1, 0, 0]


def test_time_samples_are_interpolated_at_the_frame(translated):
    text = """def Sphere "s" {
    double radius.timeSamples = { 1: 1, 3: 3 }
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 3: (4, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    color3f[] primvars:displayColor.timeSamples = { 1: [(0, 0, 0)], 3: [(1, 1, 1)] }
}"""
    delegate, _ = translated(text, time=2)
    sphere = delegate.told["/s"]
    assert sphere["shape"]["radius"] == 2 and translation_of(sphere) == (2, 0, 0)
    assert primvars_of(sphere)["displayColor"][2][0, 0] == 0.5


def test_transforms_compose_and_reset(translated):
    delegate, _ = translated(
        """def Xform "a" {
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Cube "below" {
        double3 xformOp:translate = (0, 2, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Cube "reset" {
        double3 xformOp:translate = (0, 5, 0)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
    }
}"""
    )
    assert translation_of(delegate.told["/a/below"]) == (1, 2, 0)
    assert translation_of(delegate.told["/a/reset"]) == (0, 5, 0)


def test_visibility_activation_and_purpose(translated):
    text = """
def Xform "hidden" { token visibility = "invisible"
    def Cube "c" {}
    def SphereLight "l" {}
}
def Cube "inactive" (active = false) {}
def Xform "proxies" { uniform token purpose = "proxy"
    def Cube "c" {}
    def Cube "own" { uniform token purpose = "render" }
}
def Cube "guide" { uniform token purpose = "guide" }
def Cube "plain" {}
"""
    delegate, _ = translated(text)
    assert set(delegate.told) == {"/proxies/c", "/plain"}
    assert delegate.told["/proxies/c"]["render_tag"] == "proxy" and delegate.told["/plain"]["render_tag"] == "geometry"
    delegate, _ = translated(text, purposes=frozenset({"default", "render", "guide"}))
    assert set(delegate.told) == {"/proxies/own", "/guide", "/plain"}


def test_constant_primvars_are_inherited(translated):
    delegate, _ = translated(
        """def Xform "a" {
    color3f[] primvars:displayColor = [(1, 0, 0)]
    float[] primvars:local = [1, 2] (interpolation = "vertex")
    def Xform "b" {
        def Cube "c" {}
        def Cube "d" { color3f[] primvars:displayColor = [(0, 1, 0)] }
    }
}"""
    )
    assert list(primvars_of(delegate.told["/a/b/c"])["displayColor"][2][0]) == [1, 0, 0]
    assert list(primvars_of(delegate.told["/a/b/d"])["displayColor"][2][0]) == [0, 1, 0]
    assert "local" not in primvars_of(delegate.told["/a/b/c"])  # only constants are inherited


MATERIALS = """
def Material "red" { token outputs:surface.connect = </red/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0)
        token outputs:surface
    } }
def Material "blue" { token outputs:surface.connect = </blue/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
    } }
"""


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


POINTS = """
    int[] protoIndices = [0, 1, 0]
    point3f[] positions = [(0, 0, 0), (5, 0, 0), (10, 0, 0)]
"""


def test_a_point_instancer_gives_its_raw_arrays(translated):
    delegate, diagnostics = translated(
        f"""
def PointInstancer "pi" ( inactiveIds = [9] ) {{ {POINTS}
    quath[] orientations = [(1, 0, 0, 0), (0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (2, 2, 2), (3, 3, 3)]
    int64[] ids = [7, 8, 9]
    int64[] invisibleIds = [8]
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1)] (interpolation = "vertex")
    float3 xformOp:translate = (0, 0, 7)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    rel prototypes = [</pi/a>, </pi/b>]
    def Cube "a" {{
        double3 xformOp:translate = (0, 1, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
    def Xform "b" {{ def Sphere "s" {{ color3f[] primvars:displayColor = [(1, 1, 0)] }} }}
    def Cone "not_a_prototype" {{}}
}}"""
    )
    instancer = delegate.told["/pi"]
    assert list(instancer["proto_indices"]) == [0, 1, 0] and instancer["positions"][1, 0] == 5
    assert list(instancer["orientations"][1]) == [0.5] * 4 and list(instancer["orientations"][0]) == [0, 0, 0, 1]
    assert list(instancer["ids"]) == [7, 8, 9]
    assert list(instancer["invisible_ids"]) == [8] and list(instancer["inactive_ids"]) == [9]
    assert translation_of(instancer) == (0, 0, 7)
    assert instancer["primvars"][0][:2] == ("displayColor", "instance") and instancer["primvars"][0][2].shape == (3, 3)
    assert set(delegate.told) == {"/pi", "/pi/a", "/pi/b/s"}
    cube, sphere = delegate.told["/pi/a"], delegate.told["/pi/b/s"]
    assert (cube["instancer"], cube["prototype"], sphere["prototype"]) == ("/pi", 0, 1)
    assert translation_of(cube) == (0, 1, 0)  # the instancer's own transform is not in it
    assert "displayColor" not in primvars_of(cube) and "displayColor" in primvars_of(sphere)
    assert not list(diagnostics)


def test_point_instancers_nest_and_may_share_prototypes(translated):
    delegate, _ = translated(
        """
def "protos" ( active = true ) {
    def Cube "cube" {}
}
def PointInstancer "outer" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = [</outer/inner>]
    def PointInstancer "inner" {
        int[] protoIndices = [0, 0]
        point3f[] positions = [(0, 0, 0), (1, 0, 0)]
        rel prototypes = [</protos/cube>]
    }
}
def PointInstancer "other" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = [</protos/cube>]
}
"""
    )
    inner = delegate.told["/outer/inner"]
    assert (inner["parent"], inner["parent_prototype"]) == ("/outer", 0)
    cubes = delegate.named("implicit")
    assert len(cubes) == 3  # drawn by itself, in inner, and in other
    assert {delegate.told[c].get("instancer", "") for c in cubes} == {"", "/outer/inner", "/other"}


def test_a_point_instancer_that_holds_itself_ends(translated):
    _, diagnostics = translated(
        """
def PointInstancer "pi" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = [</pi>]
}"""
    )
    assert "point-instancer-cycle" in diagnostics.codes()


INSTANCES = """
def Xform "source" {
    def Cube "c" {
        double3 xformOp:translate = (0, 1, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
over "unused" {}
"""


def instance(name: str, x: float, extra: str = "") -> str:
    return f"""def Xform "{name}" ( instanceable = true; prepend references = </source> ) {{
    double3 xformOp:translate = ({x}, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {extra}
}}
"""


def test_native_instances_share_one_mesh(translated):
    delegate, _ = translated(INSTANCES + instance("i", 1) + instance("j", 2))
    instancers = delegate.named("instancer")
    assert len(instancers) == 1
    transforms = delegate.told[instancers[0]]["transforms"]
    assert transforms.shape == (2, 4, 4) and [m[3, 0] for m in transforms] == [1, 2]
    cubes = delegate.named("implicit")
    assert cubes == ["/source/c", "/i/c"]
    assert delegate.told["/i/c"]["instancer"] == instancers[0] and translation_of(delegate.told["/i/c"]) == (0, 1, 0)


def test_instances_that_look_different_are_apart(translated):
    red = "color3f[] primvars:displayColor = [(1, 0, 0)]"
    green = "color3f[] primvars:displayColor = [(0, 1, 0)]"
    delegate, _ = translated(INSTANCES + instance("i", 1, red) + instance("j", 2, green) + instance("k", 3))
    instancers = delegate.named("instancer")
    assert len(instancers) == 2
    colored = next(delegate.told[i] for i in instancers if delegate.told[i]["primvars"])
    name, interpolation, values, _ = colored["primvars"][0]
    assert (name, interpolation) == ("displayColor", "instance") and values.tolist() == [[1, 0, 0], [0, 1, 0]]
    delegate, _ = translated(INSTANCES + instance("i", 1, 'uniform token purpose = "guide"') + instance("j", 2))
    assert len(delegate.named("implicit")) == 2  # the source and /j; guides are not drawn


def test_instances_in_instances_and_in_point_instancers(translated):
    delegate, _ = translated(
        INSTANCES
        + """
def Xform "pair" {
    def Xform "l" ( instanceable = true; prepend references = </source> ) {}
    def Xform "r" ( instanceable = true; prepend references = </source> ) {}
}
def Xform "p1" ( instanceable = true; prepend references = </pair> ) {}
def Xform "p2" ( instanceable = true; prepend references = </pair> ) {}
def PointInstancer "pi" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = [</pi/proto>]
    def Xform "proto" ( instanceable = true; prepend references = </source> ) {}
}
"""
    )
    parents = {i: delegate.told[i].get("parent", "") for i in delegate.named("instancer")}
    inner = [i for i, parent in parents.items() if parent == "/p1.instances"]
    assert len(inner) == 1 and len(delegate.told[inner[0]]["transforms"]) == 2
    in_points = [i for i, parent in parents.items() if parent == "/pi"]
    assert len(in_points) == 1 and len(delegate.told[in_points[0]]["transforms"]) == 1


def test_purpose_at_point_instancers(translated):
    """As in UsdImaging: the instancer's own purpose hides nothing; prototypes inherit in their own namespace."""
    delegate, _ = translated(
        """
def PointInstancer "pi" {
    token purpose = "render"
    rel prototypes = [</pi/proxies>, </pi/plain>, </outside>]
    int[] protoIndices = [0, 1, 2]
    point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    def Xform "proxies" { token purpose = "proxy"; def Cube "c" {} }
    def Xform "plain" { def Cube "c" {} }
}
over "outside" { def Cube "c" {} }
"""
    )
    assert "/pi/proxies/c" in delegate.told and "/pi/plain/c" not in delegate.told and "/outside/c" in delegate.told


def test_instanced_gprims_are_left_out_with_a_word(translated):
    delegate, diagnostics = translated(
        """
def Cube "source" {}
def Cube "direct" ( instanceable = true; prepend references = </source> ) {}
"""
    )
    assert "/source" in delegate.told and "/direct" not in delegate.told
    assert [(d.code, d.location) for d in diagnostics] == [("gprim-instanced", "/direct")]


def test_element_size_that_contradicts_the_indices(translated):
    """Seen in files of Maya: the number of values as elementSize."""
    delegate, diagnostics = translated(
        """
def Mesh "m" {
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (
        elementSize = 3
        interpolation = "faceVarying"
    )
    int[] primvars:st:indices = [0, 2, 1]
}
"""
    )
    (st,) = [p for p in delegate.told["/m"]["primvars"] if p[0] == "st"]
    assert st[2].shape == (3, 2) and list(st[3]) == [0, 2, 1]
    assert [(d.code, d.location) for d in diagnostics] == [("primvar-bad-size", "/m.primvars:st")]


def test_shadows_that_no_light_casts_are_said(translated):
    _, diagnostics = translated(
        """
def SphereLight "odd" { color3f inputs:shadow:color = (1, 0, 0); float inputs:shadow:distance = 3 }
def SphereLight "plain" { color3f inputs:shadow:color = (0, 0, 0); float inputs:shadow:falloff = -1 }
"""
    )
    assert [(d.code, d.location) for d in diagnostics] == [("light-unsupported-input", "/odd")] * 2


def test_lights_that_the_camera_shall_not_see(translated):
    """UsdLux has no attribute for it; the ones that stages carry are understood, and the first one found counts."""
    delegate, _ = translated(
        """
def SphereLight "plain" {}
def SphereLight "usd" { custom bool inputs:visibility:camera = 0; bool primvars:arnold:visibility:camera = 1 }
def SphereLight "arnold" { bool primvars:arnold:visibility:camera = 0 }
def SphereLight "renderman" { int primvars:ri:attributes:visibility:camera = 0 }
def SphereLight "seen" { float primvars:arnold:camera = 1 }
def SphereLight "odd" { string primvars:arnold:camera = "no" }
"""
    )
    seen = {name: delegate.told["/" + name]["params"].get("visibleToCamera") for name in ("plain", "usd", "arnold")}
    assert seen == {"plain": None, "usd": False, "arnold": False}
    seen = {name: delegate.told["/" + name]["params"].get("visibleToCamera") for name in ("renderman", "seen", "odd")}
    assert seen == {"renderman": False, "seen": True, "odd": None}


def test_lights_come_raw(translated):
    delegate, diagnostics = translated(
        """
def RectLight "r" (prepend apiSchemas = ["ShapingAPI"]) {
    float inputs:intensity = 3
    float inputs:exposure = 2
    color3f inputs:color = (1, 0.5, 0.25)
    float inputs:width = 4
    asset inputs:texture:file = @missing.exr@
    float inputs:shaping:cone:angle = 30
}
def SphereLight "s" { bool inputs:normalize = 1; bool treatAsPoint = 1 }
def DistantLight "d" { float inputs:angle = 1 }
def Cube "c" {}
"""
    )
    rect = delegate.told["/r"]["params"]
    assert rect["type"] == "RectLight" and (rect["intensity"], rect["exposure"], rect["width"]) == (3, 2, 4)
    assert rect["color"] == (1, 0.5, 0.25) and rect["shaping:cone:angle"] == 30
    assert rect["texture:file"]["authored"] == "missing.exr"
    sphere = delegate.told["/s"]["params"]
    assert sphere["normalize"] is True and sphere["treatAsPoint"] is True and sphere["radius"] == 0.5
    assert "shaping:cone:angle" not in sphere
    assert not list(diagnostics)


@pytest.mark.parametrize(("up", "axis", "expected"), [("Y", "scene", "Y"), ("Z", "scene", "Z"), ("Y", "Z", "Z")])
def test_the_pole_of_a_dome(translated, up, axis, expected):
    delegate, _ = translated(f'( upAxis = "{up}" )\ndef DomeLight_1 "d" {{ uniform token poleAxis = "{axis}" }}')
    assert delegate.told["/d"]["params"]["poleAxis"] == expected
    delegate, _ = translated(f'( upAxis = "{up}" )\ndef DomeLight "d" {{}}')
    assert delegate.told["/d"]["params"]["poleAxis"] == "Y"


@pytest.mark.parametrize(
    ("prim", "code"),
    [
        ('def BasisCurves "x" {}', "prim-unsupported"),
        ('def Points "x" {}', "prim-unsupported"),
        ('def Volume "x" {}', "prim-unsupported"),
        ('def NurbsPatch "x" {}', "prim-unsupported"),
        ('def TetMesh "x" {}', "prim-unsupported"),
        ('def GeometryLight "x" {}', "prim-unsupported"),
        ('def Mesh "x" (prepend apiSchemas = ["MeshLightAPI"]) {}', "prim-unsupported"),
        ('def Mesh "x" { int[] primvars:skel:jointIndices = [0] }', "skinning-unsupported"),
        ('def SphereLight "x" { rel light:filters = </f> } def LightFilter "f" {}', "light-filter-unsupported"),
        ('def Mesh "x" { int[] points = [1] }', "attribute-bad-type"),
        ('def PointInstancer "x" {}', "point-instancer-empty"),
    ],
)
def test_what_is_not_translated_is_said_once(translated, prim, code):
    _, diagnostics = translated(prim)
    assert [(d.code, d.location.startswith("/x")) for d in diagnostics] == [(code, True)]


def test_a_prim_that_fails_does_not_stop_the_rest(translated, monkeypatch):
    from hdwavefront.stage_adapters import traversal

    def broken(translation, rprim):
        raise ZeroDivisionError("oh")

    monkeypatch.setitem(traversal.RPRIM_ADAPTERS, "Sphere", broken)
    delegate, diagnostics = translated('def Sphere "s" {}\ndef Cube "c" {}')
    assert set(delegate.told) == {"/c"}
    assert [(d.code, d.location, d.severity) for d in diagnostics] == [("prim-failed", "/s", "error")]


def test_deep_hierarchies_do_not_end_the_stack(translated):
    depth = 1500
    from pxr import Sdf

    layer = Sdf.Layer.CreateAnonymous(".usda")
    path = Sdf.Path.absoluteRootPath
    for _ in range(depth):
        path = path.AppendChild("x")
        spec = Sdf.CreatePrimInLayer(layer, path)
        spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
    spec = Sdf.CreatePrimInLayer(layer, path.AppendChild("c"))
    spec.specifier, spec.typeName = Sdf.SpecifierDef, "Cube"
    delegate, _ = translated(layer.ExportToString().removeprefix("#usda 1.0"))
    assert len(delegate.told) == 1


def test_every_third_party_stage_is_translated(assets):
    """No prim fails, and every call fits the native module's signature."""
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd
    from recording import RecordingDelegate

    count = 0
    for path in sorted(p for p in assets.rglob("*") if p.suffix in (".usd", ".usda", ".usdc", ".usdz")):
        diagnostics = Diagnostics()
        stage = open_stage(str(path), diagnostics)
        translate(stage, Options(time=Usd.TimeCode(stage.GetStartTimeCode())), RecordingDelegate(), diagnostics)
        assert "prim-failed" not in diagnostics.codes(), (path, [str(d) for d in diagnostics])
        count += 1
    assert count > 200
