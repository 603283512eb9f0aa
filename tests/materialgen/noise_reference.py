# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""MaterialX's noises on numpy arrays, written from their published descriptions, in double precision.

Lattice hash: Bob Jenkins, "lookup3" (2006), final() and mix() over 32-bit words. Gradient noise: Ken Perlin, "Improving
Noise" (2002), with Jenkins' hash. Cellular noise: Steven Worley, "A Cellular Texture Basis Function" (1996).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Array = np.ndarray
U = np.uint32


def _rotate(x: Array, k: int) -> Array:
    return (x << U(k)) | (x >> U(32 - k))


def jenkins(words: list[Array]) -> Array:
    """lookup3's hashword() of up to five words, with its start value and length in words times four."""
    a, b, c = (np.full(np.broadcast(*words).shape, (0xDEADBEEF + 4 * len(words) + 13) & 0xFFFFFFFF, U) for _ in "abc")
    words = [np.asarray(w).astype(np.int64).astype(U) for w in words]
    with np.errstate(over="ignore"):
        if len(words) > 3:
            a, b, c = a + words[0], b + words[1], c + words[2]
            for shift in (4, 6, 8, 16, 19, 4):  # mix(): each line, then the letters move on
                a = a - c
                a = a ^ _rotate(c, shift)
                c = c + b
                a, b, c = b, c, a
            words = words[3:]
        a = a + words[0]
        b = b + words[1] if len(words) > 1 else b
        c = c + words[2] if len(words) > 2 else c
        for shift in (14, 11, 25, 16, 4, 14, 24):  # final()
            c = (c ^ b) - _rotate(b, shift)
            a, b, c = b, c, a
        return b  # the word that the last line wrote


def unit(words: list[Array]) -> Array:
    return jenkins(words) / 0xFFFFFFFF


def cell(p: Array, channels: int = 1) -> Array:
    at = list(np.floor(p).T)
    if channels == 1:
        return unit(at)[:, None]
    return np.stack([unit([*at, np.full(len(p), c)]) for c in range(channels)], -1)


def _gradient(h: Array, offset: list[Array]) -> Array:
    if len(offset) == 2:
        x, y = offset
        low = (h & 7) < 4
        u, v = np.where(low, x, y), 2 * np.where(low, y, x)
    else:
        x, y, z = offset
        h = h & 15
        u = np.where(h < 8, x, y)
        v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, z))
    return np.where(h & 1, -u, u) + np.where(h & 2, -v, v)


def perlin(p: Array, channels: int = 1) -> Array:
    """(n, channels); one channel uses the whole hash, three use its bytes, as MaterialX does."""
    base = np.floor(p)
    f = p - base
    weight = f**3 * (f * (f * 6 - 15) + 10)
    total = np.zeros((len(p), channels))
    dimensions = p.shape[1]
    for corner in np.ndindex(*(2,) * dimensions):
        c = np.array(corner)
        h = jenkins(list((base + c).T)).astype(np.int64)
        w = np.prod(np.where(c, weight, 1 - weight), 1)
        for k in range(channels):
            byte = h if channels == 1 else (h >> (8 * k)) & 255
            total[:, k] += w * _gradient(byte, list((f - c).T))
    return total * (0.6616 if dimensions == 2 else 0.9820)


def wide(noise: Callable[[Array, int], Array], p: Array, channels: int, shift: tuple[float, ...]) -> Array:
    """Four channels: three, and one at a shifted place."""
    if channels < 4:
        return noise(p, channels)
    return np.concatenate([noise(p, 3), noise(p + np.array(shift), 1)], 1)


def fractal(p: Array, channels: int, octaves: int, lacunarity: Array, diminish: Array) -> Array:
    total, amplitude = np.zeros((len(p), channels)), np.ones((len(p), 1))
    for _ in range(octaves):
        total += amplitude * perlin(p, channels)
        amplitude = amplitude * diminish
        p = p * lacunarity
    return total


def worley(p: Array, channels: int, jitter: Array, style: int) -> Array:
    """Distances to the nearest features (style 0), or the noise of the cell where the nearest lies (style 1)."""
    base = np.floor(p)
    local = p - base
    offsets = np.array(list(np.ndindex(*(3,) * p.shape[1]))) - 1
    found = []
    for offset in offsets:
        at = base + offset
        random = cell(at, 3)[:, : p.shape[1]]
        found.append(offset + (random - 0.5) * jitter + 0.5 - local)
    to = np.stack(found, 1)
    squared = (to**2).sum(-1)
    if style == 1:
        nearest = to[np.arange(len(p)), squared.argmin(1)]
        return cell(nearest + p, 1 if channels == 1 else 3)[:, :channels]
    return np.sqrt(np.sort(squared, 1)[:, :channels])


def _turned(v: Array, random: Array) -> Array:
    """Arvo, "Fast Random Rotation Matrices" (Graphics Gems III, 1992): a turn about z, then a reflection."""
    theta, phi, z = 2 * np.pi * random[:, 0], 2 * np.pi * random[:, 1], 2 * random[:, 2]
    pole = np.stack([np.sin(phi) * np.sqrt(z), np.cos(phi) * np.sqrt(z), np.sqrt(2 - z)], 1)
    c, s, none = np.cos(theta), np.sin(theta), np.zeros(len(v))
    turn = np.stack([np.stack([c, s, none], 1), np.stack([-s, c, none], 1), np.stack([none, none, none + 1], 1)], 1)
    matrix = (pole[:, :, None] * pole[:, None, :] - np.eye(3)) @ turn
    return np.einsum("nji,nj->ni", matrix, v)  # MaterialX multiplies by the transpose


def flakes(p: Array, coverage: Array) -> dict[str, Array]:
    """The uppermost flake over each point: MaterialX's flake nodes. Cubes about cell centres, randomly turned."""
    x = np.clip(coverage, 0, 1)
    probability = (-26.19771808 * x**2 + 26.39663835 * x) / (
        85.53857017 * x**3 - 102.35069432 * x**2 - 101.42634862 * x + 118.45082288
    )
    size, base = 1.5 / np.sqrt(3), np.floor(p)
    best, where = np.zeros((len(p), 1)), np.zeros(p.shape)
    for offset in np.ndindex(3, 3, 3):
        at = base + np.array(offset) - 1
        local = p - at - 0.5
        priority = cell(np.concatenate([at, np.full((len(p), 1), 3.0)], 1))
        inside = (np.abs(_turned(local, cell(at, 3))) <= size).all(1, keepdims=True)
        near = (local**2).sum(1, keepdims=True) < 3 * size**2
        wins = inside & near & (cell(at) <= probability) & (priority >= best)
        best, where = np.where(wins, priority, best), np.where(wins, at, where)
    random = cell(np.concatenate([where, np.full((len(p), 1), 2.0)], 1), 3)
    return {"there": best > 0, "priority": best, "random": random}
