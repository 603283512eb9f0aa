# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdRenderSettings with its products and vars: what it asks for, in plain values. Unknown wishes are diagnosed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pxr import Usd, UsdRender

from ..errors import Diagnostics, HdWavefrontError
from . import PURPOSES, WINDOW_POLICIES

# Names of render vars for our AOVs, ours and those that other renderers and USD's documentation use.
_AOV_NAMES = {
    "color": "color",
    "ci": "color",
    "rgba": "color",
    "rgb": "color",
    "beauty": "color",
    "lpe:c.*[lo]": "color",
    "depth": "depth",
    "cameradepth": "cameraDepth",
    "z": "cameraDepth",
    "normal": "normal",
    "n": "normal",
    "neye": "Neye",
    "albedo": "albedo",
    "primid": "primId",
    "instanceid": "instanceId",
    "elementid": "elementId",
    "samplecount": "sampleCount",
}
_NAMESPACE = "wavefront:"
# What a product may say otherwise than its settings.
_OVERRIDABLE = (
    "resolution",
    "pixelAspectRatio",
    "aspectRatioConformPolicy",
    "dataWindowNDC",
    "disableDepthOfField",
)


@dataclass(frozen=True, slots=True)
class Product:
    path: str
    name: str  # productName as authored
    aovs: tuple[str, ...]


@dataclass(slots=True)
class RenderSettingsPrim:
    """None or empty: nothing authored."""

    path: str = ""
    camera: str = ""
    resolution: tuple[int, int] | None = None
    pixel_aspect_ratio: float | None = None
    window_policy: str = ""
    purposes: frozenset[str] | None = None
    material_purpose: str | None = None
    rendering_space: str = ""
    disable_depth_of_field: bool = False
    products: list[Product] = field(default_factory=list)
    settings: dict[str, Any] = field(default_factory=dict)  # wavefront:<token>


def find_render_settings(stage: Usd.Stage, name: str, diagnostics: Diagnostics) -> UsdRender.Settings | None:
    """The prim at `name`, else the one of the stage's metadata, else none. HdWavefrontError where `name` is none."""
    if name:
        prim = stage.GetPrimAtPath(name) if name.startswith("/") else None
        if not prim or not prim.IsA(UsdRender.Settings):
            known = [str(p.GetPath()) for p in stage.Traverse() if p.IsA(UsdRender.Settings)]
            hint = f" The stage has: {', '.join(known[:8])}." if known else ""
            raise HdWavefrontError(f"There is no RenderSettings prim '{name}' in the stage.{hint}")
        return UsdRender.Settings(prim)
    authored = stage.GetMetadata("renderSettingsPrimPath")
    if not authored:
        return None
    prim = stage.GetPrimAtPath(authored)
    if not prim or not prim.IsA(UsdRender.Settings):
        diagnostics.warning(
            "render-settings-missing",
            authored,
            "the stage's renderSettingsPrimPath names no RenderSettings prim; it is ignored",
        )
        return None
    return UsdRender.Settings(prim)


def settings_of_pass(stage: Usd.Stage, name: str, diagnostics: Diagnostics) -> str:
    """The path of the RenderSettings prim that a RenderPass names as its source."""
    prim = stage.GetPrimAtPath(name) if name.startswith("/") else None
    if not prim or not prim.IsA(UsdRender.Pass):
        raise HdWavefrontError(f"There is no RenderPass prim '{name}' in the stage.")
    targets = UsdRender.Pass(prim).GetRenderSourceRel().GetForwardedTargets()
    if not targets:
        raise HdWavefrontError(f"The RenderPass {name} names no renderSource.")
    diagnostics.warning(
        "render-pass-partial",
        name,
        f"of the render pass only its settings {targets[0]} are used; its collections are not supported yet",
    )
    return str(targets[0])


def _authored(prim: Usd.Prim, name: str, time: Usd.TimeCode) -> Any:
    attribute = prim.GetAttribute(name)
    return attribute.Get(time) if attribute and attribute.HasAuthoredValue() else None


def read_render_settings(
    settings: UsdRender.Settings, time: Usd.TimeCode, diagnostics: Diagnostics
) -> RenderSettingsPrim:
    prim = settings.GetPrim()
    read = RenderSettingsPrim(path=str(prim.GetPath()))
    targets = settings.GetCameraRel().GetForwardedTargets()
    read.camera = str(targets[0]) if targets else ""
    resolution = _authored(prim, "resolution", time)
    if resolution is not None:
        read.resolution = (int(resolution[0]), int(resolution[1]))
    _read_frame(prim, read, time, diagnostics)
    read.rendering_space = str(_authored(prim, "renderingColorSpace", time) or "")
    read.disable_depth_of_field = bool(_authored(prim, "disableDepthOfField", time))
    purposes = _authored(prim, "includedPurposes", time)
    if purposes is not None:
        read.purposes = frozenset(str(p) for p in purposes) & set(PURPOSES) | {"default"}
        for unknown in sorted({str(p) for p in purposes} - set(PURPOSES)):
            _say_bad_value(prim, f"includedPurposes has the unknown '{unknown}'", diagnostics)
    binding_purposes = _authored(prim, "materialBindingPurposes", time)
    if binding_purposes is not None:
        read.material_purpose = next((str(p) for p in binding_purposes if p), "")
    _report_ignored(prim, time, diagnostics)
    for attribute in prim.GetAuthoredAttributes():
        if attribute.GetName().startswith(_NAMESPACE):
            read.settings[attribute.GetName()[len(_NAMESPACE) :]] = attribute.Get(time)
    for target in settings.GetProductsRel().GetForwardedTargets():
        product = _read_product(settings, target, read, time, diagnostics)
        if product is not None:
            read.products.append(product)
    return read


def _say_bad_value(prim: Usd.Prim, what: str, diagnostics: Diagnostics) -> None:
    diagnostics.warning("render-settings-bad-value", prim.GetPath(), f"{what}; it is ignored")


def _read_frame(prim: Usd.Prim, read: RenderSettingsPrim, time: Usd.TimeCode, diagnostics: Diagnostics) -> None:
    """How the camera's aperture fits the image. What makes no sense must not stop the render."""
    aspect = _authored(prim, "pixelAspectRatio", time)
    if aspect is not None:
        if 1e-6 < aspect < 1e6:
            read.pixel_aspect_ratio = float(aspect)
        else:
            _say_bad_value(prim, f"pixelAspectRatio is {aspect:g}", diagnostics)
    policy = str(_authored(prim, "aspectRatioConformPolicy", time) or "")
    if policy and policy not in WINDOW_POLICIES:
        _say_bad_value(prim, f"aspectRatioConformPolicy is the unknown '{policy}'", diagnostics)
    else:
        read.window_policy = policy


def _report_ignored(prim: Usd.Prim, time: Usd.TimeCode, diagnostics: Diagnostics) -> None:
    window = _authored(prim, "dataWindowNDC", time)
    if window is not None and tuple(window) != (0, 0, 1, 1):
        diagnostics.warning(
            "render-data-window", prim.GetPath(), "dataWindowNDC is not supported yet; the whole image is rendered"
        )


def _read_product(
    settings: UsdRender.Settings, target: Any, read: RenderSettingsPrim, time: Usd.TimeCode, diagnostics: Diagnostics
) -> Product | None:
    product = UsdRender.Product(settings.GetPrim().GetStage().GetPrimAtPath(target))
    if not product:
        diagnostics.warning(
            "render-product-missing", target, f"{read.path} names a product that is no RenderProduct; it is ignored"
        )
        return None
    kind = str(product.GetProductTypeAttr().Get(time) or "raster")
    if kind != "raster":
        diagnostics.warning(
            "render-product-type", target, f"products of type '{kind}' are not supported; it is ignored"
        )
        return None
    name = str(product.GetProductNameAttr().Get(time) or "")
    if not name:
        diagnostics.warning("render-product-name", target, "the product has no productName; it is ignored")
        return None
    for overridden in _OVERRIDABLE:
        if product.GetPrim().GetAttribute(overridden).HasAuthoredValue():
            value = product.GetPrim().GetAttribute(overridden).Get(time)
            if value != settings.GetPrim().GetAttribute(overridden).Get(time):
                diagnostics.warning(
                    "render-product-override",
                    target,
                    f"a product's own {overridden} is not supported; the settings' counts",
                )
    cameras = product.GetCameraRel().GetForwardedTargets()
    if cameras and str(cameras[0]) != read.camera:
        if read.camera:
            diagnostics.warning(
                "render-product-override", target, "a product's own camera is not supported; the settings' counts"
            )
        else:
            read.camera = str(cameras[0])
    aovs = _read_vars(product, time, diagnostics)
    return Product(str(target), name, aovs) if aovs else None


def _read_vars(product: UsdRender.Product, time: Usd.TimeCode, diagnostics: Diagnostics) -> tuple[str, ...]:
    aovs: list[str] = []
    stage = product.GetPrim().GetStage()
    for target in product.GetOrderedVarsRel().GetForwardedTargets():
        var = UsdRender.Var(stage.GetPrimAtPath(target))
        if not var:
            diagnostics.warning(
                "render-var-missing", target, "the product names a var that is no RenderVar; it is ignored"
            )
            continue
        name = str(var.GetSourceNameAttr().Get(time) or target.name)
        if str(var.GetSourceTypeAttr().Get(time) or "raw") == "primvar":
            name = f"primvars:{name.removeprefix('primvars:')}"
        is_primvar = name.removeprefix("primvars:") not in ("", name)
        aov = name if is_primvar else _AOV_NAMES.get(name.lower().replace(" ", ""))
        if aov is None:
            diagnostics.warning(
                "render-var-unsupported",
                target,
                f"the render var '{name}' names no AOV of this renderer; it is left out",
            )
        elif aov not in aovs:
            aovs.append(aov)
    if not aovs:
        diagnostics.warning(
            "render-product-empty", product.GetPath(), "the product has no var that can be rendered; it is ignored"
        )
    return tuple(aovs)
