# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Lobes against published numbers, and closed bodies of glass."""

from __future__ import annotations

import numpy as np
import pytest
from bsdf_cases import LOBES, WHITE
from bsdf_harness import Cells, Device, direction, integrate, lobe_table
from scipy.special import ive


def _reflected(runner, name: str, sets: list[list[float]], wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Integral of eval (configs, 3), and throughput, of parameter sets x wo."""
    device = Device(runner, LOBES[name])
    params = np.zeros((len(sets) * len(wo), 16), np.float32)
    for i, values in enumerate(sets):
        params[i * len(wo) : (i + 1) * len(wo), : len(values)] = values
    views = np.tile(wo, (len(sets), 1))
    wi, _ = device.sample(params, views, 4096)
    cells = Cells.of(wi, (wi**2).sum(-1) > 0.5, 2048, 5)
    integrals, _ = integrate(device, params, views, cells)
    out = np.zeros((len(views), 4))
    np.add.at(out, cells.config, integrals)
    return out[:, :3], device.albedo(params, views)[1]


# Single scattering, F = 1, height-correlated Smith: rows alpha, columns mu = 1, .7, .4, .1.
GGX = {
    0.10: (0.9882, 0.9816, 0.9568, 0.8833),
    0.25: (0.9159, 0.8854, 0.8442, 0.8916),
    0.50: (0.6879, 0.6826, 0.7160, 0.8602),
    0.75: (0.4639, 0.5110, 0.6024, 0.8109),
    1.00: (0.3066, 0.3794, 0.4984, 0.7601),
}
MU = np.array([1.0, 0.7, 0.4, 0.1])


SINGLE_SCATTERING = """
#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_GOOGLE_include_directive : require
#include "lib/bsdf/ggx_albedo.glsl"
#include "lib/bsdf/microfacet.glsl"
layout(local_size_x = 64) in;
layout(binding = 0, std430) buffer Values { vec4 values[]; };  // cosine, alpha -> mean of G2 / G1, fit
void main() {
  vec4 v = values[gl_GlobalInvocationID.x];
  vec3 wo = vec3(sqrt(max(1.0 - v.x * v.x, 0.0)), 0.0, v.x);
  float sum = 0.0;
  [[dont_unroll]] for (uint i = 0; i < 128u * 128u; ++i) {
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, v.yy, (vec2(i & 127u, i >> 7) + 0.5) / 128.0));
    sum += wi == vec3(0.0) ? 0.0 : ggxReflection(wo, wi, v.yy).y;
  }
  values[gl_GlobalInvocationID.x] = vec4(sum / 16384.0, ggxAlbedo(v.x, v.y), 0.0, 0.0);
}
"""


def test_single_scattering_ggx(kernel_runner):
    """The microfacet functions without compensation, and the fit that the compensation divides by."""
    values = np.zeros((64, 4), np.float32)
    values[:20, 0], values[:20, 1] = np.tile(MU, 5), np.repeat(list(GGX), 4)
    values[20:, :2] = np.random.default_rng(2).uniform(0.02, 1, (44, 2))
    out = kernel_runner.run(SINGLE_SCATTERING, {0: values})[0]
    expected = np.array(list(GGX.values())).ravel()
    np.testing.assert_allclose(out[:20, 0], expected, rtol=0.005)
    np.testing.assert_allclose(out[:, 1], out[:, 0], rtol=0.007)


@pytest.mark.parametrize("name", ["conductor", "generalizedSchlick"])
def test_compensated_white_ggx_reflects_everything(kernel_runner, name):
    def values(alpha):
        if name == "conductor":
            return [1e-3] * 3 + [0.0] + [1e3] * 3 + [0.0, alpha, alpha]
        return [*WHITE, 5.0, *WHITE, 0.0, *WHITE, 0.0, alpha, alpha]

    wo = np.array([direction(np.degrees(np.arccos(mu)), 0) for mu in MU])
    albedo, _ = _reflected(kernel_runner, name, [values(alpha) for alpha in GGX], wo)
    np.testing.assert_allclose(albedo, 1, atol=0.008)


# Means over the inner half of a sphere's disc, roughness 0 to 1 in steps of 0.1.
OREN_NAYAR = (1.001, 0.988, 0.955, 0.909, 0.857, 0.808, 0.765, 0.729, 0.699, 0.674, 0.653)
BURLEY = (0.976, 0.981, 0.987, 0.993, 0.999, 1.005, 1.010, 1.016, 1.022, 1.030, 1.034)
SHEEN_OVER_WHITE = (0.993, 0.989, 0.991, 0.995, 0.995, 0.995, 0.993, 0.993, 0.990, 0.989, 0.985)
ZELTNER_OVER_WHITE = (1.0,) * 11


@pytest.mark.parametrize(
    ("name", "expected", "tolerance"),
    [
        ("orenNayar", OREN_NAYAR, 0.01),
        ("orenNayarCompensated", (1.0,) * 11, 0.003),
        ("burley", BURLEY, 0.01),
        ("sheenContyKulla", SHEEN_OVER_WHITE, 0.01),
        ("sheenZeltner", ZELTNER_OVER_WHITE, 0.003),
    ],
)
def test_furnace_of_materialx_lobes(kernel_runner, name, expected, tolerance):
    sin2 = (np.arange(8) + 0.5) / 8 * 0.25
    wo = np.array([direction(np.degrees(np.arcsin(np.sqrt(s))), 25) for s in sin2])
    sets = [[*WHITE, r / 10] for r in range(11)]
    reflected, through = _reflected(kernel_runner, name, sets, wo)
    if name.startswith("sheen"):
        reflected = reflected + through  # over a white base
    means = reflected[:, 1].reshape(11, -1).mean(1)
    np.testing.assert_allclose(means, expected, rtol=tolerance)


@pytest.mark.parametrize("ior", [1.3, 1.5, 2.4])
@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.25])
def test_coat_over_white_neither_gains_nor_loses(kernel_runner, ior, alpha):
    """dielectric R layered over a white base, as MaterialX layers it: 1 within 1.5 %."""
    wo = np.array([direction(theta, 10) for theta in (0.5, 30, 50, 70, 80, 86)])
    reflected, through = _reflected(kernel_runner, "dielectricReflection", [[*WHITE, ior, alpha, alpha]], wo)
    np.testing.assert_allclose(reflected + through, 1, atol=0.015)


def test_diffuse_lobes_point_by_point(kernel_runner):
    """Oren-Nayar and Burley against MaterialX's formulas, written out."""
    rng = np.random.default_rng(11)
    count = 2000
    wo, wi = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(2, count, 3)))
    wo[:, 2], wi[:, 2] = np.abs(wo[:, 2]), np.abs(wi[:, 2])
    roughness = rng.random(count)
    params = np.zeros((count, 16), np.float32)
    params[:, :3], params[:, 3] = 0.8, roughness
    cos_o, cos_i, dot = wo[:, 2], wi[:, 2], (wo * wi).sum(1)

    s = dot - cos_o * cos_i
    t = np.where(s > 0, s / np.maximum(cos_o, cos_i), 0)
    sigma2 = roughness**2
    oren_nayar = 1 - 0.5 * sigma2 / (sigma2 + 0.33) + 0.45 * sigma2 / (sigma2 + 0.09) * t

    half = wo + wi
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    f90 = 0.5 + 2 * roughness * (wi * half).sum(1) ** 2
    burley = (1 + (f90 - 1) * (1 - cos_i) ** 5) * (1 + (f90 - 1) * (1 - cos_o) ** 5)

    for name, expected in (("orenNayar", oren_nayar), ("burley", burley)):
        value = Device(kernel_runner, LOBES[name]).evaluate(params, wo, np.arange(count), wi)
        np.testing.assert_allclose(value[:, 0], 0.8 * expected * cos_i / np.pi, rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose(value[:, 3], cos_i / np.pi, rtol=1e-5, atol=1e-7)


def _hair(wo, wi, absorption, ior, v, s) -> np.ndarray:
    """Chiang et al. 2016, without tilt; x along the hair, z its normal, wo on its side. f |cos| of all terms."""
    sin_o, sin_i = wo[0], wi[0]
    cos_o, cos_i = np.hypot(wo[1], wo[2]), np.hypot(wi[1], wi[2])
    gamma_o = np.arctan2(-wo[1], wo[2])
    gamma_t = np.arcsin(np.sin(gamma_o) * cos_o / np.sqrt(ior**2 - sin_o**2))
    cos_t = np.sqrt(1 - (sin_o / ior) ** 2)
    c, g = cos_o * np.cos(gamma_o), np.sqrt(ior**2 + (cos_o * np.cos(gamma_o)) ** 2 - 1)
    f = (((c - g) / (c + g)) ** 2 + ((ior**2 * c - g) / (ior**2 * c + g)) ** 2) / 2
    t = np.exp(-absorption * 2 * np.cos(gamma_t) / cos_t)
    carried = [f, (1 - f) ** 2 * t, (1 - f) ** 2 * t * t * f]
    carried.append(carried[2] * t * f / (1 - t * f))
    phi = np.arctan2(wi[2], wi[1]) - np.arctan2(wo[2], wo[1])
    total = 0.0
    for p, a in enumerate(carried):
        x, y = cos_i * cos_o / v[min(p, 2)], sin_i * sin_o / v[min(p, 2)]
        m = ive(0, x) * np.exp(x - y - 1 / v[min(p, 2)]) / (v[min(p, 2)] * (1 - np.exp(-2 / v[min(p, 2)])))
        d = (phi - (2 * p * gamma_t - 2 * gamma_o + p * np.pi) + np.pi) % (2 * np.pi) - np.pi
        width = s * np.sqrt(np.pi / 8)
        logistic = np.exp(-abs(d) / width) / (width * (1 + np.exp(-abs(d) / width)) ** 2)
        cut = 1 / (1 + np.exp(-np.pi / width)) - 1 / (1 + np.exp(np.pi / width))
        total += a * m * (logistic / cut if p < 3 else 1 / (2 * np.pi))
    return total


def test_hair_point_by_point(kernel_runner):
    """Against the paper's formulas, written out with scipy's Bessel function."""
    rng = np.random.default_rng(12)
    count = 500
    wo, wi = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(2, count, 3)))
    wo[:, 2] = np.abs(wo[:, 2])
    params = np.zeros((count, 16), np.float32)
    absorption, ior = rng.uniform(0, 2, count), rng.uniform(1.3, 1.8, count)
    v, s = rng.uniform(0.01, 0.9, (count, 3)), rng.uniform(0.05, 0.9, count)
    params[:, :4] = np.stack([absorption, absorption, absorption, ior], -1)
    params[:, 4:10] = np.stack([v[:, 0], s, v[:, 1], s, v[:, 2], s], -1)
    params[:, 10], params[:, 12:15] = 0.5, 1.0
    out = Device(kernel_runner, LOBES["chiangHair"]).evaluate(params, wo, np.arange(count), wi)
    expected = [_hair(wo[i], wi[i], absorption[i], ior[i], v[i], s[i]) for i in range(count)]
    # A driver's arc sine is good to some 1e-4, and the narrowest lobes are 0.03 wide.
    np.testing.assert_allclose(out[:, 1], expected, rtol=0.012, atol=1e-5)


FRESNEL = """
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/bsdf/fresnel.glsl"
layout(local_size_x = 64) in;
layout(binding = 0, std430) buffer In { vec4 values[]; };
layout(binding = 1, std430) buffer Out { vec4 result[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec4 v = values[i];  // cosine, eta or n, k, exponent
  SchlickFresnel s = schlickFresnelMake(vec3(0.3), vec3(0.6), vec3(0.9), v.w);
  result[i] = vec4(fresnelDielectric(v.x, v.y), fresnelConductor(v.x, vec3(v.y), vec3(v.z)).x,
                   fresnelSchlick(v.x, s).x, 0.0);
}
"""


def test_fresnel_terms(kernel_runner):
    """Against the complex Fresnel equations, and MaterialX's generalised Schlick."""
    rng = np.random.default_rng(5)
    count = 4096
    cos, eta, k, exponent = (
        rng.random(count),
        rng.uniform(0.4, 3, count),
        rng.uniform(0, 6, count),
        5 * rng.random(count),
    )
    cos[:2] = 1.0, 1 / 7
    values = np.stack([cos, eta, k, exponent + 0.5], -1).astype(np.float32)
    out = kernel_runner.run(FRESNEL, {0: values, 1: np.zeros_like(values)}, (count // 64,))[1]

    def fresnel(n: np.ndarray) -> np.ndarray:
        t = np.sqrt(n**2 - (1 - cos**2) + 0j)
        return (np.abs((cos - t) / (cos + t)) ** 2 + np.abs((n**2 * cos - t) / (n**2 * cos + t)) ** 2) / 2

    np.testing.assert_allclose(out[:, 0], fresnel(eta + 0j), atol=2e-4)
    np.testing.assert_allclose(out[:, 1], fresnel(eta + 1j * k), atol=2e-4)
    e = exponent + 0.5
    c = 1 / 7
    plain = 0.3 + 0.6 * (1 - cos) ** e
    dip = (0.3 + 0.6 * (1 - c) ** e) * (1 - 0.6) * cos * (1 - cos) ** 6 / (c * (1 - c) ** 6)
    np.testing.assert_allclose(out[:, 2], np.clip(plain - dip, 0, 1), atol=1e-4)


GLASS_BODY = """
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_samplerless_texture_functions : require
layout(binding = 22) uniform utextureBuffer lobeTable;
#include "lib/bsdf/dielectric.glsl"
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kSlab = 0;
layout(push_constant) uniform Push { float alpha; float ior; };
layout(binding = 0, std430) buffer Out { vec4 result[]; };
uvec3 pcg(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  return v;
}
// A ray from outside onto a unit sphere, or a slab, in a furnace of radiance 1: its weight on leaving.
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec3 u = vec3(pcg(uvec3(i, 5u, 9u)) >> 8) * (1.0 / 16777216.0);
  float mu = sqrt(1.0 - u.x);
  vec3 p = vec3(0.0, 0.0, 1.0);
  vec3 d = -vec3(sqrt(u.x), 0.0, mu);
  float weight = 1.0;
  bool left = false;
  [[dont_unroll]] for (uint bounce = 0; bounce < 1024 && weight > 0.0 && !left; ++bounce) {
    vec3 n = kSlab == 1 ? vec3(0.0, 0.0, p.z) : p;
    vec3 t = normalize(abs(n.x) < 0.9 ? cross(n, vec3(1.0, 0.0, 0.0)) : cross(n, vec3(0.0, 1.0, 0.0)));
    mat3 frame = mat3(t, cross(n, t), n);
    vec3 wo = -d * frame;
    DielectricLobe l = dielectricMake(wo, vec3(1.0), vec3(1.0), ior, vec2(alpha), false, vec2(0.0));
    vec3 wi = dielectricSample(l, wo, vec3(pcg(uvec3(i, bounce, 77u)) >> 8) * (1.0 / 16777216.0));
    if (wi == vec3(0.0)) { weight = 0.0; break; }
    vec4 f = dielectricEval(l, wo, wi);
    weight *= f.a > 0.0 ? f.r / f.a : 0.0;
    d = normalize(frame * wi);
    left = wi.z > 0.0;
    p = kSlab == 1 ? vec3(0.0, 0.0, -p.z) : normalize(p - 2.0 * dot(p, d) * d);
  }
  result[i] = vec4(weight, left ? 1.0 : 0.0, 0.0, 0.0);
}
"""


@pytest.mark.parametrize("slab", [0, 1])
@pytest.mark.parametrize("alpha", [0.0, 0.05, 0.2, 0.5])
@pytest.mark.parametrize("ior", [1.0, 1.1, 1.5, 0.75, 2.4])
def test_furnace_of_a_body_of_clear_glass(kernel_runner, slab, alpha, ior):
    """All light comes back, inside as outside, smooth or rough (where masking takes up to half of it)."""
    count = 1 << 15
    out = kernel_runner.run(
        GLASS_BODY,
        {0: np.zeros((count, 4), np.float32)},
        (count // 64,),
        push=np.array([alpha, ior], np.float32).tobytes(),
        spec={0: slab},
        texel=lobe_table(kernel_runner),
    )[0]
    left = out[:, 0] * out[:, 1]
    mean, error = left.mean(), left.std() / count**0.5
    if alpha == 0:
        assert 0.997 < mean < 1 + 1e-4
    else:
        assert abs(mean - 1) < 0.005 + 3 * error, f"{mean} +- {error}"
