# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Triangle meshes as arrays: what the scenes of the benchmark are built of. No randomness; right-handed, y up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass
class Mesh:
    """points (n, 3), triangles (m, 3), and normals (n, 3) at the points, or None where every triangle is flat."""

    points: Array
    triangles: npt.NDArray[np.int32]
    normals: Array | None = None

    @property
    def size(self) -> int:
        return len(self.triangles)

    def moved(self, offset: Sequence[float]) -> Mesh:
        return Mesh(self.points + np.asarray(offset, float), self.triangles, self.normals)

    def scaled(self, factors: Sequence[float]) -> Mesh:
        """Factors must be positive: orientation is kept."""
        scale = np.asarray(factors, float)
        normals = None if self.normals is None else _unit(self.normals / scale)
        return Mesh(self.points * scale, self.triangles, normals)

    def turned(self, axis: int, degrees: float) -> Mesh:
        """About an axis of coordinates, counterclockwise as it comes to the viewer."""
        angle = np.radians(degrees)
        c, s = np.cos(angle), np.sin(angle)
        matrix = np.eye(3)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
        normals = None if self.normals is None else self.normals @ matrix.T
        return Mesh(self.points @ matrix.T, self.triangles, normals)


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def merge(meshes: Iterable[Mesh]) -> Mesh:
    """One mesh of several; all of them with normals, or all without."""
    parts = list(meshes)
    offsets = np.cumsum([0, *(len(m.points) for m in parts[:-1])])
    triangles = np.concatenate([m.triangles + o for m, o in zip(parts, offsets, strict=True)]).astype(np.int32)
    normals = [m.normals for m in parts if m.normals is not None]
    if normals and len(normals) != len(parts):
        raise ValueError("meshes with normals and meshes without cannot be one")
    return Mesh(np.concatenate([m.points for m in parts]), triangles, np.concatenate(normals) if normals else None)


def smooth(mesh: Mesh) -> Mesh:
    """With normals that are the area-weighted means over the triangles of each point."""
    corners = mesh.points[mesh.triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(mesh.points)
    for corner in range(3):
        np.add.at(normals, mesh.triangles[:, corner], faces)
    return Mesh(mesh.points, mesh.triangles, _unit(normals))


def surface(points: Array, closed_u: bool = False, closed_v: bool = False) -> Mesh:
    """Smooth, of a grid of points (nu, nv, 3); it faces cross(d/du, d/dv). Closed: the last row joins the first."""
    rows, columns = points.shape[:2]
    u = np.arange(rows if closed_u else rows - 1)
    v = np.arange(columns if closed_v else columns - 1)
    i, j = (a.ravel() for a in np.meshgrid(u, v, indexing="ij"))
    k, m = (i + 1) % rows, (j + 1) % columns
    a, b, c, d = i * columns + j, k * columns + j, k * columns + m, i * columns + m
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    flat = points.reshape(-1, 3)
    corners = flat[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return smooth(Mesh(flat, triangles[area > 1e-14]))


def box(size: Sequence[float], center: Sequence[float] = (0, 0, 0)) -> Mesh:
    """12 flat triangles."""
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(signs * np.asarray(size, float) + np.asarray(center, float), np.array(triangles, np.int32))


def quad(corner: Sequence[float], u: Sequence[float], v: Sequence[float]) -> Mesh:
    """Two flat triangles that face cross(u, v)."""
    p, a, b = (np.asarray(x, float) for x in (corner, u, v))
    return Mesh(np.stack([p, p + a, p + a + b, p + b]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def ellipsoid(radii: Sequence[float], rings: int, sides: int) -> Mesh:
    """2 sides (rings - 1) triangles."""
    theta = np.linspace(0, np.pi, rings + 1)
    profile = np.stack([np.sin(theta), -np.cos(theta)], 1)
    return lathe(profile, sides).scaled(radii)


def lathe(profile: npt.ArrayLike, sides: int) -> Mesh:
    """Turns (radius, height) pairs about y; smooth. The outside is on the right of the profile's way, seen with the
    radius to the right and the height upward."""
    outline = np.asarray(profile, float)
    angle = -np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = np.stack([np.cos(angle), np.zeros(sides), np.sin(angle)], 1)
    points = outline[:, None, :1] * ring[None] + outline[:, None, 1:] * np.array([0.0, 1, 0])
    return surface(points.transpose(1, 0, 2), closed_u=True)


def torus(radius: float, tube_radius: float, sides: int, tube_sides: int) -> Mesh:
    """About y; 2 sides tube_sides triangles."""
    return tube(
        [(radius * np.cos(a), 0, -radius * np.sin(a)) for a in np.linspace(0, 2 * np.pi, sides, endpoint=False)],
        tube_radius,
        tube_sides,
        closed=True,
    )


def tube(path: npt.ArrayLike, radius: float, sides: int, closed: bool = False) -> Mesh:
    """Open at its ends, which want to stand inside of something."""
    line = np.asarray(path, float)
    if closed:
        along = np.roll(line, -1, 0) - np.roll(line, 1, 0)
    else:
        along = np.gradient(line, axis=0)
    along = _unit(along)
    # A frame that turns as little as it must: each normal is the one before, made perpendicular.
    start = np.eye(3)[int(np.argmin(np.abs(along[0])))]
    normals = []
    for direction in along:
        start = start - direction * np.dot(start, direction)
        start = start / np.linalg.norm(start)
        normals.append(start)
    n = np.array(normals)
    b = np.cross(along, n)
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    circle = np.cos(angle)[None, :, None] * n[:, None] + np.sin(angle)[None, :, None] * b[:, None]
    points = line[:, None] + radius * circle
    return surface(points.transpose(1, 0, 2), closed_u=True, closed_v=closed)


def rounded_box(size: Sequence[float], radius: float, steps: int) -> Mesh:
    """A box of smooth edges: each of the six sides has (2 steps + 1)² cells, of which the middle ones are flat."""
    half = np.asarray(size, float) / 2 - radius
    angle = np.radians(np.linspace(-45, 45, steps + 1))
    ticks = np.tan(angle)
    signs = np.concatenate([np.full(steps + 1, -1.0), np.full(steps + 1, 1.0)])
    # On the cube, the lower half of the ticks belongs to the low corner, the upper half to the high one.
    values = np.concatenate([(ticks - 1) / 2, (ticks + 1) / 2])
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            cube = np.zeros((len(values), len(values), 3))
            corner = np.zeros_like(cube)
            cube[..., i], cube[..., j] = np.meshgrid(values, values, indexing="ij")
            corner[..., i], corner[..., j] = np.meshgrid(signs, signs, indexing="ij")
            cube[..., axis], corner[..., axis] = sign, sign
            direction = _unit(cube)
            points = corner * half + radius * direction
            if sign < 0:
                points, direction = points.transpose(1, 0, 2), direction.transpose(1, 0, 2)
            side = surface(points)
            sides.append(Mesh(side.points, side.triangles, direction.reshape(-1, 3)))
    return merge(sides)


def loft(sections: Sequence[npt.ArrayLike]) -> Mesh:
    """Smooth, through closed sections (n, 3) of equally many points, which end it as they are."""
    return surface(np.stack([np.asarray(s, float) for s in sections]), closed_v=True)


def superellipse(half_width: float, half_height: float, exponent: float, sides: int) -> Array:
    """(sides, 2), counterclockwise; exponent 2 is the ellipse, larger ones come near the rectangle."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    radius = (np.abs(c) ** exponent + np.abs(s) ** exponent) ** (-1 / exponent)
    return np.stack([half_width * radius * c, half_height * radius * s], 1)


def extruded(outline: npt.ArrayLike, height: float, bevel: float, steps: int) -> Mesh:
    """A convex outline (n, 2) in x and z as a plate from y = 0 to `height`, its edges rounded by `bevel`."""
    flat = np.asarray(outline, float)
    center = flat.mean(0)
    angle = np.linspace(0, np.pi / 2, steps + 1)
    inset = [(1.0, 0.0), *((bevel * (1 - np.sin(a)), bevel * (1 - np.cos(a))) for a in angle)]
    inset[0] = (1e9, 0.0)
    inset += [(bevel * (1 - np.cos(a)), height - bevel * (1 - np.sin(a))) for a in angle]
    inset.append((1e9, height))
    reach = np.linalg.norm(flat - center, axis=1, keepdims=True)
    rings = []
    for depth, y in inset:
        ring = center + (flat - center) * np.maximum(1 - depth / reach, 0)
        rings.append(np.stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]], 1))
    return surface(np.stack(rings).transpose(1, 0, 2)[::-1], closed_u=True)
