# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Blender add-on: renders with the Hydra plugin hdWavefront, in the viewport and to files.

Needs Blender 4.2 or later and an hdWavefront that was built for the OpenUSD inside of it. The plugin is found through
the add-on's preference or the environment variable HDWAVEFRONT_HYDRA, which name the folder of plugInfo.json, else
beside this file, as it is installed. The render settings are those of the plugin's settings.json: none of them is
spelled here.
"""

from __future__ import annotations

import json
import os
from typing import Any

import bpy

bl_info = {
    "name": "hdWavefront",
    "description": "Queue-based wavefront path tracer as a Hydra render delegate",
    "author": "the hdWavefront authors",
    "version": (0, 1, 0),
    "blender": (4, 2, 0),
    "location": "Render Properties > Render Engine",
    "category": "Render",
}

ENGINE = "HYDRA_WAVEFRONT"
DELEGATE = "HdWavefrontRendererPlugin"
# The viewport has its own number of samples; the others are the same in both.
VIEWPORT_SAMPLES = "viewportSamples"
# What Blender itself decides, or what only a farm needs.
HIDDEN = frozenset({"enableInteractive", "convergedSamplesPerPixel", "firstSample"})


def plugin_folder() -> str | None:
    """The folder that holds plugInfo.json; None where it cannot be found."""
    here = os.path.dirname(os.path.abspath(__file__))
    addon = bpy.context.preferences.addons.get(__name__)
    wished = addon.preferences.plugin_folder if addon else ""
    for folder in (wished, os.environ.get("HDWAVEFRONT_HYDRA", ""), os.path.dirname(here), here):
        if folder and os.path.isfile(os.path.join(folder, "plugInfo.json")):
            return os.path.abspath(folder)
    return None


def read_settings() -> list[dict[str, Any]]:
    """Rows of settings.json: token, type (Int, Float, Bool, Token), default, minimum, maximum, doc."""
    folder = plugin_folder()
    if folder is None:
        return []
    with open(os.path.join(folder, "settings.json"), encoding="utf-8") as file:
        return [row for row in json.load(file) if row["token"] not in HIDDEN]


def label_of(token: str) -> str:
    """maxBounces -> Max Bounces"""
    words = "".join(" " + c if c.isupper() else c for c in token)
    return words[:1].upper() + words[1:]


def make_property(row: dict[str, Any]) -> Any:
    # Blender keeps numbers in 32 bits.
    limit = float(2**31 - 1)
    common = {"name": label_of(row["token"]), "description": row["doc"]}
    if row["type"] == "Bool":
        return bpy.props.BoolProperty(default=bool(row["default"]), **common)
    if row["type"] == "Token":
        choices = [(choice, label_of(choice), "") for choice in row["minimum"].split("|")]
        return bpy.props.EnumProperty(items=choices, default=row["default"], **common)
    if row["type"] == "Int":
        return bpy.props.IntProperty(
            default=int(row["default"]), min=int(row["minimum"]), max=int(min(row["maximum"], limit)), **common
        )
    return bpy.props.FloatProperty(
        default=row["default"], min=row["minimum"], max=min(row["maximum"], 3e38), precision=3, **common
    )


def make_properties(rows: list[dict[str, Any]]) -> type:
    """A property group with one property a row."""
    annotations = {row["token"]: make_property(row) for row in rows}
    annotations[VIEWPORT_SAMPLES] = bpy.props.IntProperty(
        name="Viewport Samples", description="samples per pixel in the viewport", default=32, min=1, max=1 << 24
    )
    return type("WavefrontSettings", (bpy.types.PropertyGroup,), {"__annotations__": annotations})


class WavefrontPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__

    plugin_folder: bpy.props.StringProperty(  # type: ignore[valid-type]
        name="Plugin", subtype="DIR_PATH", description="folder of hdWavefront's plugInfo.json; takes a restart"
    )

    def draw(self, context: Any) -> None:
        self.layout.prop(self, "plugin_folder")
        if plugin_folder() is None:
            self.layout.label(text="No plugInfo.json is found: name its folder", icon="ERROR")


class WavefrontRenderEngine(bpy.types.HydraRenderEngine):
    bl_idname = ENGINE
    bl_label = "Wavefront"
    bl_use_preview = True
    bl_use_gpu_context = False  # the plugin brings its own Vulkan device
    bl_use_materialx = True  # Principled arrives as MaterialX where Blender has it, else as UsdPreviewSurface
    bl_delegate_id = DELEGATE

    @classmethod
    def register(cls) -> None:
        folder = plugin_folder()
        if folder is None:
            print("hdWavefront: no plugInfo.json is found; see the add-on's preferences")
            return
        from pxr import Plug

        Plug.Registry().RegisterPlugins([folder])

    def get_render_settings(self, engine_type: str) -> dict[str, Any]:
        settings = bpy.context.scene.hdwavefront
        viewport = engine_type == "VIEWPORT"
        result: dict[str, Any] = {
            # Blender does its own colour management: it wants the colour AOV scene-linear.
            f"wavefront:{row['token']}": getattr(settings, row["token"])
            for row in read_settings()
        }
        if viewport:
            result["wavefront:samples"] = settings.viewportSamples
        result["wavefront:enableInteractive"] = viewport
        if engine_type != "VIEWPORT":
            result["aovToken:Combined"] = "color"
            result["aovToken:Depth"] = "depth"
        return result

    def update_render_passes(self, scene: Any, render_layer: Any) -> None:
        if render_layer.use_pass_combined:
            self.register_pass(scene, render_layer, "Combined", 4, "RGBA", "COLOR")
        if render_layer.use_pass_z:
            self.register_pass(scene, render_layer, "Depth", 1, "Z", "VALUE")


class WavefrontSamplingPanel(bpy.types.Panel):
    bl_idname = "RENDER_PT_hdwavefront"
    bl_label = "Wavefront"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012 (Blender's own name and type)

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        settings = context.scene.hdwavefront
        if plugin_folder() is None:
            layout.label(text="The plugin is not found: see the add-on's preferences", icon="ERROR")
        layout.prop(settings, VIEWPORT_SAMPLES)
        for row in read_settings():
            layout.prop(settings, row["token"])


def shared_panels() -> list[Any]:
    """Blender's own panels that mean something here: what any render engine shows, less what has no counterpart."""
    without = ("freestyle", "simplify", "gpencil", "eevee", "shadow", "ambient_occlusion", "motion_blur")
    return [
        panel
        for panel in bpy.types.Panel.__subclasses__()
        if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())
        and not any(word in panel.__name__.lower() for word in without)
    ]


_registered: list[type] = []


def register() -> None:
    bpy.utils.register_class(WavefrontPreferences)
    settings = make_properties(read_settings())
    _registered[:] = [WavefrontPreferences]
    for cls in (settings, WavefrontRenderEngine, WavefrontSamplingPanel):
        bpy.utils.register_class(cls)
        _registered.append(cls)
    bpy.types.Scene.hdwavefront = bpy.props.PointerProperty(type=settings)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    del bpy.types.Scene.hdwavefront
    for cls in reversed(_registered):
        bpy.utils.unregister_class(cls)
    _registered.clear()


if __name__ == "__main__":
    register()
