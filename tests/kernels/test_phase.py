# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Henyey and Greenstein's phase function, free flights and their weights (lib/phase.glsl, lib/media.glsl)."""

from __future__ import annotations

import numpy as np
import pytest
from core_harness import call, chi2_p
from scipy.stats import kstest

PHASE = """
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/phase.glsl"
layout(local_size_x = 64) in;
layout(push_constant) uniform Push { vec4 direction; float g; uint count; };
layout(binding = 0, std430) buffer Numbers { vec4 numbers[]; };  // u, cosine to evaluate -> direction, value there
layout(binding = 1, std430) buffer Result { vec4 result[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  vec3 wi = phaseSample(g, direction.xyz, numbers[i].xy);
  result[i] = vec4(wi, phaseEval(g, numbers[i].z));
}
"""
# Whatever is stored as 12 bits, the ends included (lib/media.glsl), and the change of formula near 0.
ANISOTROPIES = [-0.999, -0.95, -0.5, -1.1e-3, -0.5e-3, 0.0, 1e-6, 2e-3, 0.3, 0.8, 0.99, 0.999]
COUNT = 1 << 16


def _phase(runner, g: float, direction: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    push = np.array([*direction, 0.0, g], np.float32).tobytes() + np.uint32(len(numbers)).tobytes()
    buffers = {0: numbers.astype(np.float32), 1: np.zeros((len(numbers), 4), np.float32)}
    return runner.run(PHASE, buffers, ((len(numbers) + 63) // 64,), push=push)[1].astype(np.float64)


def _cumulative(g: float, cosine: np.ndarray) -> np.ndarray:
    """Probability that the cosine is smaller: the phase function integrated over the sphere."""
    if abs(g) < 1e-5:
        return 0.5 * (1 + cosine)
    return (1 - g * g) / (2 * g) * (1 / np.sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g))


@pytest.mark.parametrize("g", ANISOTROPIES)
def test_phase_samples_follow_the_pdf(kernel_runner, g):
    """Chi-square over bins of (cosine, azimuth) of equal probability; and the value is that probability's density."""
    rng = np.random.default_rng(17)
    direction = np.array([0.48, -0.64, -0.6])
    cosines = np.linspace(-1, 1, COUNT)
    numbers = np.column_stack([rng.random((COUNT, 2)), cosines, np.zeros(COUNT)])
    out = _phase(kernel_runner, g, direction, numbers)
    wi = out[:, :3]
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1, atol=1e-6)
    x = np.array([0.8, 0.6, 0.0])
    cosine = wi @ direction
    azimuth = np.arctan2(wi @ np.cross(direction, x), wi @ x)
    if abs(g) < 0.99:
        bins = 16
        row = np.clip((_cumulative(g, np.clip(cosine, -1, 1)) * bins).astype(int), 0, bins - 1)
        column = np.clip(((azimuth / (2 * np.pi) + 0.5) * bins).astype(int), 0, bins - 1)
        counted = np.bincount(row * bins + column, minlength=bins * bins)
        expected = COUNT / bins**2
        statistic = float(((counted - expected) ** 2 / expected).sum())
        assert chi2_p(statistic, bins * bins - 1) > 0.01 / len(ANISOTROPIES), f"chi-square {statistic:.0f}"
    else:
        # The lobe is narrower than a cosine's rounding: angles, to the side that it points to.
        angle = np.linalg.norm(np.cross(wi, direction), axis=1)
        near = np.abs(cosine) > 0.9
        uniform = _cumulative(abs(g), np.sqrt(np.maximum(1 - angle[near] ** 2, 0)))
        assert (np.sign(cosine[near]) == np.sign(g)).mean() > 0.99
        below = _cumulative(abs(g), np.array([0.9]))[0]
        assert kstest((uniform - below) / (1 - below), "uniform").pvalue > 1e-4
    assert abs(cosine.mean() - g) < 4 * cosine.std() / COUNT**0.5 + 1e-3
    if abs(g) < 0.99:
        # Rounding counts where the lobe is narrow: 1 + g^2 - 2 g cos cancels.
        exact = (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosines) ** 1.5)
        np.testing.assert_allclose(out[:, 3], exact, rtol=2e-3)
        assert abs(2 * np.pi * np.trapezoid(out[:, 3], cosines) - 1) < 2e-3


FLIGHTS = """
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * IN >= inputs.length()) return;
  float u = inputs[i * IN].x, wall = inputs[i * IN].y;
  uvec4 medium = packMedium(Medium(inputs[i * IN + 1].rgb, inputs[i * IN + 2].rgb, 0.0));
  vec3 throughput = inputs[i * IN + 3].rgb;
  float flight = mediumFlight(medium, throughput, u), way = min(flight, wall);
  bool scatters = flight < wall;
  outputs[i * OUT] = vec4(mediumWeight(medium, throughput, way, scatters), scatters ? 1.0 : 0.0);
  // Cut in two by a surface that is passed.
  vec3 first = mediumWeight(medium, throughput, 0.5 * way, false);
  outputs[i * OUT + 1] = vec4(first * mediumWeight(medium, throughput * first, 0.5 * way, scatters), flight);
}
"""


@pytest.mark.parametrize("wall", [0.05, 1.0, 20.0])
@pytest.mark.parametrize("scattering", [(2.0, 0.5, 0.01), (0.0, 0.0, 3.0), (1.0, 1.0, 1.0)])
def test_flights_and_weights_are_the_transport_of_a_slab(kernel_runner, wall, scattering):
    """What crosses is exp(-extinction wall), what scatters the albedo times the rest, in every channel.

    No weight exceeds the reciprocal of its channel's chance, however far apart the channels are.
    """
    rng = np.random.default_rng(23)
    absorption, throughput = np.array([0.1, 0.0, 1.5]), np.array([0.2, 0.7, 0.9])
    rows = np.zeros((COUNT, 16), np.float32)
    rows[:, 0], rows[:, 1] = (np.arange(COUNT) + rng.random(COUNT)) / COUNT, wall
    rows[:, 4:7], rows[:, 8:11], rows[:, 12:15] = absorption, scattering, throughput
    out = call(kernel_runner, ["lib/media.glsl"], FLIGHTS, rows, 2).astype(np.float64)
    extinction = absorption + scattering
    crossed = np.exp(-extinction * wall)
    scattered = np.array(scattering) / np.maximum(extinction, 1e-30) * (1 - crossed)
    went = out[:, 3] > 0
    for mask, expected in ((~went, crossed), (went, scattered)):
        mean = (out[:, :3] * mask[:, None]).mean(0)
        np.testing.assert_allclose(mean, expected, rtol=2e-3, atol=2e-3)
    chance = throughput / throughput.sum()
    assert (out[:, :3] <= 1.001 / chance).all()
    np.testing.assert_allclose(out[:, 4:7], out[:, :3], rtol=2e-3, atol=1e-6)


def test_coefficients_that_are_no_numbers_count_as_none(kernel_runner):
    """NaN and negative: 0; infinite: the most there is (4e9). Whatever is finite comes back to 0.05 %."""
    main = """
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * IN >= inputs.length()) return;
  uvec4 medium = packMedium(Medium(inputs[i * IN].rgb, inputs[i * IN + 1].rgb, inputs[i * IN].a));
  outputs[i * OUT] = vec4(mediumScattering(medium), mediumAnisotropy(medium));
  outputs[i * OUT + 1] = vec4(mediumExtinction(medium), mediumScatters(medium) ? 1.0 : 0.0);
}
"""
    nan, inf = np.nan, np.inf
    rows = [  # absorption, anisotropy, scattering -> scattering, anisotropy, extinction, scatters
        ((nan, nan, nan), nan, (nan, nan, nan), (0, 0, 0), 0, (0, 0, 0), 0),
        ((-1, -inf, 2), 0.5, (nan, 3, -2), (0, 3, 0), 0.5, (0, 3, 2), 1),
        ((inf, nan, 1), inf, (0, 0, inf), (0, 0, 4e9), 0.999, (4e9, 0, 4e9), 1),
        ((1e-9, 1e9, 0), -inf, (1e-5, 1, 0), (1e-5, 1, 0), -0.999, (1.0001e-5, 1e9, 0), 1),
        ((inf, inf, inf), 2.0, (0, 0, 0), (0, 0, 0), 0.999, (4e9, 4e9, 4e9), 0),
    ]
    given = np.array([(*a, g, *s, 0) for a, g, s, *_ in rows], np.float32)
    expected = np.array([(*s, g, *e, scatters) for *_, s, g, e, scatters in rows], np.float32)
    out = call(kernel_runner, ["lib/media.glsl"], main, given, 2)
    np.testing.assert_allclose(out, expected, rtol=1e-3, atol=1e-12)
