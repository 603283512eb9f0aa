# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What nodes give that read images, as node_reference has it: s["texture"] gives level 0 of a file as
(height, width, 4), row 0 at the bottom.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from reference_table import Array, Inputs, dot, join, leaf, mix, normalize


def wrapped(at: Array, size: int, mode: str) -> tuple[Array, Array]:
    """The texel inside, and whether the place itself is inside."""
    if mode in ("periodic", "repeat", "useMetadata"):
        return np.mod(at, size), np.ones(at.shape, bool)
    if mode == "mirror":
        folded = np.mod(at, 2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded), np.ones(at.shape, bool)
    return np.clip(at, 0, size - 1), (at >= 0) & (at < size) | (mode == "clamp")


def texel(image: Array, uv: Array, modes: tuple[str, str], outside: Array, kind: str = "linear") -> Array:
    """Linear, closest, or the uniform cubic B-spline."""
    height, width = image.shape[:2]
    p = uv * np.array([width, height]) - 0.5
    if kind == "closest":
        p = np.floor(p + 0.5)
    base = np.floor(p).astype(int)
    f = p - base
    if kind == "cubic":
        weights = {-1: (1 - f) ** 3 / 6, 0: (4 - 6 * f**2 + 3 * f**3) / 6}
        weights |= {1: (1 + 3 * f + 3 * f**2 - 3 * f**3) / 6, 2: f**3 / 6}
    else:
        weights = {0: 1 - f, 1: f}
    total = np.zeros((len(uv), 4))
    for dx, wx in weights.items():
        for dy, wy in weights.items():
            x, x_inside = wrapped(base[:, 0] + dx, width, modes[0])
            y, y_inside = wrapped(base[:, 1] + dy, height, modes[1])
            value = np.where((x_inside & y_inside)[:, None], image[y, x], outside)
            total += (wx[:, 0] * wy[:, 1])[:, None] * value
    return total


@leaf("image")
def image(i: Inputs, d: Any, s: Any) -> Array:
    count = np.shape(i["default"])[1]
    if not i["file"]:
        return i["default"]
    modes = (i["uaddressmode"], i["vaddressmode"])
    outside = join(i["default"], np.zeros((1, 4 - count))) if "constant" in modes else np.zeros((1, 4))
    kind = i.get("filtertype", "linear")
    return texel(s["texture"](i["file"]), i["texcoord"], modes, outside, kind)[:, :count]


def hex_tiles(i: Inputs) -> tuple[Array, list[Array], list[Array]]:
    """Mikkelsen, "Practical Real-Time Hex-Tiling" (2022): weights, and each tile's coordinates and angle."""
    uv = i["texcoord"] * i["tiling"]
    scale = 2 * np.sqrt(3)
    x, y = (uv * scale).T
    skewed = np.stack([x - y * 0.57735027, y * 1.15470054], 1)
    base = np.floor(skewed)
    inside = skewed - base
    rest = 1 - inside.sum(1, keepdims=True)
    upper = rest <= 0
    weights = np.where(
        upper, join(-rest, 1 - inside[:, 1:], 1 - inside[:, :1]), join(rest, inside[:, 1:], inside[:, :1])
    )
    corners = [np.where(upper, [1, 1], [0, 0]), np.where(upper, [1, 0], [0, 1]), np.where(upper, [0, 1], [1, 0])]
    places, angles = [], []
    for corner in corners:
        tile = base + corner
        # In single precision, as on devices: what is left of these numbers are their last bits.
        q = (join(tile, tile[:, :1]) + 0.12345).astype(np.float32) * np.array([0.1031, 0.1030, 0.0973], np.float32)
        q = q - np.floor(q)
        q = q + dot(q, q[:, [1, 2, 0]] + np.float32(33.33))
        random = (q[:, :1] + q[:, 1:]) * q[:, [2, 1]]
        random = random - np.floor(random)
        centre = np.stack([tile[:, 0] + 0.5 * tile[:, 1], tile[:, 1] / 1.15470054], 1) / scale
        low, high = i["rotationrange"][:, :1], i["rotationrange"][:, 1:]
        angle = np.radians(mix(low, high, random[:, :1] * i["rotation"]))
        size = mix(1.0, mix(i["scalerange"][:, :1], i["scalerange"][:, 1:], random[:, 1:]), i["scale"])
        away = uv - centre
        c, si = np.cos(angle), np.sin(angle)
        turned = join(c * away[:, :1] - si * away[:, 1:], si * away[:, :1] + c * away[:, 1:])
        shift = mix(i["offsetrange"][:, :1], i["offsetrange"][:, 1:], random * i["offset"])
        places.append(turned / size + centre + shift)
        angles.append(angle)
    return weights, places, angles


def hex_blend(contrast: Array, weights: Array, falloff: Array) -> Array:
    w = contrast * weights**7
    w = w / w.sum(1, keepdims=True)
    a = (1 / np.clip(falloff, 0.001, 0.999) - 2) * (1 - 2 * w)
    gained = np.where(w < 0.5, w / (a + 1), (a - w) / (a - 1))
    return np.where(falloff != 0.5, gained / gained.sum(1, keepdims=True), w)


@leaf("hextiledimage")
def hextiledimage(i: Inputs, d: Any, s: Any) -> Array:
    weights, places, _ = hex_tiles(i)
    texels = [texel(s["texture"](i["file"]), uv, ("periodic",) * 2, np.zeros(4)) for uv in places]
    bright = join(*(dot(t[:, :3], i["lumacoeffs"]) for t in texels))
    w = hex_blend(mix(1.0, bright, i["falloffcontrast"]), weights, i["falloff"])
    a = hex_blend(np.ones((1, 3)), weights, i["falloff"])
    color = sum(w[:, k : k + 1] * t[:, :3] for k, t in enumerate(texels))
    alpha = sum(a[:, k : k + 1] * t[:, 3:] for k, t in enumerate(texels))
    return join(color, alpha)[:, : np.shape(i["default"])[1]]


@leaf("hextilednormalmap")
def hextilednormalmap(i: Inputs, d: Any, s: Any) -> Array:
    """Surface gradients blended: Mikkelsen, "Surface Gradient-Based Bump Mapping Framework" (2020)."""
    weights, places, angles = hex_tiles(i)
    w = np.clip(hex_blend(np.ones((1, 3)), weights, i["falloff"]), 0, 1)
    n, gradient = i["normal"], 0
    for k, (uv, angle) in enumerate(zip(places, angles, strict=True)):
        t = texel(s["texture"](i["file"]), uv, ("periodic",) * 2, np.zeros(4))[:, :3]
        t = 2 * np.where(i["flip_g"] * np.array([0.0, 1.0, 0.0]) > 0, 1 - t, t) - 1

        def turn(v: Array, angle: Array = angle) -> Array:
            return v * np.cos(angle) + np.cross(n, v) * np.sin(angle) + n * dot(n, v) * (1 - np.cos(angle))

        bent = turn(i["tangent"]) * i["strength"] * t[:, :1] + turn(i["bitangent"]) * i["strength"] * t[:, 1:2]
        bent = normalize(bent + n * t[:, 2:])
        cosine = dot(n, bent)
        gradient = gradient + w[:, k : k + 1] * (cosine * n - bent) / np.maximum(np.abs(cosine), 1e-8)
    return normalize(n - gradient)
