# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""CARPAINT: a car under an open sky. The class of the paper's scene of that name: 9.5K triangles, at most 4 materials,
of which the car paint has the paper's four layers."""

from __future__ import annotations

import numpy as np

from .builder import Builder, Scene
from .materials import Network, Vector
from .shapes import Array, Mesh, ellipsoid, extruded, lathe, loft, merge, superellipse, surface

WHEELS = (-1.32, 1.32)  # along the car, of which the front looks at +x
WHEEL_RADIUS = 0.34


def car_paint(n: Network) -> None:
    """The paper's car paint: a Fresnel coat, two layers of glossy flakes of procedural colour and normal, and a diffuse
    base whose colour depends on the angle (Laine, Karras and Aila 2013, section 3)."""
    facing = n.node("facingratio_float")
    base_color = n.mixed((0.02, 0.002, 0.006), (0.5, 0.012, 0.02), n.node("power_float", in1=facing, in2=1.5))
    base = n.node("oren_nayar_diffuse_bsdf", color=base_color, roughness=0.3)
    layered = base
    for size, spread, coverage, tint, offset in (
        (0.007, 0.3, 0.55, (1.0, 0.32, 0.22), 7.0),
        (0.0035, 0.16, 0.7, (1.0, 0.45, 0.3), 31.0),
    ):
        place = n.node("add_vector3", in1=n.position(), in2=Vector(offset, offset, offset))
        flake = n.outputs("flake3d", size=size, roughness=spread, coverage=coverage, position=place)
        color = n.node(
            "multiply_color3FA",
            in1=n.mixed((0.5, 0.05, 0.05), tint, flake["rand"]),
            in2=n.mixed_float(0.35, 1.0, n.fractal(n.position(60.0), octaves=2)),
        )
        glossy = n.node(
            "generalized_schlick_bsdf",
            color0=color,
            color90=(1.0, 0.5, 0.42),
            roughness=(0.11, 0.11),
            normal=flake["flakenormal"],
        )
        visible = n.node("ifgreater_float", value1=flake["rand"], value2=0.0, in1=0.45, in2=0.0)
        layered = n.node("mix_bsdf", fg=glossy, bg=layered, mix=visible)
    coat = n.node("dielectric_bsdf", ior=1.5, roughness=(0.0004, 0.0004))
    n.surface(n.node("surface", bsdf=n.node("layer_bsdf", top=coat, base=layered)))


def dark_glass(n: Network) -> None:
    n.standard_surface(base=1.0, base_color=(0.012, 0.014, 0.018), specular=1.0, specular_roughness=0.03)


def rubber(n: Network) -> None:
    grain = n.fractal(n.position(40.0), octaves=3)
    n.standard_surface(
        base_color=n.mixed((0.012, 0.012, 0.012), (0.03, 0.03, 0.03), grain),
        specular=0.4,
        specular_roughness=n.mixed_float(0.35, 0.6, grain),
    )


def concrete(n: Network) -> None:
    large = n.fractal(n.position(0.7), octaves=4)
    fine = n.fractal(n.position(24.0), octaves=3)
    color = n.mixed((0.17, 0.165, 0.16), (0.34, 0.33, 0.315), n.node("multiply_float", in1=large, in2=fine))
    n.standard_surface(base_color=color, specular=0.5, specular_roughness=n.mixed_float(0.18, 0.6, large))


def _between(x: Array, knots: tuple[float, ...], values: tuple[float, ...]) -> Array:
    """A smooth curve through the knots: linear, then with its corners rounded off."""
    fine = np.linspace(knots[0] - 0.4, knots[-1] + 0.4, 800)
    curve = np.interp(fine, knots, values)
    width = 41
    curve = np.convolve(np.pad(curve, width // 2, mode="edge"), np.ones(width) / width, mode="valid")
    return np.asarray(np.interp(x, fine, curve))


def _body(rows: int, sides: int) -> Mesh:
    x = np.linspace(-2.14, 2.14, rows)
    top = _between(x, (-2.14, -1.9, -0.9, 0.9, 1.7, 2.0, 2.14), (0.74, 0.93, 0.97, 0.93, 0.8, 0.68, 0.5))
    bottom = _between(x, (-2.14, -1.9, 1.9, 2.14), (0.42, 0.2, 0.18, 0.3))
    width = _between(x, (-2.14, -1.95, -1.0, 1.0, 1.8, 2.05, 2.14), (0.6, 0.78, 0.88, 0.87, 0.8, 0.66, 0.5))
    for wheel in WHEELS:  # an arch over each axle
        arch = np.sqrt(np.maximum((WHEEL_RADIUS + 0.07) ** 2 - (x - wheel) ** 2, 0)) + WHEEL_RADIUS
        bottom = np.where(
            np.abs(x - wheel) < WHEEL_RADIUS + 0.07, np.maximum(bottom, np.minimum(arch, top - 0.06)), bottom
        )
    sections = []
    for i in range(rows):
        ring = superellipse(width[i], (top[i] - bottom[i]) / 2, 4.5, sides)
        tuck = 1 - 0.06 * np.clip(ring[:, 1] / max((top[i] - bottom[i]) / 2, 1e-6), 0, 1) ** 2
        middle = (top[i] + bottom[i]) / 2
        sections.append(np.stack([np.full(sides, x[i]), middle + ring[:, 1], -ring[:, 0] * tuck], 1))
    return merge([loft(sections[::-1]), _cap(sections[0], -1), _cap(sections[-1], 1)])


def _cap(section: Array, sign: int) -> Mesh:
    center = section.mean(0) + np.array([0.02 * sign, 0, 0])
    rings = np.stack(
        [section, 0.5 * (section + center) + [0.012 * sign, 0, 0], np.repeat(center[None], len(section), 0)]
    )
    return surface(rings if sign < 0 else rings[::-1], closed_v=True)


def _cabin(x: Array, roof: tuple[float, ...], knots: tuple[float, ...], inset: float, sides: int) -> list[Array]:
    height = _between(x, knots, roof)
    sections = []
    for i in range(len(x)):
        rise = max(height[i] - 0.84, 0.01)
        angle = np.linspace(0, np.pi, sides)
        c, s = np.cos(angle), np.sin(angle)
        radius = (np.abs(c) ** 3.2 + np.abs(s) ** 3.2) ** (-1 / 3.2)
        lean = 0.78 - 0.2 * np.clip(radius * s, 0, 1) * min(rise / 0.5, 1)
        sections.append(np.stack([np.full(sides, x[i]), 0.84 + (rise + inset) * radius * s, -lean * radius * c], 1))
    return sections


def _greenhouse(rows: int, sides: int) -> tuple[Mesh, Mesh]:
    """The windows, all around, and the roof above them."""
    knots = (-1.95, -1.15, -0.35, 0.35, 1.25)
    roof = (0.86, 1.36, 1.43, 1.38, 0.86)
    glass = surface(np.stack(_cabin(np.linspace(-1.85, 1.2, rows), roof, knots, 0.0, sides)))
    shell = np.stack(_cabin(np.linspace(-1.12, 0.36, rows // 2), roof, knots, 0.012, 2 * sides))
    return glass, surface(shell[:, sides // 2 + 2 : -sides // 2 - 2])


def _wheel(x: float, side: float) -> tuple[Mesh, Mesh]:
    r, w = WHEEL_RADIUS, 0.11
    tyre = lathe(
        [
            (0.6 * r, -w),
            (0.9 * r, -w),
            (0.98 * r, -0.8 * w),
            (r, -0.4 * w),
            (r, 0.4 * w),
            (0.98 * r, 0.8 * w),
            (0.9 * r, w),
            (0.62 * r, w),
            (0.6 * r, 0.9 * w),
        ],
        26,
    )
    spokes = [
        extruded([(0.0, -0.05), (0.19, -0.028), (0.19, 0.028), (0.0, 0.05)], 0.03, 0.008, 1)
        .turned(1, 72.0 * k)
        .moved((0, 0.75 * w, 0))
        for k in range(5)
    ]
    rim = merge([lathe([(0.0, 0.5 * w), (0.6 * r, 0.62 * w), (0.61 * r, 1.0 * w), (0.68 * r, 1.02 * w)], 26), *spokes])
    angle = 90.0 if side > 0 else -90.0
    place = (x, r, 0.79 * side)
    return tyre.turned(0, angle).moved(place), rim.turned(0, angle).moved(place)


def build(folder: str) -> Scene:
    b = Builder("carpaint", folder)
    paint = b.material("CarPaint", car_paint)
    glass = b.material("Glass", dark_glass)
    tyre = b.material("Rubber", rubber)
    ground = b.material("Concrete", concrete)
    wheels = [_wheel(x, side) for x in WHEELS for side in (-1.0, 1.0)]
    windows, roof = _greenhouse(36, 18)
    mirrors = [ellipsoid((0.09, 0.06, 0.1), 6, 10).moved((0.62, 0.98, side * 0.9)) for side in (-1, 1)]
    lamps = [ellipsoid((0.16, 0.06, 0.17), 6, 12).moved((1.93, 0.66, side * 0.55)) for side in (-1, 1)]
    b.mesh("Body", merge([_body(80, 28), roof, *mirrors]), paint)
    b.mesh("Windows", merge([windows, *lamps, *(rim for _, rim in wheels)]), glass)
    b.mesh("Tyres", merge([t for t, _ in wheels]), tyre)
    disc = [
        np.array([[r * np.cos(a), 0, -r * np.sin(a)] for a in np.linspace(0, 2 * np.pi, 64, endpoint=False)])
        for r in (0.0, 4.6)
    ]
    b.mesh("Ground", surface(np.stack(disc[::-1]), closed_v=True), ground)
    b.rect_light("Softbox", (5.0, 1.8), (1.0, 5.2, 4.4), (0, 0.6, 0), 9.0)
    b.rect_light("Strip", (5.0, 0.7), (-0.6, 4.6, -4.2), (0, 0.7, 0), 14.0, (0.75, 0.85, 1.0))
    b.dome(1.2, (0.72, 0.84, 1.0))
    b.camera((4.4, 1.5, 5.0), (0.05, 0.6, 0.0), 32.0)
    return b.finish(maxBounces=8)
