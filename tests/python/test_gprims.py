# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Sphere, Cube, Cone, Cylinder, Capsule and Plane: each schema's attributes reach the delegate by name."""

from __future__ import annotations

import pytest

ROUND = {"radius": "3", "height": "5", "axis": '"X"'}
TWO_RADII = {"radiusTop": "3", "radiusBottom": "4", "height": "5", "axis": '"Y"'}


@pytest.mark.parametrize(
    ("schema", "shape", "attributes"),
    [
        ("Sphere", "Sphere", {"radius": "3"}),
        ("Cube", "Cube", {"size": "3"}),
        ("Cone", "Cone", ROUND),
        ("Cylinder", "Cylinder", ROUND),
        ("Capsule", "Capsule", ROUND),
        ("Cylinder_1", "Cylinder", TWO_RADII),
        ("Capsule_1", "Capsule", TWO_RADII),
        ("Plane", "Plane", {"width": "3", "length": "4", "axis": '"X"'}),
    ],
)
def test_every_attribute_arrives(translated, schema, shape, attributes):
    lines = "; ".join(f"{'token' if n == 'axis' else 'double'} {n} = {v}" for n, v in attributes.items())
    delegate, diagnostics = translated(f'def {schema} "s" {{ {lines} }}')
    expected = {n: v.strip('"') if n == "axis" else float(v) for n, v in attributes.items()}
    assert delegate.told["/s"]["shape"] == {"type": shape, **expected}
    assert not list(diagnostics)


@pytest.mark.parametrize(
    ("schema", "fallbacks"),
    [
        ("Sphere", {"radius": 1}),
        ("Cube", {"size": 2}),
        ("Cone", {"radius": 1, "height": 2, "axis": "Z"}),
        ("Cylinder", {"radius": 1, "height": 2, "axis": "Z"}),
        ("Capsule", {"radius": 0.5, "height": 1, "axis": "Z"}),
        ("Cylinder_1", {"radiusTop": 1, "radiusBottom": 1, "height": 2, "axis": "Z"}),
        ("Capsule_1", {"radiusTop": 0.5, "radiusBottom": 0.5, "height": 1, "axis": "Z"}),
        ("Plane", {"width": 2, "length": 2, "axis": "Z"}),
    ],
)
def test_fallbacks_are_the_schemas(translated, schema, fallbacks):
    shape = dict(translated(f'def {schema} "s" {{}}')[0].told["/s"]["shape"])
    del shape["type"]
    assert shape == fallbacks


def test_primvars_come_along(translated):
    delegate, _ = translated('def Cube "s" { color3f[] primvars:displayColor = [(1, 0, 0)] }')
    assert [p[0] for p in delegate.told["/s"]["primvars"]] == ["displayColor"]


@pytest.mark.parametrize("value", [0, 1])
@pytest.mark.parametrize("schema", ["Cube", "Plane", "Mesh"])
def test_double_sided(translated, schema, value):
    delegate, _ = translated(f'def {schema} "s" {{ uniform bool doubleSided = {value} }}')
    assert delegate.told["/s"]["double_sided"] is bool(value)


@pytest.mark.parametrize(("schema", "fallback"), [("Cube", False), ("Plane", True), ("Mesh", False)])
def test_double_sided_where_nothing_is_said(translated, schema, fallback):
    assert translated(f'def {schema} "s" {{}}')[0].told["/s"]["double_sided"] is fallback
