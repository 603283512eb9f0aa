# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Rough conductors and dielectrics without energy compensation, against Walter et al. 2007 with Heitz's
height-correlated masking, written out in double precision: the values themselves, and their integrals by quadrature
over micro normals, which knows nothing of half vectors and their Jacobians.

Refraction is as everywhere here not scaled by the square of the index (bsdf_common.glsl).
"""

from __future__ import annotations

import numpy as np
import pytest

KERNEL = """
#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_GOOGLE_include_directive : require
#include "lib/bsdf/fresnel.glsl"
#include "lib/bsdf/microfacet.glsl"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kIntegrate = 0;
layout(push_constant) uniform Push { uint rows; };
layout(binding = 0, std430) readonly buffer Config { vec4 config[]; };  // wo, alpha x | alpha y, eta, extinction, -
layout(binding = 1, std430) buffer Points { vec4 points[]; };           // wi, configuration -> value
// What the lobes multiply by their compensation. extinction >= 0: a conductor of index eta.
float value(vec4 a, vec4 b, vec3 wi) {
  vec2 alpha = vec2(a.w, b.x);
  bool conductor = b.z >= 0.0;
  vec3 g = vec3(0.0);
  if (wi.z > 0.0) g = ggxReflection(a.xyz, wi, alpha);
  else if (!conductor) g = ggxTransmission(a.xyz, wi, alpha, b.y);
  float f = conductor ? fresnelConductor(g.z, vec3(b.y), vec3(b.z)).x : fresnelDielectric(g.z, b.y);
  return g.x * g.y * (wi.z > 0.0 ? f : 1.0 - f);
}
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (kIntegrate == 0) {
    uint c = uint(points[i].w);
    points[i] = vec4(value(config[2 * c], config[2 * c + 1], points[i].xyz));
    return;
  }
  // A row of equal angle to the normal, on both sides. Denser at the horizon: light from inside jumps to 0 near it,
  // where the micro normals lie down.
  uint c = i / rows;
  float x = 1.0 - (float(i % rows) + 0.5) / float(rows);
  float theta = 1.57079632679 * (1.0 - x * x * x), s = sin(theta), z = cos(theta);
  vec2 sum = vec2(0.0);
  [[dont_unroll]] for (uint k = 0; k < rows; ++k) {
    float phi = 6.28318530718 * (float(k) + 0.5) / float(rows);
    vec3 w = vec3(s * cos(phi), s * sin(phi), z);
    sum += vec2(value(config[2 * c], config[2 * c + 1], w), value(config[2 * c], config[2 * c + 1], vec3(w.xy, -w.z)));
  }
  points[i] = vec4(sum * s * x * x * 29.6088132 / float(rows * rows), 0.0, 0.0);
}
"""
ALPHAS = [(0.1, 0.1), (0.25, 0.25), (0.5, 0.5), (1.0, 1.0), (0.4, 0.15)]
ANGLES = (2.0, 45.0, 70.0, 84.0)
# eta, extinction (negative: a dielectric)
GLASS, INSIDE, DIAMOND, GOLD, SILVER = (1.5, -1.0), (1 / 1.5, -1.0), (2.4, -1.0), (0.18, 3.4), (0.05, 4.4)
MATERIALS = {"glass": GLASS, "inside of glass": INSIDE, "diamond": DIAMOND, "gold": GOLD, "silver": SILVER}


def configurations(eta: float, extinction: float) -> np.ndarray:
    rows = []
    for alpha in ALPHAS:
        for angle in ANGLES:
            t, p = np.radians(angle), 0.6
            rows.append((np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t), *alpha, eta, extinction, 0.0))
    return np.array(rows)


def fresnel(eta: float, extinction: float, cosine: np.ndarray) -> np.ndarray:
    n = eta + 1j * max(extinction, 0.0)
    t = np.sqrt(n**2 - (1 - cosine**2) + 0j)
    return (np.abs((cosine - t) / (cosine + t)) ** 2 + np.abs((n**2 * cosine - t) / (n**2 * cosine + t)) ** 2) / 2


def distribution(m: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(m, -1, 0)
    tan2 = ((x / alpha[0]) ** 2 + (y / alpha[1]) ** 2) / z**2
    return 1 / (np.pi * alpha[0] * alpha[1] * z**4 * (1 + tan2) ** 2)


def masking(wo: np.ndarray, wi: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """Height-correlated: Heitz 2014, equation 99."""

    def smith(w):
        return (np.sqrt(1 + ((alpha * w[..., :2]) ** 2).sum(-1) / w[..., 2] ** 2) - 1) / 2

    return 1 / (1 + smith(wo) + smith(wi))


def walter(row: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """f |cos| by Walter et al. 2007, equations 20 and 21 (the latter times the square of the ratio of indices)."""
    wo, alpha, eta, extinction = row[:3], row[3:5], row[5], row[6]
    up = wi[:, 2] > 0
    half = wo + np.where(up, 1.0, eta)[:, None] * wi
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    half *= np.where(half[:, 2:] < 0, -1, 1)
    cos_o, cos_i = half @ wo, (half * wi).sum(1)
    f = fresnel(eta, extinction, np.clip(cos_o, 0, 1))
    common = distribution(half, alpha) * masking(wo, wi, alpha) / wo[2]
    reflected = f * common / 4
    refracted = (1 - f) * common * eta**2 * np.abs(cos_i) * cos_o / (cos_o + eta * cos_i) ** 2
    refracted[(cos_o <= 0) | (cos_i >= 0) | (extinction >= 0)] = 0
    return np.where(up, reflected, refracted)


def over_micro_normals(row: np.ndarray, side: int = 512) -> tuple[float, float]:
    """Reflected and refracted share: the mean over normals drawn by D (equations 35 and 36 of the same paper)."""
    wo, alpha, eta, extinction = row[:3], row[3:5], row[5], row[6]
    x, v = (a.ravel() for a in np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2, indexing="ij"))
    u, step = 1 - (1 - x) ** 3, 3 * (1 - x) ** 2  # denser where normals lie down, and the weight grows
    slope = np.sqrt(u / (1 - u))
    phi = 2 * np.pi * v
    m = np.stack([alpha[0] * slope * np.cos(phi), alpha[1] * slope * np.sin(phi), np.ones_like(u)], -1)
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    c = m @ wo
    seen = c > 0
    f = fresnel(eta, extinction, np.clip(c, 0, 1))
    mirrored = 2 * c[:, None] * m - wo
    k = 1 - (1 - c**2) / eta**2
    bent = (c / eta - np.sqrt(np.maximum(k, 0)))[:, None] * m - wo / eta
    weight = step * np.where(seen, c, 0) / (wo[2] * m[:, 2])
    reflected = np.where(mirrored[:, 2] > 0, f * weight * masking(wo, mirrored, alpha), 0)
    passes = (bent[:, 2] < 0) & (k > 0) & (extinction < 0)
    refracted = np.where(passes, (1 - f) * weight * masking(wo, bent, alpha), 0)
    return float(reflected.mean()), float(refracted.mean())


def run(runner, rows: np.ndarray, points: np.ndarray, integrate: int, count: int) -> np.ndarray:
    return runner.run(
        KERNEL,
        {0: rows.astype(np.float32), 1: points.astype(np.float32)},
        (len(points) // 64,),
        push=np.array([count], np.uint32).tobytes(),
        spec={0: integrate},
    )[1]


@pytest.mark.parametrize("name", MATERIALS)
def test_values_are_walters(kernel_runner, name):
    rows = configurations(*MATERIALS[name])
    wi = np.random.default_rng(3).normal(size=(len(rows) * 512, 3))
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    wi = wi.astype(np.float32).astype(float)
    config = np.repeat(np.arange(len(rows)), 512)
    ours = run(kernel_runner, rows, np.column_stack([wi, config]), 0, 0)[:, 0]
    for i, row in enumerate(rows):
        theirs = walter(row.astype(np.float32).astype(float), wi[config == i])
        got = ours[config == i]
        assert np.abs(got - theirs).sum() < 1e-3 * theirs.sum(), f"{row}"
        np.testing.assert_allclose(got, theirs, rtol=5e-3, atol=1e-5 * theirs.max())


@pytest.mark.parametrize("name", MATERIALS)
def test_integrals_are_those_over_micro_normals(kernel_runner, name):
    rows = configurations(*MATERIALS[name])
    count = 768
    ours = run(kernel_runner, rows, np.zeros((len(rows) * count, 4)), 1, count)[:, :2].astype(float)
    ours = ours.reshape(len(rows), count, 2).sum(1)
    theirs = np.array([over_micro_normals(row) for row in rows])
    print(np.column_stack([ours, theirs]).round(4))
    np.testing.assert_allclose(ours, theirs, rtol=0.005, atol=2e-4)
