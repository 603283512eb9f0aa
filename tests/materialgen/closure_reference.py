# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""MaterialX's closures in double precision, written from its documents and papers, and its formula of `layer`:

    layer(top, base) = top + base * (1 - reflectance(top))

(MaterialX Physically Based Shading Nodes, "layer"). The reflectance is the directional albedo by quadrature of the
top's own values, so that no fit and no table of ours is on this side. Where MaterialX's GLSL says more than the text,
it is followed: a tint of a dielectric or a sheen takes no part in the reflectance, a generalised Schlick's is the mean
over channels, nothing passes diffuse lobes and conductors, sums add and mixes mix reflectances, `multiply` leaves it.

Directions: z is the normal, wo (3,) to the viewer, wi (n, 3) to the light; values are f |cos|, (n, 3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@lru_cache
def hemisphere(rows: int) -> tuple[Array, float]:
    """Midpoints of cells of equal solid angle, and that solid angle."""
    z = (np.arange(rows) + 0.5) / rows
    phi = 2 * np.pi * (np.arange(2 * rows) + 0.5) / (2 * rows)
    zz, pp = (a.ravel() for a in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1 - zz * zz)
    return np.stack([r * np.cos(pp), r * np.sin(pp), zz], -1), 2 * np.pi / len(zz)


def color(value: float | tuple[float, float, float]) -> Array:
    return np.broadcast_to(np.asarray(value, float), (3,))


class Bsdf:
    def value(self, wo: Array, wi: Array) -> Array:
        raise NotImplementedError

    def reflectance(self, wo: Array) -> Array:
        """What `layer` keeps from the base."""
        return np.ones(3)


# ---- Microfacets: GGX, height-correlated Smith masking, Turquin's compensation --------------------------------------


def _ggx(wo: Array, wi: Array, alpha: float) -> tuple[Array, Array]:
    """D G2 / (4 cos_o), which is the lobe of F = 1 times |cos_i|, and the cosine at the half vector."""
    half = wo + wi
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    cos_m, cos_o, cos_i = half[:, 2], wo[2], wi[:, 2]
    tan2 = (1 - cos_m**2) / cos_m**2
    d = 1 / (np.pi * alpha**2 * cos_m**4 * (1 + tan2 / alpha**2) ** 2)

    def smith(c):
        return (np.sqrt(1 + alpha**2 * (1 - c**2) / c**2) - 1) / 2

    g = 1 / (1 + smith(cos_o) + smith(cos_i))
    return d * g / (4 * cos_o), half @ wo


@lru_cache(maxsize=256)
def _single_scattering(cos_o: float, alpha: float) -> float:
    wo = np.array([np.sqrt(1 - cos_o**2), 0, cos_o])
    wi, solid = hemisphere(384)
    return float(_ggx(wo, wi, alpha)[0].sum() * solid)


@dataclass
class Microfacet(Bsdf):
    """`fresnel`: cosines (n,) -> (n, 3)."""

    alpha: float
    weight: float = 1.0
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def fresnel(self, cosine: Array) -> Array:
        raise NotImplementedError

    def white(self, wo: Array, wi: Array) -> Array:
        shape, cosine = _ggx(wo, wi, self.alpha)
        f = self.fresnel(cosine)
        e = _single_scattering(float(wo[2]), self.alpha)
        return shape[:, None] * f * (1 + f * (1 - e) / e)

    def value(self, wo: Array, wi: Array) -> Array:
        return self.weight * color(self.tint) * self.white(wo, wi)

    def reflectance(self, wo: Array) -> Array:
        wi, solid = hemisphere(384)
        return self.weight * self.white(wo, wi).sum(0) * solid


def _fresnel(n: Array, cosine: Array) -> Array:
    t = np.sqrt(n**2 - (1 - cosine**2) + 0j)
    return (np.abs((cosine - t) / (cosine + t)) ** 2 + np.abs((n**2 * cosine - t) / (n**2 * cosine + t)) ** 2) / 2


@dataclass
class Dielectric(Microfacet):
    ior: float = 1.5

    def fresnel(self, cosine: Array) -> Array:
        return _fresnel(np.array(self.ior + 0j), cosine[:, None]) * np.ones(3)


@dataclass
class Conductor(Microfacet):
    ior: tuple[float, float, float] = (0.2, 0.4, 1.4)
    extinction: tuple[float, float, float] = (3.9, 2.4, 1.6)

    def fresnel(self, cosine: Array) -> Array:
        return _fresnel(color(self.ior) + 1j * color(self.extinction), cosine[:, None])

    def reflectance(self, wo: Array) -> Array:
        return np.ones(3)


@dataclass
class Schlick(Microfacet):
    """color82 white: the curve is Schlick's."""

    color0: tuple[float, float, float] = (0.04, 0.04, 0.04)
    color90: tuple[float, float, float] = (1.0, 1.0, 1.0)
    exponent: float = 5.0

    def fresnel(self, cosine: Array) -> Array:
        return color(self.color0) + (color(self.color90) - color(self.color0)) * (1 - cosine[:, None]) ** self.exponent

    def reflectance(self, wo: Array) -> Array:
        return np.full(3, super().reflectance(wo).mean())


# ---- Sheens ---------------------------------------------------------------------------------------------------------


@dataclass
class Sheen(Bsdf):
    weight: float
    tint: tuple[float, float, float]
    roughness: float

    def white(self, wo: Array, wi: Array) -> Array:
        """Estevez and Kulla 2017, equation 2, over Neubelt and Pettineo's denominator."""
        half = wo + wi
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        d = (2 + 1 / self.roughness) * (1 - half[:, 2] ** 2) ** (0.5 / self.roughness) / (2 * np.pi)
        return (d / (4 * (wi[:, 2] + wo[2] - wi[:, 2] * wo[2])) * wi[:, 2])[:, None] * np.ones(3)

    def value(self, wo: Array, wi: Array) -> Array:
        return self.weight * color(self.tint) * self.white(wo, wi)

    def reflectance(self, wo: Array) -> Array:
        wi, solid = hemisphere(384)
        return self.weight * self.white(wo, wi).sum(0) * solid


@dataclass
class Zeltner(Sheen):
    """Zeltner, Burley and Chiang 2022, with the fits that MaterialX publishes for their tables."""

    def white(self, wo: Array, wi: Array) -> Array:
        x, y = wo[2], self.roughness
        s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
        m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
        o = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y))
        albedo = np.exp(-0.5 * ((x - m) / s) ** 2) / (s * np.sqrt(2 * np.pi)) + o
        a = (2.58126 * x + 0.813703 * y) * y / (1 + 0.310327 * x * x + 2.60994 * x * y)
        b = np.sqrt(1 - x) * (y - 1) * y**3 / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)
        towards = wo[:2] / np.linalg.norm(wo[:2])
        along, across = wi[:, :2] @ towards, wi[:, :2] @ np.array([-towards[1], towards[0]])
        inverse = np.stack([a * along + b * wi[:, 2], a * across, wi[:, 2]], -1)
        length2 = (inverse**2).sum(1)
        cosine = inverse[:, 2] / np.sqrt(length2)
        return (albedo * cosine / np.pi * a**2 / length2**1.5)[:, None] * np.ones(3)


# ---- Diffuse lobes --------------------------------------------------------------------------------------------------


@dataclass
class OrenNayar(Bsdf):
    weight: float
    tint: tuple[float, float, float]
    roughness: float = 0.0

    def value(self, wo: Array, wi: Array) -> Array:
        s2 = self.roughness**2
        s = wi @ wo - wi[:, 2] * wo[2]
        t = np.where(s > 0, s / np.maximum(wi[:, 2], wo[2]), 0)
        shape = 1 - 0.5 * s2 / (s2 + 0.33) + 0.45 * s2 / (s2 + 0.09) * t
        return self.weight * color(self.tint) * (shape * wi[:, 2] / np.pi)[:, None]


@dataclass
class Burley(OrenNayar):
    def value(self, wo: Array, wi: Array) -> Array:
        half = wo + wi
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        f90 = 0.5 + 2 * self.roughness * (half @ wo) ** 2
        shape = (1 + (f90 - 1) * (1 - wi[:, 2]) ** 5) * (1 + (f90 - 1) * (1 - wo[2]) ** 5)
        return self.weight * color(self.tint) * (shape * wi[:, 2] / np.pi)[:, None]


@dataclass
class CompensatedOrenNayar(OrenNayar):
    """OpenPBR's, "Energy-preserving Oren-Nayar"; the albedos of the single-scattering lobe by quadrature."""

    def value(self, wo: Array, wi: Array) -> Array:
        r = self.roughness
        a = 1 / (1 + (0.5 - 2 / (3 * np.pi)) * r)

        def single(o: Array, i: Array) -> Array:
            s = i @ o - i[:, 2] * o[2]
            return a * (1 + r * np.where(s > 0, s / np.maximum(np.maximum(i[:, 2], o[2]), 1e-9), s))

        grid, solid = hemisphere(96)
        cosines = np.linspace(0.002, 1, 200)
        albedos = np.array(
            [(single(np.array([np.sqrt(1 - c * c), 0, c]), grid) * grid[:, 2]).sum() * solid / np.pi for c in cosines]
        )
        mean = np.trapezoid(2 * cosines * albedos, cosines)
        many = color(self.tint) ** 2 * mean / (1 - color(self.tint) * (1 - mean))
        left_o, left_i = (1 - np.interp(c, cosines, albedos) for c in (wo[2], wi[:, 2]))
        value = color(self.tint) * single(wo, wi)[:, None] + many * (left_o * left_i / (1 - mean))[:, None]
        return self.weight * value * wi[:, 2:] / np.pi


# ---- Combiners ------------------------------------------------------------------------------------------------------


@dataclass
class Layer(Bsdf):
    top: Bsdf
    base: Bsdf

    def value(self, wo: Array, wi: Array) -> Array:
        return self.top.value(wo, wi) + self.base.value(wo, wi) * (1 - self.top.reflectance(wo))

    def reflectance(self, wo: Array) -> Array:
        return 1 - (1 - self.top.reflectance(wo)) * (1 - self.base.reflectance(wo))


@dataclass
class Mix(Bsdf):
    fg: Bsdf
    bg: Bsdf
    mix: float

    def value(self, wo: Array, wi: Array) -> Array:
        return self.mix * self.fg.value(wo, wi) + (1 - self.mix) * self.bg.value(wo, wi)

    def reflectance(self, wo: Array) -> Array:
        return self.mix * self.fg.reflectance(wo) + (1 - self.mix) * self.bg.reflectance(wo)


@dataclass
class Add(Bsdf):
    in1: Bsdf
    in2: Bsdf

    def value(self, wo: Array, wi: Array) -> Array:
        return self.in1.value(wo, wi) + self.in2.value(wo, wi)

    def reflectance(self, wo: Array) -> Array:
        return np.minimum(self.in1.reflectance(wo) + self.in2.reflectance(wo), 1)


@dataclass
class Multiply(Bsdf):
    in1: Bsdf
    in2: float | tuple[float, float, float]

    def value(self, wo: Array, wi: Array) -> Array:
        return self.in1.value(wo, wi) * color(self.in2)

    def reflectance(self, wo: Array) -> Array:
        return self.in1.reflectance(wo)
