# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Fits the functions of wavefront/kernels/lib/bsdf/{ggx_albedo,sheen_albedo}.glsl and prints their numbers.

Needs numpy and scipy; some minutes. Run it after a change of the microfacet model, paste, and run tests/kernels.
Everything is fitted to quadrature: visible normals on a regular grid for GGX, Gauss-Legendre for sheen.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

MUS = np.concatenate([[0.001, 0.004, 0.01, 0.02, 0.035], np.linspace(0.05, 1, 24)])
ALPHAS = np.concatenate([[0.001, 0.003, 0.01, 0.02, 0.03, 0.045, 0.06, 0.08], np.linspace(0.1, 1, 19)])
OUTER = np.array([1.05, 1.1, 1.2, 1.33, 1.5, 1.7, 2, 2.5, 3, 4])
POWERS = (2.0, 5.0, 10.0)  # (1 - cos)^p: Schlick


def fresnel(c: np.ndarray, n: float) -> np.ndarray:
    g2 = n * n + c * c - 1
    g = np.sqrt(np.maximum(g2, 0))
    rs = (c - g) / np.maximum(c + g, 1e-20)
    rp = (n * n * c - g) / np.maximum(n * n * c + g, 1e-20)
    return np.where(g2 > 0, (rs * rs + rp * rp) / 2, 1)


def smith(z: np.ndarray | float, alpha: float) -> np.ndarray:
    return (np.sqrt(1 + alpha**2 * (1 - z * z) / np.maximum(z * z, 1e-12)) - 1) / 2


def visible_normals(mu: float, alpha: float, n: int = 160) -> tuple[np.ndarray, np.ndarray]:
    """z of normals visible from cosine mu (spherical caps, equal weights), and their cosines with the view."""
    phi, v = np.meshgrid((np.arange(n) + 0.5) / n * np.pi, (np.arange(n) + 0.5) / n, indexing="ij")
    s = np.sqrt(1 - mu * mu)
    w = np.array([s * alpha, 0, mu])
    w /= np.linalg.norm(w)
    z = (1 - v) * (1 + w[2]) - w[2]
    r = np.sqrt(np.clip(1 - z * z, 0, 1))
    m = np.stack([alpha * (r * np.cos(phi) + w[0]), alpha * r * np.sin(phi), z + w[2]], -1)
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    return m[..., 2], m[..., 0] * s + m[..., 2] * mu


def measure() -> dict[str, np.ndarray]:
    """Per (mu, alpha): E; mean, deviation, skew of the cosine; per index R, compensated R; per power its mean."""
    rows: dict[str, list] = {k: [] for k in ("e", "moments", "rc", "r_outer", "power")}
    for mu in MUS:
        for alpha in ALPHAS:
            mz, c = visible_normals(mu, alpha)
            lo = smith(mu, alpha)

            def masked(z: np.ndarray, lo=lo, alpha=alpha) -> np.ndarray:
                return np.where(z > 0, (1 + lo) / (1 + lo + smith(np.clip(z, 1e-7, 1), alpha)), 0) / z.size

            w = masked(2 * c * mz - mu)
            e = w.sum()
            mean = (w * c).sum() / e
            var = max((w * (c - mean) ** 2).sum() / e, 1e-20)
            rows["e"].append(e)
            rows["moments"].append((mean, np.sqrt(var), (w * (c - mean) ** 3).sum() / e / var**1.5))
            f = [fresnel(c, n) for n in OUTER]
            rows["r_outer"].append([(w * x).sum() for x in f])
            rows["rc"].append([(w * x * (1 + x * (1 - e) / e)).sum() for x in f])
            rows["power"].append([(w * (1 - c) ** p).sum() for p in POWERS])
    return {k: np.array(v) for k, v in rows.items() if v}


def minimax(basis: np.ndarray, target: np.ndarray, weight: np.ndarray, rounds: int) -> np.ndarray:
    """Linear fit with the smallest greatest error (Lawson's reweighting)."""
    w = np.ones_like(target)
    best, found = np.inf, np.zeros(basis.shape[1])
    for _ in range(rounds):
        c = np.linalg.lstsq(basis * (w * weight)[:, None], target * w * weight, rcond=1e-12)[0]
        error = np.abs(basis @ c - target) * weight
        if error.max() < best:
            best, found = error.max(), c
        w *= np.sqrt(np.maximum(error / error.max(), 1e-3))
        w = np.maximum(w / w.max(), 1e-2)
    return found


MU, ALPHA = (g.ravel() for g in np.meshgrid(MUS, ALPHAS, indexing="ij"))
RATIO = MU / (MU + ALPHA)


def tensor(a: int, b: int) -> np.ndarray:
    return np.stack([RATIO**i * ALPHA**j for i in range(a + 1) for j in range(b + 1)], -1)


def fit_nodes(data: dict[str, np.ndarray]) -> np.ndarray:
    """Two cosines and a share (rows of coefficients), from Gauss's two-point rule on, refined on the albedos."""
    basis = tensor(4, 2)
    n = basis.shape[1]
    e = data["e"]
    mean, deviation, skew = data["moments"].T
    skew = np.clip(skew, -3, 3)
    d = np.sqrt(skew**2 + 4)
    low, high = (skew - d) / 2, (skew + d) / 2
    w = np.minimum(deviation, 0.3) + 1e-3

    def ridge(f: np.ndarray) -> np.ndarray:
        a = np.concatenate([basis * w[:, None], 3e-3 * np.eye(n)])
        return np.linalg.lstsq(a, np.concatenate([f * w, np.zeros(n)]), rcond=1e-10)[0]

    starts = ((mean + deviation * low - MU) / ALPHA, (mean + deviation * high - MU) / ALPHA, high / (high - low))
    theta = np.concatenate([ridge(f) for f in starts])
    target = np.concatenate([data["rc"], data["r_outer"], data["power"]], 1)

    def model(theta: np.ndarray) -> np.ndarray:
        c1, c2 = (np.clip(MU + ALPHA * (basis @ theta[k * n : (k + 1) * n]), 0, 1) for k in (0, 1))
        p = np.clip(basis @ theta[2 * n :], 0, 1)
        f = [(fresnel(c1, i), fresnel(c2, i)) for i in OUTER]
        compensated = [p * a * (e + a * (1 - e)) + (1 - p) * b * (e + b * (1 - e)) for a, b in f]
        single = [e * (p * a + (1 - p) * b) for a, b in f]
        powers = [e * (p * (1 - c1) ** q + (1 - p) * (1 - c2) ** q) for q in POWERS]
        return np.stack(compensated + single + powers, 1)

    importance = np.ones(target.shape[1])
    importance[[-3, -1]] = 0.4
    weight = np.tile(importance, (len(target), 1))
    best, found = np.inf, theta
    for k in range(20):

        def residual(th: np.ndarray, weight=weight) -> np.ndarray:
            return np.concatenate([((model(th) - target) * weight).ravel(), 2e-5 * th])

        theta = least_squares(residual, theta, max_nfev=25 if k == 0 else 10).x
        error = np.abs(model(theta) - target) * importance
        if error.max() < best:
            best, found = error.max(), theta.copy()
        weight = weight * np.sqrt(np.maximum(error / error.max(), 0.03))
        weight = np.maximum(weight / weight.max(), 0.05)
    print(f"// nodes: greatest error {best:.4f}")
    return found.reshape(3, n)


def anisotropic(mu: float, azimuth: float, wide: float, narrow: float, n: int = 40) -> float:
    """Albedo for F = 1; azimuth 0: the view is in the plane of the greater alpha."""
    sine = np.sqrt(1 - mu * mu)
    wo = np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), mu])
    stretch = np.array([wide, narrow, 1])
    w = stretch * wo / np.linalg.norm(stretch * wo)
    phi, v = np.meshgrid((np.arange(2 * n) + 0.5) / n * np.pi, (np.arange(n) + 0.5) / n, indexing="ij")
    z = (1 - v) * (1 + w[2]) - w[2]
    r = np.sqrt(np.clip(1 - z * z, 0, 1))
    m = stretch * np.stack([r * np.cos(phi) + w[0], r * np.sin(phi) + w[1], z + w[2]], -1)
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    wi = 2 * (m @ wo)[..., None] * m - wo
    so = np.linalg.norm(stretch * wo)
    si = np.linalg.norm(stretch * wi, axis=-1)
    mask = wi[..., 2] * (mu + so) / np.maximum(wi[..., 2] * so + mu * si, 1e-12)
    return float(np.where(wi[..., 2] > 0, mask, 0).mean())


UNITS = 12  # of the network


def fit_anisotropic(albedo: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """Weights of the network of ggxAlbedo(wo, alpha): 6 rows of UNITS inputs, UNITS outputs, bias."""

    def cases(seed: int, count: int) -> np.ndarray:
        rng = np.random.default_rng(seed)
        mu = rng.random(count) ** 1.5 * 0.99 + 0.005
        azimuth = rng.uniform(0, np.pi / 2, count)
        wide = rng.uniform(0.05, 1, count) ** 1.5
        narrow = np.maximum(wide * rng.uniform(0.08, 1, count), 0.005)
        values = [anisotropic(*row) for row in zip(mu, azimuth, wide, narrow, strict=True)]
        return np.array([mu, azimuth, wide, narrow, values])

    def error(weights: np.ndarray, rows: np.ndarray) -> np.ndarray:
        mu, azimuth, wide, narrow, target = rows
        inputs = [np.cos(azimuth) ** 2, mu / (mu + wide), mu / (mu + narrow), wide, narrow, np.ones_like(mu)]
        hidden = np.stack(inputs, -1) @ weights[: 6 * UNITS].reshape(6, UNITS)
        correction = (hidden / (1 + np.abs(hidden))) @ weights[6 * UNITS : 7 * UNITS] + weights[-1]
        base = albedo(mu, np.sqrt((wide**2 + narrow**2) / 2))
        return base * np.exp((1 - narrow / wide) * correction) / target - 1

    train, test = cases(0, 7000), cases(1, 3000)

    def asymmetric(weights: np.ndarray) -> np.ndarray:
        off = error(weights, train) - 0.006
        # An albedo that is too small makes energy.
        return np.where(off < 0, 3, 1) * np.sign(off) * np.abs(off) ** 1.6

    start = np.random.default_rng(3).normal(0, 0.7, 7 * UNITS + 1)
    first = least_squares(lambda w: error(w, train), start, max_nfev=120).x
    found = least_squares(asymmetric, first, max_nfev=100).x
    low, high = np.quantile(error(found, test), (0.01, 0.99))
    print(f"// anisotropic: relative error {low:.4f} to {high:.4f} (quantiles 0.01, 0.99)")
    return found


def sheen(mu: float, r: float, n: int = 256) -> float:
    """Albedo of the Estevez-Kulla lobe as MaterialX has it."""
    x, w = np.polynomial.legendre.leggauss(n)
    z, wz = ((x + 1) / 2) ** 2, w * (x + 1) / 2
    phi, wp = np.pi * ((x + 1) / 2) ** 2, np.pi * w * (x + 1) / 2
    cos_i, azimuth = np.meshgrid(z, phi, indexing="ij")
    si = np.sqrt(1 - cos_i**2)
    h = (np.sqrt(1 - mu * mu) + si * np.cos(azimuth)) ** 2 + (si * np.sin(azimuth)) ** 2
    d = (2 + 1 / r) * (h / (h + (mu + cos_i) ** 2)) ** (0.5 / r) / (2 * np.pi)
    return float(2 * (wz[:, None] * wp * d * cos_i / (4 * (cos_i + mu - cos_i * mu))).sum())


def fit_sheen() -> tuple[list[tuple[int, int]], np.ndarray, list[tuple[int, int]], np.ndarray]:
    """p / (1 + q), q without negative coefficients: the numerator is solved for, the denominator searched."""
    mus = np.concatenate([[0.002, 0.01, 0.025], np.linspace(0.05, 1, 20)])
    rs = np.concatenate([[0.005, 0.01, 0.02, 0.03, 0.05, 0.07], np.linspace(0.1, 1, 19)])
    x, r = (g.ravel() for g in np.meshgrid(mus, rs, indexing="ij"))
    y = np.sqrt(r)
    target = np.array([sheen(*pair) for pair in zip(x, r, strict=True)])
    importance = np.where(r < 0.06, 0.35, 1) / np.maximum(target, 1)
    terms_p = [(i, k - i) for k in range(5) for i in range(k, -1, -1)]
    terms_q = [(i, k - i) for k in range(1, 4) for i in range(k, -1, -1)]
    p, q = (np.stack([x**i * y**j for i, j in terms], -1) for terms in (terms_p, terms_q))

    def solve(root: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a = p / (1 + q @ root**2)[:, None]
        c = np.linalg.lstsq(a * w[:, None], target * w, rcond=1e-11)[0]
        return c, a @ c - target

    rng = np.random.default_rng(0)
    best, found = np.inf, (np.zeros(p.shape[1]), np.zeros(q.shape[1]))
    for _ in range(2):
        root, w = np.sqrt(np.exp(rng.normal(0, 1.5, q.shape[1]))), importance.copy()
        for k in range(12):
            search: Callable = lambda v, w=w: solve(v, w)[1] * w  # noqa: E731
            root = least_squares(search, root, max_nfev=60 if k == 0 else 8).x
            c, error = solve(root, w)
            error = np.abs(error) * importance
            if error.max() < best:
                best, found = error.max(), (c.copy(), root**2)
            w = w * np.sqrt(np.maximum(error / error.max(), 0.03))
            w = np.maximum(w / w.max(), 0.03 * importance / importance.max())
    print(f"// sheen: greatest error {best:.4f}")
    return terms_p, found[0], terms_q, found[1]


def horner(coefficients: np.ndarray, a: int, b: int) -> str:
    """sum c[i, j] t^i a^j as GLSL."""

    def nest(values: list[str], variable: str) -> str:
        out = values[-1]
        for value in reversed(values[:-1]):
            out = f"{value} + {variable} * ({out})" if " " in out else f"{value} + {variable} * {out}"
        return out

    table = coefficients.reshape(a + 1, b + 1)
    return nest([nest([f"{c:.6g}" for c in row], "a") for row in table], "t")


def main() -> None:
    data = measure()
    fit = minimax(tensor(5, 3), data["e"], 1 / data["e"], 200)
    print("ggxAlbedo:", horner(fit, 5, 3))

    def isotropic(mu: np.ndarray, alpha: np.ndarray) -> np.ndarray:
        t = mu / (mu + alpha)
        powers = np.stack([t**i * alpha**j for i in range(6) for j in range(4)], -1)
        return np.maximum(powers @ fit, 1 - (1 + alpha * (6 - alpha)) * (1 - t) ** 2)

    for name, row in zip(("c1", "c2", "s"), fit_nodes(data), strict=True):
        print(f"ggxMean {name}:", horner(row, 4, 2))
    weights = fit_anisotropic(isotropic)
    rows = weights[: 7 * UNITS].reshape(7, UNITS)[[5, 0, 1, 2, 3, 4, 6]]
    for name, row in zip(("1", "azimuth", "t.x", "t.y", "wide", "narrow", "output"), rows, strict=True):
        print(f"ggxAlbedo(wo, alpha) {name}:", ", ".join(f"{v:.6g}" for v in row))
    print(f"bias: {weights[-1]:.6g}")
    terms_p, p, terms_q, q = fit_sheen()
    for name, terms, values in (("p", terms_p, p), ("q - 1", terms_q, q)):
        print(f"sheen {name}, powers of (x, y):", {t: float(f"{v:.6g}") for t, v in zip(terms, values, strict=True)})


if __name__ == "__main__":
    main()
