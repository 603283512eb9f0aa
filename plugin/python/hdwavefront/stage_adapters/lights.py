# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdLux lights: raw inputs. Formulas, units and shaping are the delegate's."""

from __future__ import annotations

from typing import Any

from pxr import Usd, UsdGeom, UsdLux

from .assets import asset_value
from .colors import rendering_color
from .context import PrimContext, Translation, Update, matrix_array, schema_type

LIGHT_TYPES = {
    "RectLight": "RectLight",
    "DiskLight": "DiskLight",
    "SphereLight": "SphereLight",
    "CylinderLight": "CylinderLight",
    "DistantLight": "DistantLight",
    "DomeLight": "DomeLight",
    "DomeLight_1": "DomeLight",
}

_FLOATS = (
    "intensity",
    "exposure",
    "colorTemperature",
    "diffuse",
    "specular",
    "width",
    "height",
    "radius",
    "length",
    "angle",
)
# UsdLux has no word on whether the camera sees a light, and stages say it by their renderers' names. Seen unless one of
# these is authored and false; the first one found counts.
_CAMERA_VISIBILITY = (
    "inputs:visibility:camera",
    "primvars:arnold:visibility:camera",
    "primvars:arnold:camera",
    "primvars:ri:attributes:visibility:camera",
)
_SHAPING_FLOATS = ("shaping:cone:angle", "shaping:cone:softness", "shaping:focus")


def _input(prim: Usd.Prim, name: str, time: Usd.TimeCode) -> Any:
    attribute = prim.GetAttribute("inputs:" + name)
    return attribute.Get(time) if attribute else None


def _color(translation: Translation, prim: Usd.Prim, name: str) -> tuple[float, float, float] | None:
    attribute = prim.GetAttribute("inputs:" + name)
    value = attribute.Get(translation.time) if attribute else None
    if value is None:
        return None
    return rendering_color(translation, tuple(map(float, value)), attribute)


def _shaping(translation: Translation, prim: Usd.Prim) -> Update:
    if not prim.HasAPI(UsdLux.ShapingAPI) and not any(
        n.startswith("inputs:shaping:") for n in prim.GetAuthoredPropertyNames()
    ):
        return {}
    params: Update = {}
    for name in _SHAPING_FLOATS:
        value = _input(prim, name, translation.time)
        if value is not None:
            params[name] = float(value)
    tint = _color(translation, prim, "shaping:focusTint")
    if tint is not None:
        params["shaping:focusTint"] = tint
    ies = _input(prim, "shaping:ies:file", translation.time)
    if ies and ies.path:
        params["shaping:ies:file"] = ies.path
    # Said even if all values are the fallbacks: the API's fallback cone angle of 90 degrees counts where it is applied.
    params.setdefault("shaping:cone:angle", 90.0)
    return params


# ShadowAPI's ways out of physics -> the value that changes nothing.
_SHADOW_NEUTRAL: dict[str, Any] = {"shadow:color": (0, 0, 0), "shadow:distance": -1, "shadow:falloff": -1}


def _report_unsupported(translation: Translation, prim: Usd.Prim, path: str) -> None:
    warn = translation.diagnostics.warning
    for name, neutral in _SHADOW_NEUTRAL.items():
        value = _input(prim, name, translation.time)
        if value is not None and value != neutral:
            warn("light-unsupported-input", path, f"inputs:{name} is not supported; shadows are as light casts them")
    for api, code, what in (("link", "light-link", "light linking"), ("shadow:link", "shadow-link", "shadow linking")):
        names = [str(n) for n in prim.GetAuthoredPropertyNames()]
        prefixes = [
            f"collection:{'lightLink' if api == 'link' else 'shadowLink'}:{end}" for end in ("includes", "excludes")
        ]
        if any(p in names and prim.GetRelationship(p).GetTargets() for p in prefixes):
            warn(code + "-unsupported", path, f"{what} is not rendered yet; the light acts on everything")
    filters = prim.GetRelationship("light:filters")
    if filters and filters.GetForwardedTargets():
        warn("light-filter-unsupported", path, "light filters are not rendered yet; they are ignored")
    portals = prim.GetRelationship("portals")
    if portals and portals.GetForwardedTargets():
        warn("light-portal-unsupported", path, "portals are not used; the dome is sampled by its own importance")


def light_params(translation: Translation, prim: Usd.Prim, path: str) -> Update:
    time = translation.time
    type_name = schema_type(prim)
    params: Update = {"type": LIGHT_TYPES[type_name]}
    for name in _FLOATS:
        value = _input(prim, name, time)
        if value is not None:
            params[name] = float(value)
    for name in ("enableColorTemperature", "normalize"):
        value = _input(prim, name, time)
        if value is not None:
            params[name] = bool(value)
    color = _color(translation, prim, "color")
    if color is not None:
        params["color"] = color
    for name in ("treatAsPoint", "treatAsLine"):
        attribute = prim.GetAttribute(name)
        if attribute:
            params[name] = bool(attribute.Get(time))
    texture = prim.GetAttribute("inputs:texture:file")
    if texture:
        value = asset_value(texture, time)
        if value is not None:
            params["texture:file"] = value
        format_token = _input(prim, "texture:format", time)
        if format_token:
            params["texture:format"] = str(format_token)
    shadow = _input(prim, "shadow:enable", time)
    if shadow is not None:
        params["shadow:enable"] = bool(shadow)
    for name in _CAMERA_VISIBILITY:
        attribute = prim.GetAttribute(name)
        value = attribute.Get(time) if attribute else None
        if isinstance(value, (bool, int, float)):
            params["visibleToCamera"] = bool(value)
            break
    if type_name.startswith("DomeLight"):
        params["poleAxis"] = _pole_axis(prim, type_name)
    params.update(_shaping(translation, prim))
    _report_unsupported(translation, prim, path)
    return params


def _pole_axis(prim: Usd.Prim, type_name: str) -> str:
    """DomeLight's pole is Y in its own space; DomeLight_1 says which, and "scene" is the stage's up axis."""
    if type_name != "DomeLight_1":
        return "Y"
    axis = str(prim.GetAttribute("poleAxis").Get() or "scene")
    if axis == "scene":
        return "Z" if UsdGeom.GetStageUpAxis(prim.GetStage()) == UsdGeom.Tokens.z else "Y"
    return axis


def emit_light(translation: Translation, prim: Usd.Prim, context: PrimContext, path: str) -> None:
    update: Update = {
        "params": light_params(translation, prim, path),
        "transform": matrix_array(context.transform),
        "visible": True,
    }
    if context.instancer:
        update["instancer"] = context.instancer
        update["prototype"] = context.prototype
    translation.light_count += 1
    translation.sink.sync_light(path, **update)


CAMERA_LIGHT_PATH = "/__hdwavefront_camera_light"


def emit_camera_light(translation: Translation, camera_transform: Any) -> None:
    """A distant light along the viewing direction, of the strength that a white surface facing it returns white."""
    params = {"type": "DistantLight", "intensity": 1.0, "angle": 0.53, "normalize": True, "color": (1.0, 1.0, 1.0)}
    # Irradiance pi on a facing surface gives radiance = albedo. Normalised, intensity is the irradiance.
    params["intensity"] = 3.14159265
    translation.sink.sync_light(CAMERA_LIGHT_PATH, params=params, transform=camera_transform, visible=True)
