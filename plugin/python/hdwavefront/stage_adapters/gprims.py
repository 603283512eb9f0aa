# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Sphere, Cube, Cone, Cylinder, Capsule and Plane: their attributes; the delegate makes the triangles."""

from __future__ import annotations

from pxr import UsdGeom

from .context import Rprim, Translation, Update, common_fields, schema_type
from .primvars import gprim_primvars
from .unsupported import report_skinning

# Attribute name -> name in the update, by schema type. Cylinder_1 and Capsule_1 have two radii.
_ATTRIBUTES: dict[str, tuple[str, dict[str, str]]] = {
    "Sphere": ("Sphere", {"radius": "radius"}),
    "Cube": ("Cube", {"size": "size"}),
    "Cone": ("Cone", {"radius": "radius", "height": "height", "axis": "axis"}),
    "Cylinder": ("Cylinder", {"radius": "radius", "height": "height", "axis": "axis"}),
    "Cylinder_1": (
        "Cylinder",
        {"radiusTop": "radiusTop", "radiusBottom": "radiusBottom", "height": "height", "axis": "axis"},
    ),
    "Capsule": ("Capsule", {"radius": "radius", "height": "height", "axis": "axis"}),
    "Capsule_1": (
        "Capsule",
        {"radiusTop": "radiusTop", "radiusBottom": "radiusBottom", "height": "height", "axis": "axis"},
    ),
    "Plane": ("Plane", {"width": "width", "length": "length", "axis": "axis"}),
}

IMPLICIT_TYPES = tuple(_ATTRIBUTES)


def emit_implicit(translation: Translation, rprim: Rprim) -> None:
    prim = rprim.prim
    shape_name, attributes = _ATTRIBUTES[schema_type(prim)]
    report_skinning(translation, rprim)
    shape: Update = {"type": shape_name}
    for name, field in attributes.items():
        value = prim.GetAttribute(name).Get(translation.time)
        if value is not None:
            shape[field] = str(value) if field == "axis" else float(value)
    update = common_fields(rprim, gprim_primvars(translation, rprim))
    update["double_sided"] = bool(UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(translation.time))
    update["shape"] = shape
    translation.sink.sync_implicit(rprim.path, **update)
