# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Every row of bsdfs.def keeps the contract of lib/bsdf/bsdf_common.glsl: sampling, pdf, eval and albedo agree."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import pytest
from bsdf_cases import LOBES, VIEWS, albedo_tolerance, energy_bound, index_of, random_energy_bound, random_set
from bsdf_harness import Cells, Device, Lobe, integrate
from scipy.stats import chi2

SAMPLES = 16384
TRAIN = 2048  # samples that shape the cells; the others are counted in them
SIGNIFICANCE = 0.01  # for all tests of all rows together


@dataclass
class Measured:
    """What was measured of all configurations of a lobe: parameter sets times views."""

    labels: list[tuple[str, str]]
    wi: np.ndarray  # (configs, SAMPLES, 3)
    eval: np.ndarray  # (configs, SAMPLES, 4)
    valid: np.ndarray  # (configs, SAMPLES): the sample was not lost
    cells: Cells
    integrals: np.ndarray  # (cells, 4): rgb and pdf
    errors: np.ndarray
    albedo: np.ndarray  # (configs, 3)
    throughput: np.ndarray

    def per_config(self, values: np.ndarray) -> np.ndarray:
        out = np.zeros((len(self.labels), *values.shape[1:]))
        np.add.at(out, self.cells.config, values)
        return out


@functools.lru_cache(maxsize=len(LOBES))
def measure(runner, name: str) -> Measured:
    lobe = LOBES[name]
    labels = [(s, v) for s in lobe.sets for v in VIEWS]
    return measure_at(runner, lobe, labels, lobe.params([s for s, _ in labels]), np.array([VIEWS[v] for _, v in labels]))


def measure_at(runner, lobe: Lobe, labels: list[tuple[str, str]], params: np.ndarray, wo: np.ndarray) -> Measured:
    device = Device(runner, lobe)
    wi, values = device.sample(params, wo, SAMPLES)
    valid = (wi**2).sum(-1) > 0.5
    cells = Cells.of(wi, valid, TRAIN, 5)
    integrals, errors = integrate(device, params, wo, cells)
    albedo, throughput = device.albedo(params, wo)
    return Measured(labels, wi, values, valid, cells, integrals, errors, albedo, throughput)


@pytest.fixture(params=sorted(LOBES))
def lobe(request) -> Lobe:
    return LOBES[request.param]


@pytest.fixture
def measured(kernel_runner, lobe) -> Measured:
    return measure(kernel_runner, lobe.name)


def test_every_row_has_cases():
    assert LOBES
    for lobe in LOBES.values():
        assert lobe.make and lobe.sets, f"{lobe.name} has no entry in bsdf_cases.py"


def chi_square(measured: Measured) -> list[float]:
    """p values per configuration; the last bin holds lost samples and cells too small or too uncertain."""
    total = SAMPLES - TRAIN
    p_values = []
    for config in range(len(measured.labels)):
        here = measured.cells.config == config
        expected = measured.integrals[here, 3] * total
        counted = measured.cells.counts[here]
        good = (expected > 10) & (measured.errors[here, 3] * total < 0.5 * np.sqrt(np.maximum(expected, 1)))
        rest = total - expected[good].sum()
        assert rest > -4 * np.sqrt(total), f"{measured.labels[config]}: the pdf integrates to more than 1"
        statistic = (((counted - expected)[good]) ** 2 / expected[good]).sum()
        bins = good.sum()
        if rest > 10:
            statistic += (total - counted[good].sum() - rest) ** 2 / rest
            bins += 1
        p_values.append(chi2.sf(statistic, max(bins - 1, 1)) if bins > 1 else 1.0)
    return p_values


def test_samples_follow_the_pdf(measured: Measured):
    p_values = chi_square(measured)
    tests = sum(len(other.sets) for other in LOBES.values()) * len(VIEWS)
    limit = 1 - (1 - SIGNIFICANCE) ** (1 / tests)  # Sidak
    worst = int(np.argmin(p_values))
    assert p_values[worst] > limit, f"{measured.labels[worst]}: p = {p_values[worst]:.3g}, limit {limit:.3g}"


def test_bins_are_many(measured: Measured, lobe: Lobe):
    """The chi-square test means something: most of the mass is in bins of their own."""
    total = SAMPLES - TRAIN
    good = measured.errors[:, 3] * total < 0.5 * np.sqrt(np.maximum(measured.integrals[:, 3] * total, 1))
    mass = measured.per_config(measured.integrals * good[:, None])[:, 3]
    kept = measured.valid.mean(1)
    bad = [(label, m, k) for label, m, k in zip(measured.labels, mass, kept, strict=True) if m < 0.8 * k - 0.01]
    assert not bad, bad


def test_pdf_and_lost_samples_make_one(measured: Measured):
    pdf = measured.per_config(measured.integrals)[:, 3]
    error = measured.per_config(measured.errors)[:, 3]
    lost = 1 - measured.valid.mean(1)
    sigma = np.sqrt(lost * (1 - lost) / SAMPLES)
    for label, p, e, f, s in zip(measured.labels, pdf, error, lost, sigma, strict=True):
        assert abs(p + f - 1) < 0.003 + 5 * s + 4 * e, f"{label}: pdf {p:.4f} + lost {f:.4f}"


def test_pdf_is_positive_where_a_sample_went(measured: Measured):
    pdf = measured.eval[..., 3]
    none = measured.valid & ~(pdf > 0)
    assert none.sum() <= 2e-4 * measured.valid.sum(), f"{none.sum()} samples have no pdf"
    assert np.all(measured.eval[~measured.valid] == 0)
    length = np.linalg.norm(measured.wi[measured.valid].astype(np.float64), axis=-1)
    np.testing.assert_allclose(length, 1, atol=2e-6)


def test_weights_average_to_the_integral_of_eval(measured: Measured):
    good = measured.valid & (measured.eval[..., 3] > 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        weight = np.where(good[..., None], measured.eval[..., :3] / measured.eval[..., 3:], 0).astype(np.float64)
    mean, sigma = weight.mean(1), weight.std(1) / np.sqrt(SAMPLES)
    integral = measured.per_config(measured.integrals)[:, :3]
    error = measured.per_config(measured.errors)[:, :3]
    off = np.abs(mean - integral) - (0.002 + 0.003 * integral + 5 * sigma + 4 * error)
    worst = np.unravel_index(off.argmax(), off.shape)
    assert off[worst] < 0, f"{measured.labels[worst[0]]}: sampled {mean[worst[0]]}, integrated {integral[worst[0]]}"


def test_albedo_is_the_integral_of_eval(measured: Measured, lobe: Lobe):
    integral = measured.per_config(measured.integrals)[:, :3]
    error = measured.per_config(measured.errors)[:, :3]
    for label, a, i, e in zip(measured.labels, measured.albedo, integral, error, strict=True):
        tolerance = albedo_tolerance(lobe, label[0]) * np.maximum(i, 1) + 4 * e
        assert np.all(np.abs(a - i) < tolerance), f"{label}: albedo {a}, integral {i}"


def test_no_lobe_makes_energy(measured: Measured, lobe: Lobe):
    integral = measured.per_config(measured.integrals)[:, :3]
    error = measured.per_config(measured.errors)[:, :3]
    for label, i, e in zip(measured.labels, integral, error, strict=True):
        assert np.all(i < energy_bound(lobe, label[0]) + 0.001 + 4 * e), f"{label}: {i}"
        assert np.all(i >= 0)


def test_sides(measured: Measured, lobe: Lobe):
    """transmissive in bsdfs.def is the truth, and reflection lobes work on both sides."""
    other = []
    for (_, view), wi, valid in zip(measured.labels, measured.wi, measured.valid, strict=True):
        side = np.sign(VIEWS[view][2])
        other.append(bool((wi[valid][:, 2] * side < 0).any()))
    assert any(other) == lobe.transmissive


def test_what_a_layer_lets_through(measured: Measured, lobe: Lobe):
    """White lobes that MaterialX layers let through what they do not reflect; all others nothing."""
    assert np.all((measured.throughput >= 0) & (measured.throughput <= 1))
    layered = {"dielectricReflection", "generalizedSchlick", "sheenContyKulla", "sheenZeltner"}
    if lobe.name not in layered:
        assert np.all(measured.throughput == 0)
        return
    integral = measured.per_config(measured.integrals)[:, :3]
    error = measured.per_config(measured.errors)[:, :3]
    for label, t, i, e in zip(measured.labels, measured.throughput, integral, error, strict=True):
        if label[0] in ("coloured", "tinted"):
            assert t[0] == t[1] == t[2], f"{label}: a tint colours what lies below"
            continue
        tolerance = albedo_tolerance(lobe, label[0]) + 4 * e.mean()
        assert abs(t.mean() - max(1 - i.mean(), 0)) < tolerance + 0.002, f"{label}: through {t}, reflected {i}"


def _random_directions(rng: np.random.Generator, count: int) -> np.ndarray:
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def test_reciprocity(kernel_runner, lobe: Lobe):
    """f(wo, wi) n_o^2 = f(wi, wo) n_i^2 where bsdfs.def says so; where it does not, it must not hold by accident."""
    count = 4096
    rng = np.random.default_rng(7)
    names = list(lobe.sets)
    device = Device(kernel_runner, lobe)
    # Each configuration is one pair of directions here.
    labels = [names[i % len(names)] for i in range(count)]
    params = lobe.params(labels)
    a, b = _random_directions(rng, count), _random_directions(rng, count)
    b[: count // 2] *= np.sign(a[:, 2] * b[:, 2])[: count // 2, None]
    forth = device.evaluate(params, a, np.arange(count), b)[:, :3].astype(np.float64)
    back = device.evaluate(params, b, np.arange(count), a)[:, :3].astype(np.float64)
    n = np.array([index_of(lobe, name) for name in labels])
    na, nb = np.where(a[:, 2] < 0, n, 1), np.where(b[:, 2] < 0, n, 1)
    forth *= (na**2 / np.maximum(np.abs(b[:, 2]), 1e-3))[:, None]
    back *= (nb**2 / np.maximum(np.abs(a[:, 2]), 1e-3))[:, None]
    usable = (np.abs(a[:, 2]) > 0.01) & (np.abs(b[:, 2]) > 0.01)
    off = np.abs(forth - back)[usable] / np.maximum(np.maximum(forth, back)[usable], 1e-2)
    assert (forth[usable] > 1e-3).any(), "no pair sees the lobe"
    if lobe.reciprocal:
        assert off.max() < 5e-3, off.max()
    else:
        assert off.max() > 0.05, "bsdfs.def could claim reciprocity"


BAD = [float("nan"), float("inf"), float("-inf"), -1.0, 0.0, 1.0, 1e30, 1e-30]


def test_degenerate_input_gives_finite_output(kernel_runner, lobe: Lobe):
    """NaN, infinite, negative and extreme parameters; wo in the surface; wi equal or opposite to wo."""
    rng = np.random.default_rng(3)
    count = 2000
    base = lobe.params(list(lobe.sets))[rng.integers(0, len(lobe.sets), count)]
    bad = np.array(BAD, np.float32)[rng.integers(0, len(BAD), base.shape)]
    params = np.where(rng.random(base.shape) < 0.3, bad, base).astype(np.float32)
    wo = _random_directions(rng, count).astype(np.float32)
    wo[::3, 2] = 0.0
    wo[1::6] = [0.0, 0.0, 1.0]
    wo[2::6] = [0.0, 0.0, -1.0]
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    device = Device(kernel_runner, lobe)
    wi = _random_directions(rng, count)
    wi[::4] = wo[::4]
    wi[1::4] = -wo[1::4]
    wi[2::8, 2] = 0.0
    for values in (
        device.evaluate(params, wo, np.arange(count), wi),
        *device.albedo(params, wo),
        *device.sample(params, wo, 8),
    ):
        assert np.isfinite(values).all()
    values = device.evaluate(params, wo, np.arange(count), wi)
    assert (values >= 0).all()
    samples, _ = device.sample(params, wo, 8)
    length = np.linalg.norm(samples, axis=-1)
    assert np.all((length == 0) | (np.abs(length - 1) < 1e-5))


RANDOM = 12  # parameter sets a lobe


def test_random_parameters(kernel_runner, lobe: Lobe):
    """Parameters and views at random, ends of the ranges and beyond: samples follow the pdf, and no energy is made."""
    rng = np.random.default_rng(sum(lobe.name.encode()))
    params = np.zeros((RANDOM, 16), np.float32)
    for row in params:
        values = random_set(lobe.name, rng)
        row[: len(values)] = values
    wo = _random_directions(rng, RANDOM)
    wo[: RANDOM // 2, 2] = np.abs(wo[: RANDOM // 2, 2])
    labels = [(str(np.round(p, 3).tolist()), str(np.round(w, 3))) for p, w in zip(params, wo, strict=True)]
    measured = measure_at(kernel_runner, lobe, labels, params, wo)
    for values in (measured.wi, measured.eval, measured.albedo, measured.throughput):
        assert np.isfinite(values).all()
    limit = 1 - (1 - SIGNIFICANCE) ** (1 / (RANDOM * len(LOBES)))
    for label, p in zip(labels, chi_square(measured), strict=True):
        assert p > limit, f"{label}: p = {p:.3g}"
    sums, errors = measured.per_config(measured.integrals), measured.per_config(measured.errors)
    for label, s, e in zip(labels, sums, errors, strict=True):
        assert np.all(s[:3] < random_energy_bound(lobe) + 0.002 + 4 * e[:3]), f"{label}: albedo {s[:3]}"
        assert np.all(s >= 0) and s[3] < 1.003 + 4 * e[3], f"{label}: {s}"
