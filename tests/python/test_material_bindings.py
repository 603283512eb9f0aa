# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Which material a prim gets: by purpose, strength and collection, as UsdShade says."""

from __future__ import annotations

import pytest

MATERIALS = "".join(
    f"""def Material "{name}" {{
    token outputs:surface.connect = </{name}/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
    }}
}}
"""
    for name in ("red", "green", "blue")
)
BINDING = '(apiSchemas = ["MaterialBindingAPI"])'


@pytest.fixture
def bound(translated):
    """Material by name of each cube and subset, and the diagnostics."""

    def run(text, **options):
        delegate, diagnostics = translated(MATERIALS + text, **options)
        cubes = {path.rsplit("/", 1)[1]: delegate.told[path]["material"] for path in delegate.named("implicit")}
        return {name: material.removeprefix("/") for name, material in cubes.items()}, diagnostics

    return run


def cube(name, *lines, metadata=BINDING):
    return f'def Cube "{name}" {metadata} {{\n' + "\n".join(lines) + "\n}\n"


PURPOSES = cube(
    "all", "rel material:binding = </red>", "rel material:binding:full = </green>",
    "rel material:binding:preview = </blue>"
) + cube("one", "rel material:binding:preview = </blue>") + cube("two", "rel material:binding = </red>")  # fmt: skip


@pytest.mark.parametrize(
    ("purpose", "expected"),
    [
        ("full", {"all": "green", "one": "", "two": "red"}),
        ("preview", {"all": "blue", "one": "blue", "two": "red"}),
        ("", {"all": "red", "one": "", "two": "red"}),
    ],
)
def test_the_purpose_comes_before_the_general_binding(bound, purpose, expected):
    assert bound(PURPOSES, material_purpose=purpose)[0] == expected


@pytest.mark.parametrize(("strength", "expected"), [("weaker", "green"), ("stronger", "red")])
def test_a_binding_above_wins_where_it_is_stronger_than_descendants(bound, strength, expected):
    how = f'(bindMaterialAs = "{strength}ThanDescendants")'
    child = cube("c", "rel material:binding = </green>") + cube("d")
    text = f'def Xform "x" {BINDING} {{\nrel material:binding = </red> {how}\n{child}}}\n'
    assert bound(text)[0] == {"c": expected, "d": "red"}


def test_a_purpose_above_is_weaker_than_a_general_binding_below_only_for_other_purposes(bound):
    child = cube("c", "rel material:binding = </green>")
    text = f'def Xform "x" {BINDING} {{\nrel material:binding:full = </red>\n{child}}}\n'
    assert bound(text)[0] == {"c": "red"}  # the restricted purpose is looked for on all ancestors first
    assert bound(text, material_purpose="preview")[0] == {"c": "green"}


def group(collection, *inner, extra=()):
    """An Xform "x" with the collection "k", bound to red, and cubes a, b and c (below the Xform "y")."""
    lines = [
        "rel material:binding:collection:k = [</x.collection:k>, </red>]",
        *(f"{kind} collection:k:{name} = {what}" for kind, name, what in collection),
        *extra,
    ]
    cubes = cube("a") + cube("b", *inner) + 'def Xform "y" {\n' + cube("c") + "}\n"
    api = '(apiSchemas = ["MaterialBindingAPI", "CollectionAPI:k"])'
    return f'def Xform "x" {api} {{\n' + "\n".join(lines) + f"\n{cubes}}}\n"


@pytest.mark.parametrize(
    ("collection", "expected"),
    [
        ([("rel", "includes", "[</x/a>, </x/y>]")], "ac"),
        ([("rel", "includes", "</x>"), ("rel", "excludes", "</x/y>")], "ab"),
        ([("uniform bool", "includeRoot", "true")], "abc"),
        ([("uniform bool", "includeRoot", "true"), ("rel", "excludes", "[</x/a>]")], "bc"),
        ([("rel", "includes", "[</x/y>]"), ("uniform token", "expansionRule", '"explicitOnly"')], ""),
        ([("rel", "includes", "[</x/y/c>]"), ("uniform token", "expansionRule", '"explicitOnly"')], "c"),
        ([("uniform pathExpression", "membershipExpression", '"/x/[a] /x/y//"')], "ac"),
        ([("uniform pathExpression", "membershipExpression", '"/x// - /x/b"')], "ac"),
    ],
)
def test_collections_bind_their_members(bound, collection, expected):
    found, _ = bound(group(collection))
    assert "".join(name for name, material in found.items() if material == "red") == expected


def test_collections_win_over_the_direct_binding_of_the_same_prim_only(bound):
    text = group(
        [("rel", "includes", "</x>")], "rel material:binding = </green>", extra=["rel material:binding = </blue>"]
    )
    assert bound(text)[0] == {"a": "red", "b": "green", "c": "red"}


def test_the_first_collection_that_holds_a_prim_counts(bound):
    extra = [
        "rel collection:l:includes = </x/a>",
        "rel material:binding:collection:j = [</x.collection:l>, </blue>]",
        'reorder properties = ["material:binding:collection:k", "material:binding:collection:j"]',
    ]
    text = group([("rel", "includes", "</x>")], extra=extra)
    text = text.replace('"CollectionAPI:k"', '"CollectionAPI:k", "CollectionAPI:l"')
    assert bound(text)[0]["a"] == "red"
    assert (
        bound(
            text.replace('reorder properties = ["material:binding:collection:k", "material:binding:collection:j"]', "")
        )[0]["a"]
        == "blue"
    )


@pytest.mark.parametrize(
    "relation",
    ["material:binding", "material:binding:full"],
)
def test_bindings_to_nothing_are_said_where_they_stand(bound, relation):
    text = f'def Xform "x" {BINDING} {{\nrel {relation} = </nobody>\n{cube("a")}{cube("b")}}}\n'
    found, diagnostics = bound(text)
    assert set(found.values()) == {""}
    assert [(d.code, d.location) for d in diagnostics] == [("material-missing", "/x")]


def test_collection_bindings_to_nothing_are_said(bound):
    text = group([("rel", "includes", "</x>")]).replace("</red>]", "</nobody>]")
    found, diagnostics = bound(text)
    assert set(found.values()) == {""}
    assert [(d.code, d.location) for d in diagnostics] == [("material-missing", "/x")]
