# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Lights for the tests, and what UsdLux says about them in numpy: shapes as parametric surfaces, shaping, textures."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


def rotation(axis, degrees: float) -> np.ndarray:
    """Column-vector rotation (Rodrigues)."""
    k = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    t = np.radians(degrees)
    return np.eye(3) + np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross


def affine(linear, translation=(0.0, 0.0, 0.0)) -> np.ndarray:
    m = np.eye(4)
    m[:3, :3] = linear
    m[:3, 3] = translation
    return m


ROTATED = rotation((1, 2, 0.5), 50)
SHEAR = np.array([[1, 0.6, 0.2], [0, 1, 0.3], [0, 0, 1]])
MIRROR = np.diag([-1.0, 1, 1])


@dataclass
class Case:
    """A light; `matrix` is light to world with column vectors."""

    name: str
    kind: str
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))
    radiance: tuple[float, float, float] = (2.0, 3.0, 5.0)
    width: float = 1.0
    height: float = 1.0
    radius: float = 0.5
    length: float = 1.0
    cone: tuple[float, float] | None = None  # cutoff angle in degrees, softness
    focus: float = 0.0
    tint: tuple[float, float, float] = (0.0, 0.0, 0.0)
    texture: np.ndarray | None = None  # (height, width, 4) uint8, row 0 at the bottom

    def record(self, texture_id: int | None) -> dict:
        data = dict(
            type=self.kind,
            path="/" + self.name,
            transform=list(self.matrix.T.ravel()),
            radiance=list(self.radiance),
            width=self.width,
            height=self.height,
            radius=self.radius,
            length=self.length,
            focus=self.focus,
            focusTint=list(self.tint),
        )
        if self.cone is not None:
            data.update(coneAngle=float(np.radians(self.cone[0])), coneSoftness=self.cone[1])
        if texture_id is not None:
            data["texture"] = texture_id
        return data

    def unit_size(self) -> np.ndarray:
        """Light space per unit of the unit shape, per axis."""
        return np.array(
            {
                "rect": (self.width, self.height, 1),
                "disk": (self.radius,) * 3,
                "sphere": (self.radius,) * 3,
                "cylinder": (self.length, self.radius, self.radius),
            }[self.kind]
        )

    def surface(self, s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and outward normals in light space at parameters in [0, 1]^2."""
        zero = np.zeros_like(s)
        if self.kind == "rect":
            p = np.stack([(s - 0.5) * self.width, (t - 0.5) * self.height, zero], -1)
            return p, np.broadcast_to([0.0, 0, -1], p.shape)
        if self.kind == "disk":
            r, a = self.radius * np.sqrt(s), 2 * np.pi * t
            p = np.stack([r * np.cos(a), r * np.sin(a), zero], -1)
            return p, np.broadcast_to([0.0, 0, -1], p.shape)
        a = 2 * np.pi * t
        if self.kind == "sphere":
            z = 1 - 2 * s
            n = np.stack([np.sqrt(1 - z * z) * np.cos(a), np.sqrt(1 - z * z) * np.sin(a), z], -1)
            return self.radius * n, n
        n = np.stack([zero, np.cos(a), np.sin(a)], -1)
        return self.radius * n + np.stack([(s - 0.5) * self.length, zero, zero], -1), n

    def parameters(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inverse of surface: (s, t) of points in light space."""
        if self.kind == "rect":
            return p[:, 0] / self.width + 0.5, p[:, 1] / self.height + 0.5
        if self.kind == "disk":
            return (p[:, 0] ** 2 + p[:, 1] ** 2) / self.radius**2, np.mod(np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi), 1)
        if self.kind == "sphere":
            n = p / np.linalg.norm(p, axis=1, keepdims=True)
            return (1 - n[:, 2]) / 2, np.mod(np.arctan2(n[:, 1], n[:, 0]) / (2 * np.pi), 1)
        return p[:, 0] / self.length + 0.5, np.mod(np.arctan2(p[:, 2], p[:, 1]) / (2 * np.pi), 1)

    def elements(self, cells: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """World points, outward area vectors and light-space points of a grid of cells x cells midpoints.

        The area of each cell comes from differences of the mapped surface, not from the kernels' formulas.
        """
        m = (np.arange(cells) + 0.5) / cells
        s, t = (a.ravel() for a in np.meshgrid(m, m, indexing="ij"))
        p, n = self.surface(s, t)
        h = 1e-5
        linear = self.matrix[:3, :3]
        ds = (self.surface(s + h, t)[0] - self.surface(s - h, t)[0]) @ linear.T / (2 * h)
        dt = (self.surface(s, t + h)[0] - self.surface(s, t - h)[0]) @ linear.T / (2 * h)
        area = np.cross(ds, dt) / cells**2
        outward = (area * (n @ linear.T)).sum(1)
        area *= np.sign(outward)[:, None]
        return p @ linear.T + self.matrix[:3, 3], area, p

    def emitted(self, local: np.ndarray, emission: np.ndarray) -> np.ndarray:
        """Radiance (n, 3) that leaves light-space points in world directions (unit)."""
        out = np.broadcast_to(np.array(self.radiance, float), (len(local), 3)).copy()
        if self.texture is not None:
            # Seen from the front (-Z side, +Y up), +X is on the left: u grows to the viewer's right, v upwards.
            u, v = 0.5 - local[:, 0] / self.width, 0.5 + local[:, 1] / self.height
            out *= bilinear_clamped(self.texture, u, v, repeat_u=False)
        e = emission @ np.linalg.inv(self.matrix[:3, :3]).T
        cosine = -e[:, 2] / np.linalg.norm(e, axis=1)
        if self.cone is not None:
            cutoff, softness = np.radians(self.cone[0]), self.cone[1]
            angle = np.arccos(np.clip(cosine, -1, 1))
            start = cutoff + (0 - cutoff) * softness  # lerp(cutoff, 0, softness)
            x = np.clip((angle - start) / max(cutoff - start, 1e-9), 0, 1)
            out *= (1 - x * x * (3 - 2 * x))[:, None]
        if self.focus > 0:
            k = np.maximum(cosine, 0) ** self.focus
            out *= np.array(self.tint) + (1 - np.array(self.tint)) * k[:, None]
        return out

    def seen_from(self, p: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions from p to the grid, solid angles (0 where the back is seen), radiance towards p."""
        points, area, local = self.elements(cells)
        d = points - p
        distance2 = (d * d).sum(1)
        w = d / np.sqrt(distance2)[:, None]
        solid = np.maximum(0, -(area * w).sum(1)) / distance2
        return w, solid, self.emitted(local, -w)


def bilinear_clamped(texture: np.ndarray, u: np.ndarray, v: np.ndarray, repeat_u: bool) -> np.ndarray:
    h, w = texture.shape[:2]
    values = texture[..., :3].astype(float) / 255
    x, y = u * w - 0.5, v * h - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    total = np.zeros((len(u), 3))
    for dx in (0, 1):
        for dy in (0, 1):
            xi = np.mod(x0 + dx, w) if repeat_u else np.clip(x0 + dx, 0, w - 1)
            yi = np.clip(y0 + dy, 0, h - 1)
            weight = (x - x0 if dx else 1 - x + x0) * (y - y0 if dy else 1 - y + y0)
            total += weight[:, None] * values[yi, xi]
    return total


def picture(width: int, height: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(20, 256, (height, width, 4)).astype(np.uint8)


AREA_CASES = [
    Case("rect", "rect", affine(ROTATED, (0.3, 0.2, 3)), width=1.4, height=0.6),
    Case("rectMirrored", "rect", affine(ROTATED @ MIRROR, (0.3, 0.2, 3)), width=1.4, height=0.6),
    Case("rectScaled", "rect", affine(ROTATED @ np.diag([2.0, 0.5, 3]), (0, 0, 4)), width=0.8, height=1.3),
    Case("rectSheared", "rect", affine(ROTATED @ SHEAR, (0.3, 0.2, 3)), width=1.4, height=0.6),
    Case("rectTextured", "rect", affine(ROTATED, (0, 0, 2.5)), width=2, height=1.5, texture=picture(8, 6, 1)),
    Case("rectTexturedMirrored", "rect", affine(MIRROR, (0, 0, 2.5)), width=2, height=1.5, texture=picture(8, 6, 2)),
    Case("rectCone", "rect", affine(rotation((1, 0, 0), 10), (0, 0, 2)), width=1, height=1, cone=(40, 0.5)),
    Case("rectHardCone", "rect", affine(np.eye(3), (0, 0, 2)), width=0.2, height=0.2, cone=(30, 0)),
    Case("rectFocus", "rect", affine(np.eye(3), (0.5, 0, 2)), width=1, height=1, focus=3.5, tint=(0.5, 0.1, 0.0)),
    Case("rectHuge", "rect", affine(np.eye(3), (0, 0, 1)), width=30, height=20),
    Case("rectFar", "rect", affine(ROTATED, (3, 4, 60)), width=1, height=2),
    Case("disk", "disk", affine(ROTATED, (0, 0.3, 2.5)), radius=0.7),
    Case("diskSheared", "disk", affine(ROTATED @ SHEAR @ MIRROR, (0, 0.3, 2.5)), radius=0.7),
    Case("diskShaped", "disk", affine(np.eye(3), (0, 0, 2)), cone=(60, 1.0), focus=2, tint=(0.2, 0.2, 0.9)),
    Case("sphere", "sphere", affine(ROTATED * 1.5, (0, 0, 2.5)), radius=0.5),
    Case("sphereMirrored", "sphere", affine(ROTATED @ MIRROR, (0, 0, 2)), radius=0.8, cone=(100, 0.5)),
    Case("sphereFar", "sphere", affine(ROTATED, (0, 0, 200)), radius=0.5),
    Case("sphereStretched", "sphere", affine(ROTATED @ np.diag([0.5, 1.5, 1]), (0, 0, 3)), radius=0.6),
    Case("sphereSheared", "sphere", affine(SHEAR, (0, 0, 3)), radius=0.6, focus=1.5, tint=(0.3, 0.3, 0.3)),
    Case("cylinder", "cylinder", affine(ROTATED, (0, 0, 2.5)), radius=0.3, length=2),
    Case("cylinderStretched", "cylinder", affine(ROTATED @ np.diag([1, 0.4, 2]), (0, 0, 3)), radius=0.5, length=1.5),
    Case("cylinderSheared", "cylinder", affine(SHEAR @ MIRROR, (0, 0, 3)), radius=0.4, length=1.5),
]
# Points on the front side of every light above (planes face -Z, roughly), one of them near, with a surface normal.
VIEWS = [
    (np.array([0.1, -0.2, 0.0]), np.array([0.0, 0.0, 1.0])),
    (np.array([1.5, 0.4, 0.3]), np.array([-0.6, 0.0, 0.8])),
    (np.array([-1.0, 2.0, -1.0]), np.array([0.36, -0.48, 0.8])),
]
