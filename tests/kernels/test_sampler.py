# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""lib/sampler.glsl: every pair of dimensions is an Owen-scrambled (0,2)-sequence, and pairs and pixels know nothing of
each other."""

from __future__ import annotations

import numpy as np
import pytest
from core_harness import bits, call, chi2_p

INCLUDES = ["lib/sampler.glsl"]
PAIRS = [0, 1, 4, 5, 7, 8, 9, 104]  # camera, lens, the first bounces' picks and points, and a bounce far down
POINTS = 1024


def points(runner, pixel_seed: np.ndarray, index: np.ndarray, pair: np.ndarray) -> np.ndarray:
    """sample2D for each row, and sample1D in the third column."""
    inputs = np.zeros((len(index), 4), np.float32)
    inputs[:, 0], inputs[:, 1], inputs[:, 2] = bits(pixel_seed), bits(index), bits(pair)
    main = """void main() {
      uint i = gl_GlobalInvocationID.x;
      if (i >= inputs.length()) return;
      uvec4 a = floatBitsToUint(inputs[i]);
      outputs[i] = vec4(sample2D(a.x, a.y, a.z), sample1D(a.x, a.y, a.z), 0.0);
    }"""
    return call(runner, INCLUDES, main, inputs, 1)[:, :3].astype(np.float64)


def seeds(runner, x: np.ndarray, y: np.ndarray, seed: int = 0) -> np.ndarray:
    inputs = np.zeros((len(x), 4), np.float32)
    inputs[:, 0], inputs[:, 1], inputs[:, 2] = bits(x), bits(y), bits(np.full(len(x), seed))
    main = """void main() {
      uint i = gl_GlobalInvocationID.x;
      if (i >= inputs.length()) return;
      uvec4 a = floatBitsToUint(inputs[i]);
      outputs[i] = vec4(uintBitsToFloat(pixelSeed(a.x, a.y, a.z)), 0.0, 0.0, 0.0);
    }"""
    return np.ascontiguousarray(call(runner, INCLUDES, main, inputs, 1)[:, 0]).view(np.uint32)


@pytest.fixture(scope="module")
def sets(kernel_runner) -> np.ndarray:
    """(pixels, pairs, POINTS, 3) of 16 pixels in a 4 x 4 block."""
    y, x = np.mgrid[100:104, 200:204]
    s = seeds(kernel_runner, x.ravel(), y.ravel())
    pixel, pair, index = np.meshgrid(s, np.array(PAIRS, np.uint32), np.arange(POINTS, dtype=np.uint32), indexing="ij")
    return points(kernel_runner, pixel.ravel(), index.ravel(), pair.ravel()).reshape(16, len(PAIRS), POINTS, 3)


def test_points_lie_in_the_half_open_unit_square(sets):
    assert sets.min() >= 0.0
    assert sets.max() < 1.0


@pytest.mark.parametrize("count", [4, 16, 64, 256, 1024])
def test_each_pair_is_a_net_at_every_power_of_two(sets, count):
    """One point in every elementary interval of area 1/count, for every aligned block of samples."""
    k = count.bit_length() - 1
    for start in range(0, POINTS, count):
        block = sets[:, :, start : start + count, :2]
        for split in range(k + 1):
            cell = np.floor(block[..., 0] * 2**split) * 2 ** (k - split) + np.floor(block[..., 1] * 2 ** (k - split))
            assert (np.sort(cell, axis=-1) == np.arange(count)).all(), f"{2**split} x {2 ** (k - split)} strata"


def test_second_dimension_is_sobols(kernel_runner):
    """Every bit of it, by the recurrence of its direction numbers: v[0] = 2^31, v[k + 1] = v[k] ^ (v[k] >> 1)."""
    rng = np.random.default_rng(11)
    index = np.concatenate([1 << np.arange(32, dtype=np.uint64), rng.integers(0, 2**32, 2000, dtype=np.uint64)])
    expected, v, rest = np.zeros_like(index), 1 << 31, index.copy()
    for _ in range(32):
        expected ^= np.where(rest & np.uint64(1), np.uint64(v), np.uint64(0))
        rest >>= np.uint64(1)
        v ^= v >> 1
    halves = np.stack([index & np.uint64(0xFFFF), index >> np.uint64(16)], 1)
    inputs = np.zeros((len(index), 4), np.float32)
    inputs[:, :2] = halves  # as numbers: patterns of NaNs would not arrive
    main = """void main() {
      uint i = gl_GlobalInvocationID.x;
      if (i >= inputs.length()) return;
      uint y = sobol2OfReversed(bitfieldReverse(uint(inputs[i].x) | uint(inputs[i].y) << 16));
      outputs[i] = vec4(float(y & 0xffffu), float(y >> 16), 0.0, 0.0);
    }"""
    out = call(kernel_runner, INCLUDES, main, inputs, 1)[:, :2].astype(np.uint64)
    assert (out[:, 0] | out[:, 1] << np.uint64(16) == expected).all()


def test_one_dimensional_samples_are_stratified(sets):
    for count in (2, 8, 32, 1024):
        strata = np.sort(np.floor(sets[:, :, :count, 2] * count), axis=-1)
        assert (strata == np.arange(count)).all()


def test_single_samples_of_many_pixels_are_uniform_and_independent(kernel_runner):
    """The first sample over 256 x 256 pixels: uniform in every pair, no correlation between pairs nor neighbours."""
    y, x = np.mgrid[0:256, 0:256]
    s = seeds(kernel_runner, x.ravel(), y.ravel())
    assert len(np.unique(s)) > len(s) - 10  # a few collisions of 32-bit hashes are chance
    pairs = PAIRS[:6]
    columns = []
    for pair in pairs:
        p = points(kernel_runner, s, np.zeros(len(s)), np.full(len(s), pair))
        counts = np.bincount((np.floor(p[:, 0] * 16) * 16 + np.floor(p[:, 1] * 16)).astype(int), minlength=256)
        expected = len(s) / 256
        assert chi2_p(float(((counts - expected) ** 2 / expected).sum()), 255) > 1e-4, f"pair {pair}"
        columns += [p[:, 0], p[:, 1]]
    matrix = np.stack(columns)
    shifted = np.concatenate([matrix, np.roll(matrix.reshape(-1, 256, 256), 1, 2).reshape(len(matrix), -1)])
    correlation = np.corrcoef(shifted) - np.eye(len(shifted))
    assert np.abs(correlation).max() < 5.0 / np.sqrt(len(s))


def test_pairs_of_one_pixel_are_independent(sets):
    """Across pairs, points of equal index must not fall together: joint histogram of x of one pair, y of another."""
    for a in range(len(PAIRS)):
        for b in range(a):
            # 16 pixels x 1024 points in 8 x 8 cells; both marginals are exact, which leaves 49 degrees of freedom.
            cells = np.floor(sets[:, a, :, 0] * 8) * 8 + np.floor(sets[:, b, :, 1] * 8)
            counts = np.bincount(cells.ravel().astype(int), minlength=64)
            expected = 16 * POINTS / 64
            statistic = float(((counts - expected) ** 2 / expected).sum())
            assert chi2_p(statistic, 49) > 1e-5, (PAIRS[a], PAIRS[b])


def test_neighbouring_pixels_and_seeds_differ(kernel_runner, sets):
    """No two pixels of a block share a scramble, and another seed gives other points."""
    flat = sets[:, :, :16, :2].reshape(16, -1)
    assert len(np.unique(flat, axis=0)) == 16
    one = seeds(kernel_runner, np.array([5]), np.array([7]), 0)
    two = seeds(kernel_runner, np.array([5]), np.array([7]), 1)
    assert one[0] != two[0]


def test_samples_depend_on_pixel_sample_and_pair_alone(kernel_runner):
    """Order and place in the dispatch change nothing."""
    rng = np.random.default_rng(3)
    seed = rng.integers(0, 2**32, 4096, dtype=np.uint32)
    index = rng.integers(0, 2**20, 4096, dtype=np.uint32)
    pair = rng.integers(0, 200, 4096, dtype=np.uint32)
    order = rng.permutation(4096)
    first = points(kernel_runner, seed, index, pair)
    second = points(kernel_runner, seed[order], index[order], pair[order])
    assert (first[order] == second).all()


def test_integration_error_falls_like_a_net(sets):
    """A smooth integral over 1024 points: scrambled nets err far below random's 1/sqrt(n)."""
    x, y = sets[..., 0], sets[..., 1]
    estimate = (np.exp(-x * y) * np.cos(2 * x)).mean(-1)
    u = (np.arange(4096) + 0.5) / 4096
    exact = (np.exp(-u[:, None] * u[None, :]) * np.cos(2 * u[:, None])).mean()
    rms = np.sqrt(((estimate - exact) ** 2).mean())
    random = 0.45 / np.sqrt(POINTS)  # the integrand's standard deviation is about 0.45
    assert rms < random / 30


def test_passes_are_uniform(kernel_runner):
    """samplePass: numbers of the surfaces passed through, by bounce and pass."""
    n = 1 << 16
    rng = np.random.default_rng(5)
    inputs = np.zeros((n, 4), np.float32)
    inputs[:, 0] = bits(rng.integers(0, 2**32, n, dtype=np.uint32))
    inputs[:, 1] = bits(rng.integers(0, 64, n))
    main = """void main() {
      uint i = gl_GlobalInvocationID.x;
      if (i >= inputs.length()) return;
      uvec4 a = floatBitsToUint(inputs[i]);
      outputs[i] = vec4(samplePass(a.x, a.y, 0u, 0u), samplePass(a.x, a.y, 0u, 1u), samplePass(a.x, a.y, 1u, 0u),
                        samplePass(a.x, a.y, 1u, 1u));
    }"""
    u = call(kernel_runner, INCLUDES, main, inputs, 1).astype(np.float64)
    for c in range(4):
        counts = np.bincount((u[:, c] * 256).astype(int), minlength=256)
        assert chi2_p(float(((counts - n / 256) ** 2 / (n / 256)).sum()), 255) > 1e-4
    assert np.abs(np.corrcoef(u.T) - np.eye(4)).max() < 5 / np.sqrt(n)
