# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Whole pictures against Mitsuba 3 (scalar_rgb): scenes that mean the same in both, here and in Mitsuba.*/scene.usda.

The mapping: max_depth = maxBounces + 1, no Russian roulette on either side, box filter of one pixel. A window of
width w at distance 1 is a fov of 2 atan(w / 2) on the x axis. A rectangle spans [-1, 1]^2 and shines along +Z; a
RectLight along -Z. Lambert is `diffuse`. A metal of standard_surface has MaterialX's artistic index (Gulbrandsen
2014); its energy compensation, which Mitsuba lacks, is under 1 % at the roughness used. Glass is `dielectric`, rough
glass MaterialX's dielectric_bsdf, both without compensation; Mitsuba's masking is the uncorrelated one, which differs
little at alpha 0.2. absorption_vdf below it is a medium of albedo 0, anisotropic_vdf one with
Henyey and Greenstein's phase function. Environment maps lie alike in both. Mitsuba's
light shapes get a black BSDF and stand where nothing is behind them. A glowing mesh shines from both sides, so it is
two rectangles there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from harness import FOLDER, render

BLOCK = 4


@pytest.fixture(scope="module")
def mi():
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


def rgb(*color: float) -> dict[str, Any]:
    return {"type": "rgb", "value": list(color)}


def lambert(*color: float) -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": rgb(*(color if len(color) == 3 else color * 3))}


def transform(mi: Any, t=(0, 0, 0), r=(0, 0, 0), s=(1, 1, 1)) -> Any:
    """USD's translate, rotateXYZ, scale."""
    m = mi.ScalarTransform4f()
    return m.translate(t).rotate([0, 0, 1], r[2]).rotate([0, 1, 0], r[1]).rotate([1, 0, 0], r[0]).scale(s)


def quad(mi: Any, bsdf: dict[str, Any], a, b, d, **more: Any) -> dict[str, Any]:
    """The parallelogram of the corner a and its neighbours b and d, counter-clockwise seen from outside."""
    a, b, d = (np.array(p, dtype=float) for p in (a, b, d))
    x, y = (b - a) / 2, (d - a) / 2
    n = np.cross(x, y)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = x, y, n / np.linalg.norm(n), a + x + y
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(m), "bsdf": bsdf, **more}


def sensor(mi: Any, eye, pitch: float, window: float, size: tuple[int, int]) -> dict[str, Any]:
    target = [eye[0], eye[1] + math.sin(math.radians(pitch)), eye[2] - math.cos(math.radians(pitch))]
    return {
        "type": "perspective",
        "fov": math.degrees(2 * math.atan(window / 2)),
        "fov_axis": "x",
        "near_clip": 0.01,
        "to_world": mi.ScalarTransform4f().look_at(origin=list(eye), target=target, up=[0, 1, 0]),
        "film": {
            "type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "rgb", "rfilter": {"type": "box"},
        },
    }  # fmt: skip


def cornell(mi: Any) -> dict[str, Any]:
    white = lambert(0.73)
    tall = transform(mi, (-0.35, -0.4, -0.3), (0, 18, 0), (0.3, 0.6, 0.3))
    short = transform(mi, (0.35, -0.7, 0.3), (0, -17, 0), (0.3, 0.3, 0.3))
    y = 0.980001
    lamp = {"type": "area", "radiance": rgb(17, 12, 4)}
    return {
        "sensor": sensor(mi, (0, 0, 3.8), 0, 0.72, (64, 64)),
        "floor": quad(mi, white, (-1, -1, 1), (1, -1, 1), (-1, -1, -1)),
        "ceiling": quad(mi, white, (-1, 1, -1), (1, 1, -1), (-1, 1, 1)),
        "back": quad(mi, white, (-1, -1, -1), (1, -1, -1), (-1, 1, -1)),
        "left": quad(mi, lambert(0.63, 0.065, 0.05), (-1, -1, 1), (-1, -1, -1), (-1, 1, 1)),
        "right": quad(mi, lambert(0.14, 0.45, 0.091), (1, -1, -1), (1, -1, 1), (1, 1, -1)),
        "lamp": quad(mi, lambert(0), (-0.3, 0.98, -0.3), (0.3, 0.98, -0.3), (-0.3, 0.98, 0.3), emitter=lamp),
        "lamp_back": quad(mi, lambert(0), (-0.3, y, 0.3), (0.3, y, 0.3), (-0.3, y, -0.3), emitter=lamp),
        "tall": {"type": "cube", "bsdf": white, "to_world": tall},
        "short": {"type": "cube", "bsdf": white, "to_world": short},
    }


def artistic_index(reflectivity: float, edge: float) -> tuple[float, float]:
    """Gulbrandsen, "Artist friendly metallic Fresnel", JCGT 2014, equations 6 and 7."""
    root = math.sqrt(reflectivity)
    n = edge * (1 - reflectivity) / (1 + reflectivity) + (1 - edge) * (1 + root) / (1 - root)
    return n, math.sqrt(((n + 1) ** 2 * reflectivity - (n - 1) ** 2) / (1 - reflectivity))


def environment(mi: Any) -> dict[str, Any]:
    import OpenImageIO as oiio

    sky = oiio.ImageBuf(str(FOLDER / "Mitsuba.Environment/textures/sky.exr")).get_pixels(oiio.FLOAT)
    n, k = artistic_index(0.8, 0.9)

    def ball(x: float, bsdf: dict[str, Any]) -> dict[str, Any]:
        return {"type": "sphere", "center": [x, 0, 0], "radius": 0.9, "bsdf": bsdf}

    return {
        "sensor": sensor(mi, (0, 0.5, 9), 0, 1, (128, 64)),
        "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky[..., :3].copy()), "to_world": transform(mi, r=(0, 30, 0))},
        "floor": quad(mi, lambert(0.4), (-6, -1, 6), (6, -1, 6), (-6, -1, -6)),
        "a": ball(-3, {"type": "conductor", "eta": n, "k": k}),
        "b": ball(-1, {"type": "roughconductor", "eta": n, "k": k, "alpha": 0.09, "distribution": "ggx"}),
        "c": ball(1, {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}),
        # Hardly rough: ours gives back what masking takes (Furnace.RoughGlass), Mitsuba's does not.
        "d": ball(3, {"type": "roughdielectric", "int_ior": 1.5, "ext_ior": 1.0, "alpha": 0.04, "distribution": "ggx"}),
    }


def lights(mi: Any) -> dict[str, Any]:
    picture = {
        "type": "bitmap", "filename": str(FOLDER / "Mitsuba.Lights/textures/blocks.png"), "raw": True,
        "filter_type": "bilinear", "wrap_mode": "repeat", "to_uv": mi.ScalarTransform4f().scale([1, -1, 1]),
    }  # fmt: skip
    painted = {"type": "diffuse", "reflectance": picture}
    white, black = lambert(0.8), lambert(0)
    lamp, bulb = (12, 9.6, 7.2), (16, 24, 40)
    rect = transform(mi, (2.5, 3.5, 1), (-60, 40, 0)).rotate([0, 1, 0], 180).scale([0.5, 0.25, 1])
    toward_light = transform(mi, r=(-50, -20, 0)) @ mi.ScalarVector3f(0, 0, 1)
    return {
        "sensor": sensor(mi, (0, 2, 6), -11, 0.8, (64, 64)),
        "floor": quad(mi, painted, (-2, 0, 2), (2, 0, 2), (-2, 0, -2)),
        "wall": quad(mi, painted, (-2, 0, -2), (2, 0, -2), (-2, 3, -2)),
        "ball": {"type": "sphere", "center": [-0.8, 0.6, -0.5], "radius": 0.6, "bsdf": white},
        "block": {"type": "cube", "bsdf": white, "to_world": transform(mi, (0.8, 0.5, 0), (0, 25, 0), (0.5, 0.5, 0.5))},
        "rect": {"type": "rectangle", "to_world": rect, "bsdf": black, "e": {"type": "area", "radiance": rgb(*lamp)}},
        "sphere": {"type": "sphere", "center": [-3, 2.5, 2], "radius": 0.2, "bsdf": black,
                   "e": {"type": "area", "radiance": rgb(*bulb)}},
        "sun": {"type": "directional", "direction": -toward_light, "irradiance": 1.0},
    }  # fmt: skip


def absorption(mi: Any) -> dict[str, Any]:
    sigma = [-math.log(c) / 0.8 for c in (0.9, 0.5, 0.15)]
    medium = {"type": "homogeneous", "albedo": 0.0, "sigma_t": rgb(*(s / 3 for s in sigma)), "scale": 3.0}
    glass = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
    slab = transform(mi, (1.1, -0.1, 0), (0, 30, 0), (0.8, 0.8, 0.3))
    return {
        "sensor": sensor(mi, (0, 0.6, 7), -5, 0.8, (64, 64)),
        "sky": {"type": "constant", "radiance": 1.0},
        "floor": quad(mi, lambert(0.6), (-6, -1, 6), (6, -1, 6), (-6, -1, -6)),
        "ball": {"type": "sphere", "center": [-1.1, 0, 0], "radius": 0.9, "bsdf": glass, "interior": medium},
        "slab": {"type": "cube", "to_world": slab, "bsdf": glass, "interior": medium},
    }


def scattering(mi: Any) -> dict[str, Any]:
    def medium(absorption, scattering, g: float) -> dict[str, Any]:
        total = [a + s for a, s in zip(absorption, scattering, strict=True)]
        albedo = [s / t for s, t in zip(scattering, total, strict=True)]
        return {"type": "homogeneous", "albedo": rgb(*albedo), "sigma_t": rgb(*(t / 4 for t in total)), "scale": 4.0,
                "phase": {"type": "hg", "g": g}}  # fmt: skip

    glass = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
    milk, jade = medium((0.05, 0.1, 0.2), (2, 1.5, 1), 0.0), medium((0.4, 0.1, 0.3), (1.5, 2.5, 1), 0.5)
    slab = transform(mi, (1.1, -0.1, 0), (0, 30, 0), (0.8, 0.8, 0.3))
    # Paths carry L / n^2 (wavefront/kernels/lib/bsdf/bsdf_common.glsl): what shines inside glass has it already here.
    ember = {"emitter": {"type": "area", "radiance": rgb(*(1.5**2 * c for c in (6, 4, 2)))}, "exterior": milk}
    y = 0.300001
    return {
        "sensor": sensor(mi, (0, 0.6, 7), -5, 0.8, (64, 64)),
        "sky": {"type": "constant", "radiance": 1.0},
        "floor": quad(mi, lambert(0.6), (-6, -1, 6), (6, -1, 6), (-6, -1, -6)),
        "ball": {"type": "sphere", "center": [-1.1, 0, 0], "radius": 0.9, "bsdf": glass, "interior": milk},
        "slab": {"type": "cube", "to_world": slab, "bsdf": glass, "interior": jade},
        "ember": quad(mi, lambert(0), (-1.3, y, 0.1), (-0.9, y, 0.1), (-1.3, y, -0.3), **ember),
        "ember_below": quad(mi, lambert(0), (-1.3, 0.3, -0.3), (-0.9, 0.3, -0.3), (-1.3, 0.3, 0.1), **ember),
    }


def tinted_card(mi: Any) -> dict[str, Any]:
    """Cards that only tint are `thindielectric` of index 1: light passes straight through."""
    absorption, scattering = (0.05, 0.02, 0.1), (4, 1, 0.2)
    total = [a + s for a, s in zip(absorption, scattering, strict=True)]
    albedo = [s / t for s, t in zip(scattering, total, strict=True)]
    milk = {"type": "homogeneous", "albedo": rgb(*albedo), "sigma_t": rgb(*(t / 5 for t in total)), "scale": 5.0,
            "phase": {"type": "hg", "g": 0.3}}  # fmt: skip
    glass = {"type": "dielectric", "int_ior": 1.3, "ext_ior": 1.0}
    film = {"type": "thindielectric", "int_ior": 1.0, "ext_ior": 1.0, "specular_transmittance": rgb(0.95, 0.4, 0.1)}
    inside = {"interior": milk, "exterior": milk}
    return {
        "sensor": sensor(mi, (0, 0.6, 7), -5, 0.5, (40, 40)),
        "sky": {"type": "constant", "radiance": 1.0},
        "floor": quad(mi, lambert(0.6), (-6, -1, 6), (6, -1, 6), (-6, -1, -6)),
        "block": {
            "type": "cube",
            "to_world": transform(mi, r=(0, 30, 0), s=(0.9, 0.8, 0.6)),
            "bsdf": glass,
            "interior": milk,
        },
        "card": quad(mi, film, (-0.4, -0.5, 0.2), (0.4, -0.5, 0.2), (-0.4, 0.5, 0.2), **inside),
        "shelf": quad(mi, film, (-0.4, 0.1, 0.1), (0.4, 0.1, 0.1), (-0.4, 0.1, -0.4), **inside),
    }


def subsurface(mi: Any) -> dict[str, Any]:
    """A random walk is a medium in a boundary that does nothing but diffuse transmission, both ways."""
    boundary = {
        "type": "principledthin",
        "base_color": rgb(1, 1, 1),
        "diff_trans": 2.0,
        "roughness": 0.5,
        "spec_trans": 0.0,
    }

    def inside(color, radius, g: float) -> dict[str, Any]:
        # Kulla and Conty 2017, as wavefront/kernels/lib/subsurface.glsl.
        s = [4.09712 + 4.20863 * c - math.sqrt(9.59217 + 41.6808 * c + 17.7126 * c * c) for c in color]
        albedo = [(1 - x * x) / (1 - g * x * x) for x in s]
        return {"type": "homogeneous", "albedo": rgb(*albedo), "sigma_t": rgb(*(0.1 / r for r in radius)), "scale": 10.0,
                "phase": {"type": "hg", "g": g}}  # fmt: skip

    wax, skin = inside((0.8, 0.5, 0.3), (0.5, 0.3, 0.15), 0.0), inside((0.9, 0.7, 0.2), (0.1, 0.2, 0.4), 0.4)
    slab = transform(mi, (1.1, -0.1, 0), (0, 30, 0), (0.8, 0.8, 0.3))
    return {
        "sensor": sensor(mi, (0, 0.6, 7), -5, 0.8, (64, 64)),
        "sky": {"type": "constant", "radiance": 1.0},
        "floor": quad(mi, lambert(0.6), (-6, -1, 6), (6, -1, 6), (-6, -1, -6)),
        "ball": {"type": "sphere", "center": [-1.1, 0, 0], "radius": 0.9, "bsdf": boundary, "interior": wax},
        "slab": {"type": "cube", "to_world": slab, "bsdf": boundary, "interior": skin},
    }


# Scene, integrator, maxBounces, Mitsuba's samples, lights hidden from the camera, limit of the relative MSE of blocks.
SCENES = {
    "Mitsuba.Cornell": (cornell, "path", 4, 256, False, 1e-3),
    "Mitsuba.Environment": (environment, "path", 8, 256, True, 1e-3),
    "Mitsuba.Lights": (lights, "path", 3, 256, True, 1e-3),
    "Mitsuba.Absorption": (absorption, "volpath", 8, 768, True, 1e-3),
    "Mitsuba.Subsurface": (subsurface, "volpathmis", 128, 128, True, 1e-3),
    "Mitsuba.TintedCard": (tinted_card, "volpathmis", 64, 512, True, 1e-3),
    "Mitsuba.Scattering": (scattering, "volpathmis", 64, 192, True, 1e-3),
}


def blocks(image: np.ndarray) -> np.ndarray:
    height, width = image.shape[:2]
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, -1).mean(axis=(1, 3))


@pytest.mark.parametrize("name", SCENES)
def test_same_picture(mi, name):
    build, integrator, bounces, samples, hidden, limit = SCENES[name]
    scene = build(mi)
    settings = {"type": integrator, "max_depth": bounces + 1, "rr_depth": 1000, "hide_emitters": hidden}
    reference = np.array(
        mi.render(mi.load_dict({"type": "scene", "integrator": settings, **scene}), spp=samples, seed=1)
    )
    height, width = reference.shape[:2]
    options = {"width": width, "height": height, "samples": 256, "maxBounces": bounces, "rouletteBounce": 1000}
    image, _ = render(FOLDER / name / "scene.usda", {**options, "complexity": "high"})
    assert not image.diagnostics
    ours = image.aovs["color"][..., :3]
    a, b = blocks(ours), blocks(reference[..., :3])
    error = ((a - b) ** 2 / (b**2 + 0.01 * (b**2).mean())).mean()
    ratio = ours.mean((0, 1)) / reference[..., :3].mean((0, 1))
    print(f"{name}: relative MSE {error:.2e}, ratio of means {ratio}")
    keep(name, ours, reference)
    assert error < limit, f"relative MSE {error}"
    np.testing.assert_allclose(ratio, 1, atol=0.01)


def keep(name: str, ours: np.ndarray, reference: np.ndarray) -> None:
    """HDWAVEFRONT_KEEP=folder: both pictures side by side, to look at."""
    import os

    folder = os.environ.get("HDWAVEFRONT_KEEP")
    if folder:
        import OpenImageIO as oiio

        pair = np.concatenate([ours, reference[..., :3], np.abs(ours - reference[..., :3]) * 4], axis=1)
        pair = np.repeat(np.repeat(np.clip(pair, 0, 1) ** (1 / 2.2), 4, 0), 4, 1)
        buffer = oiio.ImageBuf(oiio.ImageSpec(pair.shape[1], pair.shape[0], 3, oiio.UINT8))
        buffer.set_pixels(oiio.ROI(), np.ascontiguousarray(pair, dtype=np.float32))
        buffer.write(os.path.join(folder, f"{name}.png"))
