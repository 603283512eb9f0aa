# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The Fresnel terms of thin films against the exact Airy sum, integrated over the spectrum."""

from __future__ import annotations

import numpy as np

FILM = """
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "lib/bsdf/thin_film.glsl"
layout(local_size_x = 64) in;
layout(binding = 0, std430) buffer In { vec4 values[]; };  // cosine, -, film | base n, base k
layout(binding = 1, std430) buffer Out { vec4 result[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec4 a = values[2 * i], b = values[2 * i + 1];
  SchlickFresnel s = schlickFresnelMake(vec3(0.3), vec3(1.0), vec3(0.9), 5.0);
  result[3 * i] = vec4(fresnelConductor(a.x, vec3(b.x), vec3(b.y), a.zw), 0.0);
  result[3 * i + 1] = vec4(fresnelDielectric(a.x, b.x, a.zw), fresnelDielectric(a.x, b.x));
  result[3 * i + 2] = vec4(fresnelSchlick(a.x, s, a.zw).rgb, fresnelSchlick(a.x, s).r);
}
"""

# The sensitivities of Belcour and Barla 2017: Gaussians of the wavenumber; (centre, variance, height), x has two.
SENSITIVITIES = (
    ((1.6810e6, 4.3278e9, 0.84659), (2.2399e6, 4.5282e9, 0.15387)),
    ((1.7953e6, 9.3046e9, 1.00022),),
    ((2.2084e6, 6.6121e9, 1.00112),),
)
TO_RGB = np.array(
    [[2.3706743, -0.9000405, -0.4706338], [-0.5138850, 1.4253036, 0.0885814], [0.0052982, -0.0146949, 1.0093968]]
)


def evaluate(runner, cos, thickness, film, n, k) -> np.ndarray:
    """(n, 3, 4): conductor, dielectric (plain term in w), Schlick (likewise)."""
    count = len(cos)
    values = np.zeros(((count + 63) // 64 * 64, 2, 4), np.float32)
    values[:count, 0] = np.stack([cos, np.zeros(count), thickness, film], -1)
    values[:count, 1, :2] = np.stack([n, k], -1)
    result = np.zeros((len(values), 3, 4), np.float32)
    return runner.run(FILM, {0: values, 1: result}, (len(values) // 64,))[1][:count]


def airy(cos: float, thickness: float, film: float, base: complex) -> np.ndarray:
    """RGB of |r12 + r23 e^id|^2 / |1 + r12 r23 e^id|^2 over the spectrum, both polarisations."""
    cos2 = np.sqrt(1 - (1 - cos**2) / film**2)
    cos3 = np.sqrt(1 - (1 - cos**2) / base**2 + 0j)
    s12, s23 = (cos - film * cos2) / (cos + film * cos2), (film * cos2 - base * cos3) / (film * cos2 + base * cos3)
    p12 = (film * cos - cos2) / (film * cos + cos2)
    p23 = (base * cos2 - film * cos3) / (base * cos2 + film * cos3)
    path = 2 * film * cos2 * thickness * 1e-9
    xyz = np.zeros(3)
    for channel, gaussians in enumerate(SENSITIVITIES):
        for centre, variance, height in gaussians:
            x = np.linspace(-5, 5, 801)
            weight = np.exp(-0.5 * x**2)
            phase = np.exp(2j * np.pi * path * (centre + np.sqrt(2 * variance) * x))
            power = [np.abs((a + b * phase) / (1 + a * b * phase)) ** 2 for a, b in ((s12, s23), (p12, p23))]
            xyz[channel] += height * (weight * sum(power)).sum() / (2 * weight.sum())
    return np.clip(TO_RGB @ xyz, 0, 1)


def test_film_is_the_spectral_airy_sum(kernel_runner):
    rng = np.random.default_rng(4)
    count = 256
    cos, thickness = rng.uniform(0.05, 1, count), rng.uniform(50, 1200, count)
    film, n, k = rng.uniform(1.2, 2.2, count), rng.uniform(1.1, 2.5, count), rng.uniform(0, 4, count)
    out = evaluate(kernel_runner, cos, thickness, film, n, k)
    for i in range(count):
        # Three bounces: what comes later is smaller with a dielectric base.
        metal = airy(cos[i], thickness[i], film[i], n[i] + 1j * k[i])
        glass = airy(cos[i], thickness[i], film[i], n[i] + 0j)
        assert np.abs(out[i, 1, :3] - glass).max() < 0.02, f"{cos[i]} {thickness[i]} {film[i]} {n[i]}"
        assert np.abs(out[i, 0, :3] - metal).max() < 0.08, f"{cos[i]} {thickness[i]} {film[i]} {n[i]} {k[i]}"


def test_film_that_is_not_there(kernel_runner):
    """Of the index of vacuum, or of no thickness: the plain interface. Of the base's index: the base."""
    rng = np.random.default_rng(6)
    count = 256
    cos, n, k = rng.uniform(0.1, 1, count), rng.uniform(1.2, 2.5, count), rng.uniform(0, 4, count)
    thickness = rng.uniform(100, 1000, count)
    vacuum = evaluate(kernel_runner, cos, thickness, np.ones(count), n, k)
    none = evaluate(kernel_runner, cos, np.zeros(count), np.full(count, 1.5), n, k)
    same = evaluate(kernel_runner, cos, thickness, n, n, k)
    np.testing.assert_allclose(none[:, 1:, :3], none[:, 1:, 3:] * np.ones(3), atol=1e-6)
    for channel in range(3):
        np.testing.assert_allclose(vacuum[:, :, channel], none[:, :, channel], atol=0.003)
        np.testing.assert_allclose(same[:, 1, channel], none[:, 1, channel], atol=0.003)
