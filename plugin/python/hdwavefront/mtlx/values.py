# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""MaterialX types and values as USD has them."""

from __future__ import annotations

import math
from typing import Any

from pxr import Gf, Sdf

_NAMES = Sdf.ValueTypeNames
TYPES = {
    "float": _NAMES.Float,
    "integer": _NAMES.Int,
    "boolean": _NAMES.Bool,
    "string": _NAMES.String,
    "geomname": _NAMES.String,
    "filename": _NAMES.Asset,
    "color3": _NAMES.Color3f,
    "color4": _NAMES.Color4f,
    "vector2": _NAMES.Float2,
    "vector3": _NAMES.Float3,
    "vector4": _NAMES.Float4,
    "matrix33": _NAMES.Matrix3d,
    "matrix44": _NAMES.Matrix4d,
}
# Closures and shaders have no values, only connections.
OPAQUE_TYPE = _NAMES.Token

_MAKERS: dict[str, tuple[int, Any]] = {
    "float": (1, float),
    "color3": (3, Gf.Vec3f),
    "color4": (4, Gf.Vec4f),
    "vector2": (2, Gf.Vec2f),
    "vector3": (3, Gf.Vec3f),
    "vector4": (4, Gf.Vec4f),
    "matrix33": (9, Gf.Matrix3d),
    "matrix44": (16, Gf.Matrix4d),
}


def usd_value(kind: str, text: str) -> Any:
    """The value of a text; None where the text is no value of the type."""
    if kind in ("string", "geomname"):
        return text
    if kind == "filename":
        return Sdf.AssetPath(text) if text.isprintable() else None
    if kind == "boolean":
        return {"true": True, "false": False}.get(text.strip().lower())
    try:
        if kind == "integer":
            number = int(text.strip())
            return number if -(2**31) <= number < 2**31 else None
        numbers = [float(x) for x in text.replace(",", " ").split()]
    except ValueError:
        return None
    if kind not in _MAKERS or len(numbers) != _MAKERS[kind][0] or not all(map(math.isfinite, numbers)):
        return None
    return _MAKERS[kind][1](*numbers)
