# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""PointInstancers and native instances."""

from __future__ import annotations

from usda import primvars_of, translation_of

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
