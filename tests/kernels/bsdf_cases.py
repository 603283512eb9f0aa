# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Parameter sets for every row of bsdfs.def. A new row needs an entry here, or the tests fail and say so."""

from __future__ import annotations

import numpy as np
from bsdf_harness import Lobe, direction, rows

WHITE = [1.0, 1.0, 1.0]
RUST = [0.8, 0.4, 0.1]

# alpha_x, alpha_y
SMOOTH, SHARP, SATIN, ROUGH, FULL = [0.0, 0.0], [0.05, 0.05], [0.25, 0.25], [0.6, 0.6], [1.0, 1.0]
BRUSHED = [0.5, 0.1]


def _diffuse(color: list[float]) -> dict[str, list[float]]:
    return {f"roughness {r}": [*color, r] for r in (0.0, 0.3, 0.7, 1.0)} | {"coloured": [*RUST, 0.5]}


def _dielectric() -> dict[str, list[float]]:
    # tint, ior | alpha, retroreflective
    return {
        "smooth": [*WHITE, 1.5, *SMOOTH],
        "sharp": [*WHITE, 1.5, *SHARP],
        "satin": [*WHITE, 1.5, *SATIN],
        "rough": [*WHITE, 1.33, *ROUGH],
        "full": [*WHITE, 1.5, *FULL],
        "brushed": [*WHITE, 1.5, *BRUSHED],
        "diamond": [*WHITE, 2.4, 0.2, 0.2],
        "faint": [*WHITE, 1.1, 0.3, 0.3],
        "bubble": [*WHITE, 0.75, 0.15, 0.15],
        "tinted": [*RUST, 1.7, 0.4, 0.4],
        # retroreflective, - | film: thickness, index
        "film": [*WHITE, 1.5, 0.1, 0.1, 0.0, 0.0, 420.0, 1.9],
        "rough film": [*WHITE, 1.5, 0.4, 0.4, 0.0, 0.0, 650.0, 1.33],
        "retroreflective": [*WHITE, 1.5, *BRUSHED, 1.0],
    }


def _schlick(reflects: bool = False) -> dict[str, list[float]]:
    # color0, exponent | color82, - | color90, - | alpha
    def row(c0, c82, c90, exponent, alpha, retroreflective=0.0, film=(0.0, 1.5)):
        return [*c0, exponent, *c82, retroreflective, *c90, 0.0, *alpha, *film]

    glass = [0.04, 0.04, 0.04]
    body = {"body": [*glass, 5.0, *WHITE, 0.0, *WHITE, 1.0, *SATIN, 0.0, 1.5]} if reflects else {}
    return body | {
        "smooth": row(glass, WHITE, WHITE, 5.0, SMOOTH),
        "sharp": row(glass, WHITE, WHITE, 5.0, SHARP),
        "satin": row(glass, WHITE, WHITE, 5.0, SATIN),
        "rough": row(glass, WHITE, WHITE, 5.0, ROUGH),
        "brushed": row(glass, WHITE, WHITE, 5.0, BRUSHED),
        "gold": row([1.0, 0.78, 0.34], [0.95, 0.85, 0.6], WHITE, 5.0, SATIN),
        "dark edge": row([0.5, 0.3, 0.2], [0.2, 0.5, 0.9], [0.3, 0.9, 0.6], 3.0, ROUGH),
        "white": row(WHITE, WHITE, WHITE, 5.0, FULL),
        "film": row(glass, WHITE, WHITE, 5.0, [0.1, 0.1], film=(420.0, 1.9)),
        "rough film": row(glass, WHITE, WHITE, 5.0, [0.4, 0.4], film=(650.0, 1.33)),
        "retroreflective": row(glass, WHITE, WHITE, 5.0, BRUSHED, 1.0),
    }


def _conductor() -> dict[str, list[float]]:
    # ior, - | extinction, - | alpha
    gold, silver = [0.183, 0.421, 1.373], [0.05, 0.058, 0.046]
    gold_k, silver_k = [3.424, 2.346, 1.770], [4.42, 3.61, 2.67]
    return {
        "smooth": [*gold, 0.0, *gold_k, 0.0, *SMOOTH],
        "sharp": [*gold, 0.0, *gold_k, 0.0, *SHARP],
        "satin": [*silver, 0.0, *silver_k, 0.0, *SATIN],
        "rough": [*gold, 0.0, *gold_k, 0.0, *ROUGH],
        "full": [*silver, 0.0, *silver_k, 0.0, *FULL],
        "brushed": [*silver, 0.0, *silver_k, 0.0, *BRUSHED],
        # the 0 after ior: retroreflective; after alpha: - | film: thickness, index
        "film": [*gold, 0.0, *gold_k, 0.0, 0.1, 0.1, 0.0, 0.0, 300.0, 1.6],
        "rough film": [*silver, 0.0, *silver_k, 0.0, 0.4, 0.4, 0.0, 0.0, 550.0, 1.33],
        "retroreflective": [*silver, 1.0, *silver_k, 0.0, *BRUSHED],
    }


def _hair() -> dict[str, list[float]]:
    # absorption, ior | roughness of R, of TT | roughness of TRT, cuticle angle, - | tint
    def row(absorption, v, s, cuticle=0.5, ior=1.55, tint=1.0):
        return [*absorption, ior, v, s, v / 4, s, min(4 * v, 1.0), s, cuticle, 0.0, tint, tint, tint]

    return {
        "clear": row([0.0] * 3, 0.02, 0.2),
        "sharp": row([0.0] * 3, 0.005, 0.1),
        "rough": row([0.0] * 3, 0.3, 0.6),
        "full": row([0.0] * 3, 1.0, 1.0),
        "blond": row([0.1, 0.3, 0.8], 0.02, 0.2, 0.52),
        "tilted": row([0.5, 1.0, 2.0], 0.05, 0.3, 0.45, 1.3, 0.8),
    }


_CASES: dict[str, tuple[str, dict[str, list[float]]]] = {
    "orenNayar": ("a.rgb, a.w", _diffuse(WHITE)),
    "orenNayarCompensated": ("a.rgb, a.w", _diffuse(WHITE)),
    "burley": ("a.rgb, a.w", _diffuse(WHITE)),
    "translucent": ("a.rgb", {"white": WHITE, "coloured": RUST}),
    "subsurface": ("a.rgb, b.rgb, 0.0", {"white": [*WHITE, 0, 1, 1, 1], "coloured": [*RUST, 0, 1, 0, 2]}),
    "dielectricReflection": ("a.rgb, a.w, b.xy, b.z != 0.0, c.xy", _dielectric()),
    "dielectricTransmission": ("a.rgb, a.w, b.xy, c.xy", _dielectric()),
    "dielectric": ("a.rgb, a.rgb, a.w, b.xy, b.z != 0.0, c.xy", _dielectric()),
    "conductor": ("a.rgb, b.rgb, c.xy, a.w != 0.0, d.xy", _conductor()),
    "generalizedSchlick": ("a.rgb, b.rgb, c.rgb, a.w, d.xy, b.w != 0.0, d.zw, c.w != 0.0", _schlick(True)),
    "generalizedSchlickTransmission": ("a.rgb, b.rgb, c.rgb, a.w, d.xy, d.zw", _schlick()),
    "generalizedSchlickRt": ("a.rgb, b.rgb, c.rgb, a.w, d.xy, b.w != 0.0, d.zw", _schlick()),
    "thinTransmission": (
        "a.rgb, a.w, b.xy",
        {
            "smooth": [*WHITE, 1.5, *SMOOTH],
            "satin": [*WHITE, 1.5, *SATIN],
            "full": [*WHITE, 2.4, *FULL],
            "brushed": [*WHITE, 1.5, *BRUSHED],
            "tinted": [*RUST, 1.7, 0.4, 0.4],
        },
    ),
    "chiangHair": ("d.rgb, d.rgb, d.rgb, a.w, b.xy, b.zw, c.xy, c.z, a.rgb", _hair()),
    "sheenContyKulla": (
        "a.rgb, a.w",
        {f"roughness {r}": [*WHITE, r] for r in (0.07, 0.15, 0.3, 0.6, 1.0)} | {"coloured": [*RUST, 0.4]},
    ),
    "sheenZeltner": (
        "a.rgb, a.w",
        {f"roughness {r}": [*WHITE, r] for r in (0.01, 0.15, 0.3, 0.6, 1.0)} | {"coloured": [*RUST, 0.4]},
    ),
}

# Transmissive, but no refraction.
STRAIGHT = ("translucent", "subsurface")


class _Dice:
    """Parameters at random, ends of their ranges and values beyond them among them."""

    def __init__(self, rng: np.random.Generator):
        self.rng = rng

    def between(self, low: float, high: float, *ends: float) -> float:
        return float(self.rng.choice(ends)) if ends and self.rng.random() < 0.35 else float(self.rng.uniform(low, high))

    def color(self) -> list[float]:
        return [self.between(0, 1, 0.0, 1.0, 1.5) for _ in range(3)]

    def alpha(self) -> list[float]:
        wide = self.between(0.01, 1, 0.0, 1.0, 1.5)
        return [wide, wide] if self.rng.random() < 0.5 else [wide, wide * self.between(0.1, 1)]

    def film(self) -> list[float]:
        return [self.between(50, 1000, 0.0, 0.0), self.between(1.05, 2.2, 1.0)]

    def ior(self) -> float:
        return self.between(1.05, 3, 0.0, 0.7, 1.0, 1.001, 12.0)


def random_set(lobe: str, rng: np.random.Generator) -> list[float]:
    """A parameter set of that lobe, in the order of its entry above."""
    d = _Dice(rng)
    if lobe.startswith("dielectric"):
        return [*d.color(), d.ior(), *d.alpha(), float(rng.integers(2)), 0.0, *d.film()]
    if lobe == "thinTransmission":
        return [*d.color(), d.ior(), *d.alpha()]
    if lobe.startswith("generalizedSchlick"):
        exponent, ends = d.between(1, 8, 0.0, 5.0), [*d.color(), d.between(0, 1, 1.0), *d.color()]
        return [*d.color(), exponent, *ends[:3], float(rng.integers(2)), *ends[4:], float(rng.integers(2)), *d.alpha(), *d.film()]
    if lobe == "conductor":
        n, k = ([d.between(0.05, 4, 0.0, 1.0) for _ in range(3)] for _ in range(2))
        return [*n, float(rng.integers(2)), *k, 0.0, *d.alpha(), 0.0, 0.0, *d.film()]
    if lobe == "chiangHair":
        # Around the hair no narrower than the quadrature sees: a ridge across its cells.
        widths = [x for _ in range(3) for x in (d.between(0.01, 1, 0.0, 1.0), d.between(0.08, 1, 0.08, 1.0))]
        return [*(d.between(0, 2, 0.0, 50.0) for _ in range(3)), d.between(1.1, 2, 1.0), *widths, d.between(0.4, 0.6), 0.0, *d.color()]
    if lobe in STRAIGHT:
        return d.color()
    return [*d.color(), d.between(0.02, 1, 0.0, 1.0, 1.5)]


LOBES = {name: Lobe(name, file, r, t, *_CASES.get(name, ("", {}))) for name, file, r, t in rows()}

# Off the axes of the frame, so that an anisotropic lobe has no symmetry to hide behind.
VIEWS = {
    "normal": direction(0.5, 40),
    "30": direction(30, 40),
    "60": direction(60, 110),
    "80": direction(80, 40),
    "88": direction(88, -25),
    "back 30": direction(30, 40, -1),
    "back 75": direction(75, 200, -1),
}


def index_of(lobe: Lobe, name: str) -> float:
    """Index of the medium behind the surface (1 in front), for the lobes that refract."""
    values = lobe.sets[name]
    if not lobe.transmissive or lobe.name in (*STRAIGHT, "thinTransmission", "chiangHair"):
        return 1.0
    if lobe.name.startswith("dielectric"):
        return min(max(values[3], 0.1), 10.0)
    r = min(sum(values[:3]) / 3, 0.66) ** 0.5
    return min(max((1 + r) / (1 - r), 1.01), 10.0)


def albedo_tolerance(lobe: Lobe, name: str) -> float:
    """How far fooAlbedo may be from the lobe's albedo: closed forms hardly, fits as their files promise."""
    if lobe.name in ("orenNayar", "orenNayarCompensated", "burley", "chiangHair", *STRAIGHT):
        return 0.002
    if name == "retroreflective":
        name = "brushed"
    # The albedo only steers the choice of a lobe, except in `layer`, which weighs what lies below by it (reflecting lobes).
    schlick = lobe.name.startswith("generalizedSchlick")
    if name in ("film", "rough film"):  # two cosines of a curve that oscillates; inside, the curve at the normal
        return (0.05 if lobe.transmissive else 0.042) if schlick else 0.03
    if lobe.transmissive and name == "brushed":
        return 0.09  # the table knows isotropic interfaces; inside, the critical angle depends on the azimuth
    if name in ("brushed", "bubble", "body"):
        return 0.02  # bubble, body: a critical angle
    if name == "dark edge":
        return 0.025  # two cosines do not catch a curve with a dip
    return 0.035 if name == "gold" and lobe.transmissive else 0.012  # T follows a dielectric's curve


def energy_bound(lobe: Lobe, name: str) -> float:
    """The greatest albedo of a white lobe: 1, but for models that are published with more."""
    if lobe.name == "burley":
        return 1.56
    if lobe.name == "sheenContyKulla":
        return 1.0 if lobe.sets[name][3] >= 0.2 else 1.25
    if lobe.name == "orenNayar":
        return 1.004
    if lobe.name == "generalizedSchlickRt" and name == "dark edge":
        return 1.0125  # a curve that falls where a dielectric's rises: schlick_interface.glsl
    # The compensation divides by fits (0.5 %).
    compensated = ("dielectric", "generalizedSchlick", "conductor", "thinTransmission")
    return 1.005 if lobe.name.startswith(compensated) else 1.0


def random_energy_bound(lobe: Lobe) -> float:
    """The same for any parameters."""
    if lobe.name in ("burley", "sheenContyKulla", "orenNayar"):
        return {"burley": 1.56, "sheenContyKulla": 1.3, "orenNayar": 1.004}[lobe.name]
    if lobe.name in ("generalizedSchlickRt", "generalizedSchlickTransmission"):
        return 1.06  # curves far from a dielectric's, at indices up to 9.7, anisotropic: schlick_interface.glsl
    return 1.01
