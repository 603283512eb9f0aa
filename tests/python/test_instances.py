# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""PointInstancers and native instances."""

from __future__ import annotations

import pytest
from usda import MATERIALS, QUAD, primvars_of, said, translation_of

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
    assert {c: delegate.told[c].get("instancer", "") for c in cubes} == {
        "/protos/cube": "",
        "/outer/inner.prototype0/protos/cube": "/outer/inner",
        "/other.prototype0/protos/cube": "/other",
    }


def test_a_point_instancer_that_holds_itself_ends(translated):
    delegate, diagnostics = translated(
        """
def PointInstancer "pi" {
    int[] protoIndices = [0]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = [</pi>]
}"""
    )
    assert said(diagnostics) == [("point-instancer-cycle", "/pi")] and list(delegate.told) == ["/pi"]


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


def test_instances_that_inherit_other_materials_are_apart(translated):
    red = "rel material:binding = </red>"
    both = f"{red}\n    rel material:binding:full = </blue>"
    groups = "".join(
        f'def Xform "{name}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{\n    {lines}\n{instance("i", 1)}}}\n'
        for name, lines in (("r", red), ("b", both))
    )
    delegate, _ = translated(MATERIALS + INSTANCES + groups)
    worn = {delegate.told[c].get("instancer"): delegate.told[c]["material"] for c in delegate.named("implicit")}
    assert worn == {None: "", "/r/i.instances": "/red", "/b/i.instances": "/blue"}


def test_instances_of_different_purposes_are_apart(translated):
    both = frozenset({"default", "render", "proxy"})
    delegate, _ = translated(
        INSTANCES
        + instance("i", 1, 'uniform token purpose = "render"')
        + instance("j", 2, 'uniform token purpose = "proxy"'),
        purposes=both,
    )
    assert {delegate.told[c]["render_tag"] for c in delegate.named("implicit")} == {"geometry", "render", "proxy"}


def test_primvars_of_instances_that_cannot_be_split(translated):
    """Arrays of several values, or of unlike lengths, and other renderers' settings: those of the first count."""
    colors = "color3f[] primvars:displayColor = [{}]"
    several = [instance("i", 1, colors.format("(1, 0, 0), (0, 1, 0)")), instance("j", 2, colors.format("(0, 0, 1)"))]
    delegate, diagnostics = translated(INSTANCES + "".join(several))
    (instancer,) = delegate.named("instancer")
    assert delegate.told[instancer]["primvars"] == []
    assert primvars_of(delegate.told["/i/c"])["displayColor"][2].shape == (2, 3)
    assert said(diagnostics) == [("instance-primvar-unsupported", "/j.primvars:displayColor")]
    other = [instance(n, x, f"float[] primvars:arnold:x = [{x}]") for n, x in (("i", 1), ("j", 2))]
    delegate, diagnostics = translated(INSTANCES + "".join(other))
    assert delegate.told[delegate.named("instancer")[0]]["primvars"] == [] and not list(diagnostics)
    matrices = "matrix4d primvars:m = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, {}))"
    large = [instance(n, x, matrices.format(x)) for n, x in (("i", 1), ("j", 2))]
    delegate, _ = translated(INSTANCES + "".join(large))
    assert delegate.told[delegate.named("instancer")[0]]["primvars"] == []


def test_single_values_of_instances_are_split_and_hide_no_own_value(translated):
    source = INSTANCES.replace(
        'def Cube "c" {', 'def Sphere "own" { color3f[] primvars:displayColor = [(1, 1, 1)] }\n    def Cube "c" {'
    )
    values = [instance(n, x, f"color3f primvars:displayColor = ({x}, 0, 0)") for n, x in (("i", 1), ("j", 2))]
    delegate, _ = translated(source + "".join(values))
    ((name, interpolation, colors, indices),) = delegate.told[delegate.named("instancer")[0]]["primvars"]
    assert (name, interpolation, indices) == ("displayColor", "instance", None)
    assert colors.tolist() == [[1, 0, 0], [2, 0, 0]]
    assert "displayColor" not in primvars_of(delegate.told["/i/c"])
    assert primvars_of(delegate.told["/i/own"])["displayColor"][2].tolist() == [[1, 1, 1]]


def test_instances_draw_what_is_defined_only(translated):
    source = 'def Xform "source" { def Cube "c" {}; over "o" { def Cube "c" {} }; class "k" { def Cube "c" {} } }\n'
    delegate, _ = translated(source.replace("}; ", "}\n") + instance("i", 1))
    assert delegate.named("implicit") == ["/source/c", "/i/c"]


NESTED = """
def PointInstancer "outer" {
    int[] protoIndices = [1]
    point3f[] positions = [(0, 0, 0)]
    rel prototypes = [</outer/cube>, </outer/inner>, </outer/lamps>]
    def Cube "cube" {}
    def PointInstancer "inner" {
        int[] protoIndices = [0]
        point3f[] positions = [(0, 0, 0)]
        rel prototypes = [</outer/inner/ball>]
        def Sphere "ball" {}
    }
    def Xform "lamps" ( instanceable = true; prepend references = </source> ) {}
}
"""


def test_the_place_in_the_outer_instancer_is_told(translated):
    delegate, _ = translated(INSTANCES + NESTED.replace("[1]", "[1, 2]").replace("[(0, 0, 0)]", "[(0, 0, 0)]", 1))
    assert (delegate.told["/outer/inner"]["parent"], delegate.told["/outer/inner"]["parent_prototype"]) == ("/outer", 1)
    lamps = delegate.told["/outer/lamps.instances"]
    assert (lamps["parent"], lamps["parent_prototype"]) == ("/outer", 2)
    assert "/outer/cube" not in delegate.told  # no instance draws it


def test_arrays_of_point_instancers_are_those_of_the_frame(translated):
    delegate, _ = translated(
        """def PointInstancer "pi" {
    int[] protoIndices.timeSamples = { 1: [0], 2: [0, 0] }
    point3f[] positions.timeSamples = { 1: [(0, 0, 0)], 2: [(1, 0, 0), (2, 0, 0)] }
    quath[] orientations.timeSamples = { 1: [(1, 0, 0, 0)], 2: [(0, 1, 0, 0), (0, 1, 0, 0)] }
    float3[] scales.timeSamples = { 1: [(1, 1, 1)], 2: [(2, 2, 2), (3, 3, 3)] }
    int64[] ids.timeSamples = { 1: [1], 2: [5, 6] }
    int64[] invisibleIds.timeSamples = { 1: [], 2: [6] }
    rel prototypes = [</pi/a>]
    def Cube "a" {}
}""",
        time=2,
    )
    told = delegate.told["/pi"]
    assert told["positions"].tolist() == [[1, 0, 0], [2, 0, 0]] and told["scales"].tolist() == [[2] * 3, [3] * 3]
    assert told["orientations"].tolist() == [[1, 0, 0, 0]] * 2 and list(told["ids"]) == [5, 6]
    assert list(told["invisible_ids"]) == [6] and list(told["proto_indices"]) == [0, 0]


def test_float_orientations_win(translated):
    delegate, _ = translated(
        f"""def PointInstancer "pi" {{ {POINTS}
    quath[] orientations = [(1, 0, 0, 0), (1, 0, 0, 0), (1, 0, 0, 0)]
    quatf[] orientationsf = [(0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]
    rel prototypes = [</pi/a>, </pi/b>]
    def Cube "a" {{}}
    def Cube "b" {{}}
}}"""
    )
    assert delegate.told["/pi"]["orientations"].tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]


@pytest.mark.parametrize(
    ("lines", "expected", "drawn"),
    [
        ("rel prototypes = [</pi/a>]", "point-instancer-bad-index", ["/pi/a"]),
        ("rel prototypes = [</pi/a>, </nowhere>]", "point-instancer-bad-prototype", ["/pi/a"]),
        ("rel prototypes = []", "point-instancer-empty", []),
        ("rel prototypes = [</pi/a>, </pi/off>]", None, ["/pi/a"]),
        ("rel prototypes = [</pi/a>, </pi/b>]", None, ["/pi/a", "/pi/b"]),
    ],
)
def test_prototypes_that_are_not_there(translated, lines, expected, drawn):
    delegate, diagnostics = translated(
        f"""def PointInstancer "pi" {{ {POINTS}
    {lines}
    def Cube "a" {{}}
    def Cube "b" {{}}
    def Cube "off" (active = false) {{}}
}}"""
    )
    assert said(diagnostics) == ([(expected, "/pi")] if expected else [])
    assert delegate.named("implicit") == drawn  # in the order of the prototypes


def test_primvars_of_point_instancers(translated):
    """One value an instance goes to the instances, constants are inherited, other renderers' settings are left."""
    delegate, _ = translated(
        f"""def PointInstancer "pi" {{ {POINTS}
    float[] primvars:each = [1, 2, 3] (interpolation = "vertex")
    float[] primvars:all = [1]
    float[] primvars:arnold:each = [1, 2, 3] (interpolation = "vertex")
    rel prototypes = [</pi/a>, </pi/b>]
    def Cube "a" {{}}
    def Cube "b" {{}}
}}"""
    )
    assert [p[0] for p in delegate.told["/pi"]["primvars"]] == ["each"]
    assert list(primvars_of(delegate.told["/pi/a"])) == ["all"]


def test_the_material_of_a_point_instancer_dresses_what_has_none(translated):
    delegate, _ = translated(
        MATERIALS
        + f"""
def PointInstancer "pi" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ {POINTS}
    rel material:binding = </red>
    rel prototypes = [</protos/bare>, </protos/inner>]
}}
over "protos" {{
    def Mesh "bare" {{ {QUAD}
        def GeomSubset "s" {{
            uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [0]
        }}
    }}
    def PointInstancer "inner" {{
        int[] protoIndices = [0]
        point3f[] positions = [(0, 0, 0)]
        rel prototypes = [</protos/dressed>]
    }}
    def Xform "dressed" {{
        def Cube "own" (prepend apiSchemas = ["MaterialBindingAPI"]) {{ rel material:binding = </blue> }}
        def Cube "none" {{}}
    }}
}}
"""
    )
    mesh = delegate.told["/protos/bare"]
    assert mesh["material"] == "/red" and mesh["subset_materials"] == ["/red"]
    assert delegate.told["/protos/dressed/own"]["material"] == "/blue"
    assert delegate.told["/protos/dressed/none"]["material"] == "/red"
    assert set(delegate.named("material")) == {"/red", "/blue"}


def test_purposes_of_prototypes_inside_instances(translated):
    """Their namespace ends at the instance, whose purpose counts."""
    delegate, _ = translated(
        """
def Xform "source" {
    def PointInstancer "pi" {
        int[] protoIndices = [0]
        point3f[] positions = [(0, 0, 0)]
        rel prototypes = [</source/pi/a>]
        def Cube "a" {}
    }
}
def Xform "i" ( instanceable = true; prepend references = </source> ) { uniform token purpose = "proxy" }
"""
    )
    tags = {delegate.told[c]["instancer"]: delegate.told[c]["render_tag"] for c in delegate.named("implicit")}
    assert tags == {"/source/pi": "geometry", "/i/pi": "proxy"}


def test_what_instances_give_hides_what_their_prototype_inherits(translated):
    """A constant on the way down does not; the prim's own value does."""
    inside = """def Xform "way" { color3f[] primvars:displayColor = [(1, 1, 1)]
        def Cube "inherits" {}
        def Cube "own" { color3f[] primvars:displayColor = [(1, 1, 0)] }
    }"""
    delegate, _ = translated(
        f"""
def PointInstancer "pi" {{ {POINTS}
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1)] (interpolation = "vertex")
    rel prototypes = [</pi/a>, </pi/b>]
    def Xform "a" {{ {inside} }}
    def Cube "b" {{}}
}}
def Xform "source" {{ {inside} }}
"""
        + "".join(instance(n, x, f"color3f primvars:displayColor = ({x}, 0, 0)") for n, x in (("i", 1), ("j", 2)))
    )
    for root in ("/pi/a", "/i"):
        assert "displayColor" not in primvars_of(delegate.told[f"{root}/way/inherits"])
        assert "displayColor" in primvars_of(delegate.told[f"{root}/way/own"])
    assert "displayColor" in primvars_of(delegate.told["/source/way/inherits"])
