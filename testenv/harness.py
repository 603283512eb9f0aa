# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Renders the cases of testenv and judges them. README.md says what a case.json may hold."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = Path(__file__).resolve().parent
CASE_KEYS = {"why", "render", "variants", "regions", "diagnostics", "checks"}
CHECK_KEYS = {
    "why", "variant", "aov", "region", "channels", "over",
    "mean", "each", "at_most", "at_least", "same_as", "bits_as", "baseline",
    "tolerance", "within", "standard_errors",
}  # fmt: skip
# Options that are render settings; all others go to hdwavefront.open as they are.
DEFAULT_TOLERANCE = 0.01
MAX_STANDARD_ERROR = 0.02


def formula_names() -> dict[str, Any]:
    """What the formulas of a case.json may use."""
    names: dict[str, Any] = {n: getattr(math, n) for n in ("pi", "sin", "cos", "tan", "atan", "asin", "acos", "sqrt")}
    names |= {"radians": math.radians, "min": min, "max": max, "smoothstep": smoothstep, "srgb": srgb_to_linear}
    names["blackbody"] = blackbody
    return names


def smoothstep(low: float, high: float, x: float) -> float:
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3 - 2 * t)


def srgb_to_linear(v: float) -> float:
    """IEC 61966-2-1."""
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4


def blackbody(kelvin: float) -> np.ndarray:
    """OpenUSD's own function is the reference."""
    from pxr import UsdLux

    return np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin))


def evaluate(value: Any) -> Any:
    """A number, a list of numbers, or a formula as text."""
    if isinstance(value, str):
        return np.asarray(eval(value, {"__builtins__": {}}, formula_names()), dtype=float)  # our own files
    if isinstance(value, list):
        return np.array([evaluate(v) for v in value], dtype=float)
    return np.asarray(value, dtype=float)


@dataclass
class Image:
    """One finished render."""

    aovs: dict[str, np.ndarray]
    diagnostics: list[str]
    stats: Mapping[str, Any]
    camera_path: str


@dataclass
class Case:
    path: Path
    data: dict[str, Any]
    images: dict[str, Image] = field(default_factory=dict)
    last: Any = None  # the render before: the next variant goes on with its delegate, as frames do

    @classmethod
    def load(cls, path: Path) -> Case:
        data = json.loads((path / "case.json").read_text(encoding="utf-8"))
        unknown = set(data) - CASE_KEYS
        for check in data["checks"]:
            unknown |= set(check) - CHECK_KEYS
        assert not unknown, f"{path.name}: unknown keys {sorted(unknown)}"
        assert data["checks"], f"{path.name} checks nothing"
        return cls(path, data)

    def image(self, variant: str = "") -> Image:
        if variant not in self.images:
            options = dict(self.data.get("render", {}))
            options |= self.data["variants"][variant] if variant else {}
            wanted = {c.get("aov", "color") for c in self.data["checks"]} - {"color"}
            options["aovs"] = sorted(wanted | set(options.get("aovs", ())))
            self.images[variant], self.last = render(self.path / "scene.usda", options, self.last)
        return self.images[variant]

    def region(self, check: Mapping[str, Any]) -> np.ndarray:
        image = self.image(check.get("variant", "")).aovs[check.get("aov", "color")]
        region = check.get("region")
        if region is None:
            return image
        x0, y0, x1, y1 = self.data["regions"][region] if isinstance(region, str) else region
        part = image[y0:y1, x0:x1]
        assert part.size, f"the region {region} is outside the image"
        return part


def render(scene: Path, options: dict[str, Any], before: Any = None) -> tuple[Image, Any]:
    """Renders one image, with the delegate of the render `before` where there is one: what differs is an edit.

    Any validation message or error flag fails the test; diagnostics are for the caller.
    """
    import hdwavefront
    from hdwavefront.api import core

    options = dict(options)
    tokens = {row["token"] for row in core().render_settings()}
    settings = {k: options.pop(k) for k in list(options) if k in tokens}
    for name in ("ocio", "session_layer"):
        if options.get(name):
            options[name] = str(scene.parent / options[name])
    if before is not None:
        options["delegate"] = before.delegate
        settings = {row["token"]: row["default"] for row in core().render_settings()} | settings
        settings["domeLightCameraVisibility"] = options.get("dome_visible", False)
    result = hdwavefront.open(str(scene), settings=settings, camera_light=options.pop("camera_light", False), **options)
    if before is not None:
        result._sink = before._sink  # knows which prims are to go
    result.start()
    assert result.wait(300), "the render does not end"
    stats = result.stats()
    assert stats["validationMessages"] == 0
    assert stats["errorFlags"] == 0, f"error flags {stats['errorFlags']}"
    assert result.progress["samplesDone"] == result.delegate.setting("samples")
    image = Image(
        {aov: result.map(aov) for aov in result.aovs},
        [f"{d.code} {d.location}" for d in result.diagnostics if d.severity != "info"],
        stats,
        result.camera,
    )
    assert np.isfinite(image.aovs["color"]).all()
    return image, result


def check_case(case: Case, check: Mapping[str, Any]) -> None:
    """One check of a case; an AssertionError tells expected and got."""
    pixels = case.region(check).astype(np.float64)
    is_color = check.get("aov", "color") == "color"
    channels = check.get("channels", "rgb" if is_color else "")
    if is_color:
        pixels = pixels[..., ["rgba".index(c) for c in channels]]
    if "over" in check:
        other = case.region({"aov": check.get("aov", "color"), **check["over"]}).astype(np.float64)
        if is_color:
            other = other[..., ["rgba".index(c) for c in channels]]
        pixels = pixels / other.mean(axis=(0, 1))
    what = {k: v for k, v in check.items() if k not in ("why",)}
    if "mean" in check:
        judge_mean(pixels, check, what)
    if "each" in check:
        expected = evaluate(check["each"])
        limit = check.get("within", check.get("tolerance", DEFAULT_TOLERANCE) * np.abs(expected))
        worst = np.abs(pixels - expected).reshape(-1, pixels.shape[-1])
        assert (np.abs(pixels - expected) <= limit).all(), f"{what}: off by {worst.max(0)}, mean {pixels.mean((0, 1))}"
    if "at_most" in check:
        error = 3 * standard_error(pixels)
        mean = pixels.mean((0, 1))
        assert (mean <= evaluate(check["at_most"]) + error).all(), f"{what}: got {mean} with 3 errors {error}"
        assert (error <= 0.01).all(), "too noisy to tell"
    if "at_least" in check:
        mean = pixels.mean((0, 1))
        assert (mean >= evaluate(check["at_least"])).all(), f"{what}: got {mean}"
    if "same_as" in check or "bits_as" in check:
        judge_same(case, check, pixels, channels if is_color else "", what)
    if "baseline" in check:
        judge_baseline(case, check, pixels, what)


def standard_error(pixels: np.ndarray) -> np.ndarray:
    """Of a region's mean. Pixels draw independent scrambles; over an uneven region this is too large, never small."""
    count = pixels.shape[0] * pixels.shape[1]
    return pixels.reshape(count, -1).std(axis=0, ddof=1) / math.sqrt(count)


def judge_mean(pixels: np.ndarray, check: Mapping[str, Any], what: Any) -> None:
    expected, mean = evaluate(check["mean"]), pixels.mean(axis=(0, 1))
    limit = np.asarray(check.get("within", check.get("tolerance", DEFAULT_TOLERANCE) * np.abs(expected)))
    if "standard_errors" in check:
        error = check["standard_errors"] * standard_error(pixels)
        assert (error <= MAX_STANDARD_ERROR * np.maximum(np.abs(expected), 1e-6)).all(), f"{what}: too noisy: {error}"
        limit = np.maximum(limit, error)
    assert (np.abs(mean - expected) <= limit).all(), f"{what}: expected {expected}, got {mean} (limit {limit})"


def judge_same(case: Case, check: Mapping[str, Any], pixels: np.ndarray, channels: str, what: Any) -> None:
    bits = "bits_as" in check
    other = case.region({**check, "variant": check["bits_as" if bits else "same_as"]}).astype(np.float64)
    if channels:
        other = other[..., ["rgba".index(c) for c in channels]]
    difference = np.abs(pixels - other)
    limit = 0.0 if bits else check.get("within", check.get("tolerance", DEFAULT_TOLERANCE) * np.abs(other).max())
    assert (difference <= limit).all(), (
        f"{what}: differs by {difference.max()} at {int((difference > limit).sum())} places"
    )
    assert np.ptp(pixels) > 0, f"{what}: an even image compares nothing"


def judge_baseline(case: Case, check: Mapping[str, Any], pixels: np.ndarray, what: Any) -> None:
    """Against baseline/<name>.exr: guards against change, proves nothing. HDWAVEFRONT_WRITE_BASELINES=1 writes it."""
    import os

    import OpenImageIO as oiio

    path = case.path / "baseline" / f"{check['baseline']}.exr"
    if os.environ.get("HDWAVEFRONT_WRITE_BASELINES") == "1":
        path.parent.mkdir(exist_ok=True)
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], oiio.HALF)
        spec.attribute("compression", "zip")
        buffer = oiio.ImageBuf(spec)
        stored = np.ascontiguousarray(pixels, dtype=np.float32)
        assert buffer.set_pixels(oiio.ROI(), stored) and buffer.write(str(path)), buffer.geterror()
    golden = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT).astype(np.float64)
    assert golden.shape == pixels.shape, f"{what}: {golden.shape} against {pixels.shape}"
    error = ((pixels - golden) ** 2).mean() / max((golden**2).mean(), 1e-12)
    assert error <= check.get("tolerance", 1e-3), f"{what}: relative MSE {error}"
    np.testing.assert_allclose(pixels.mean((0, 1)), golden.mean((0, 1)), rtol=0.01, atol=1e-4)
