# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdRenderSettings with its products and vars: what it asks for, in plain values. Unknown wishes are diagnosed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from pxr import Usd, UsdRender

from ..errors import Diagnostics, HdWavefrontError
from . import PURPOSES, WINDOW_POLICIES

_NAMESPACE = "wavefront:"
_WHOLE = (0.0, 0.0, 1.0, 1.0)
_MAX_WINDOW = 100.0  # of the picture's sides: overscan has an end


@dataclass(frozen=True, slots=True)
class Shot:
    """What is looked at, and how. None or empty: nothing authored."""

    camera: str = ""
    resolution: tuple[int, int] | None = None
    pixel_aspect_ratio: float | None = None
    window_policy: str = ""
    data_window: tuple[float, float, float, float] = _WHOLE  # left, bottom, right, top, in parts of the picture
    disable_depth_of_field: bool = False


@dataclass(frozen=True, slots=True)
class Product:
    path: str
    name: str  # productName as authored
    aovs: tuple[str, ...]
    shot: Shot = Shot()  # the settings' where the product says nothing of its own


@dataclass(slots=True)
class RenderSettingsPrim:
    """None or empty: nothing authored."""

    path: str = ""
    shot: Shot = Shot()
    purposes: frozenset[str] | None = None
    material_purpose: str | None = None
    rendering_space: str = ""
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
    read.shot = _read_shot(settings, Shot(), time, diagnostics)
    read.rendering_space = str(_authored(prim, "renderingColorSpace", time) or "")
    purposes = _authored(prim, "includedPurposes", time)
    if purposes is not None:
        read.purposes = frozenset(str(p) for p in purposes) & set(PURPOSES) | {"default"}
        for unknown in sorted({str(p) for p in purposes} - set(PURPOSES)):
            _say_bad_value(prim, f"includedPurposes has the unknown '{unknown}'", diagnostics)
    binding_purposes = _authored(prim, "materialBindingPurposes", time)
    if binding_purposes is not None:
        read.material_purpose = next((str(p) for p in binding_purposes if p), "")
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


def _read_shot(prim: UsdRender.SettingsBase, base: Shot, time: Usd.TimeCode, diagnostics: Diagnostics) -> Shot:
    """`base` with what the prim says itself. What makes no sense must not stop the render."""
    own: dict[str, Any] = {}
    cameras = prim.GetCameraRel().GetForwardedTargets()
    if cameras:
        own["camera"] = str(cameras[0])
    resolution = _authored(prim.GetPrim(), "resolution", time)
    if resolution is not None:
        own["resolution"] = (int(resolution[0]), int(resolution[1]))
    aspect = _authored(prim.GetPrim(), "pixelAspectRatio", time)
    if aspect is not None:
        if 1e-6 < aspect < 1e6:
            own["pixel_aspect_ratio"] = float(aspect)
        else:
            _say_bad_value(prim.GetPrim(), f"pixelAspectRatio is {aspect:g}", diagnostics)
    policy = str(_authored(prim.GetPrim(), "aspectRatioConformPolicy", time) or "")
    if policy and policy not in WINDOW_POLICIES:
        _say_bad_value(prim.GetPrim(), f"aspectRatioConformPolicy is the unknown '{policy}'", diagnostics)
    elif policy:
        own["window_policy"] = policy
    window = _authored(prim.GetPrim(), "dataWindowNDC", time)
    if window is not None:
        left, bottom, right, top = (float(x) for x in window)
        if all(abs(x) < _MAX_WINDOW for x in window) and left < right and bottom < top:
            own["data_window"] = (left, bottom, right, top)
        else:
            _say_bad_value(prim.GetPrim(), f"dataWindowNDC is {tuple(window)}", diagnostics)
    sharp = _authored(prim.GetPrim(), "disableDepthOfField", time)
    if sharp is not None:
        own["disable_depth_of_field"] = bool(sharp)
    return replace(base, **own)


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
    shot = _read_shot(product, read.shot, time, diagnostics)
    if not read.shot.camera:
        read.shot = replace(read.shot, camera=shot.camera)
    for attribute in product.GetPrim().GetAuthoredAttributes():
        if attribute.GetName().startswith(_NAMESPACE):
            diagnostics.warning(
                "render-product-setting",
                target,
                f"a product's own {attribute.GetName()} is not supported; the RenderSettings prim's counts",
            )
    aovs = _read_vars(product, time, diagnostics)
    return Product(str(target), name, aovs, shot) if aovs else None


def _read_vars(product: UsdRender.Product, time: Usd.TimeCode, diagnostics: Diagnostics) -> tuple[str, ...]:
    from .._core import aov_of_render_var

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
        aov = aov_of_render_var(name, str(var.GetSourceTypeAttr().Get(time) or "raw"))
        if not aov:
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
