# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Rays through the two-level BVH: against brute force, and what the traversal promises."""

from __future__ import annotations

import numpy as np
import pytest
from traversal_scene import (
    BRUTE_FORCE,
    CLOSEST,
    KIND_CYLINDER,
    KIND_DISK,
    KIND_RECT,
    KIND_SPHERE,
    NO_HIT,
    OPAQUE,
    SHADOW,
    Scene,
    box,
    bumpy_sphere,
    unit_vectors,
)

CLEAR, BLOCKED, NEEDS_OPACITY = range(3)


def soup(random, n, size=0.2):
    centres = random.uniform(-1, 1, (n, 1, 3))
    points = centres + random.uniform(-size, size, (n, 3, 3))
    return points.reshape(-1, 3), np.arange(3 * n).reshape(n, 3)


def slivers(random, n):
    """Needles: two corners nearly in one place, or all three nearly on one line."""
    points = random.uniform(-1, 1, (n, 3, 3))
    half = n // 2
    points[:half, 1] = points[:half, 0] + random.uniform(-1e-6, 1e-6, (half, 3))
    along = random.uniform(0, 1, (n - half, 1))
    points[half:, 2] = points[half:, 0] * along + points[half:, 1] * (1 - along)
    points[half:, 2] += random.uniform(-1e-6, 1e-6, (n - half, 3))
    return points.reshape(-1, 3), np.arange(3 * n).reshape(n, 3)


def random_transform(random, spread=2.0, mirror=False, decades=1.0):
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(random.normal(size=(3, 3)))[0]
    if (np.linalg.det(matrix) < 0) != mirror:
        matrix[:3, 0] *= -1
    matrix[:3, :3] = matrix[:3, :3] @ (np.eye(3) + 0.5 * random.uniform(-1, 1, (3, 3)))
    matrix[:3, :3] *= 10 ** random.uniform(-decades, decades) * 0.5
    matrix[:3, 3] = random.uniform(-spread, spread, 3)
    return matrix


def make_scene(runner, name) -> Scene:
    random = np.random.default_rng(sum(map(ord, name)))
    scene = Scene(runner)
    if name == "soup":
        scene.add_instance(scene.add_mesh(*soup(random, 2000)))
    elif name == "slivers":
        scene.add_instance(scene.add_mesh(*slivers(random, 2000)))
    elif name == "beams through clutter":
        # Triangles from side to side, which spatial splits cut, among small ones.
        beams, _ = soup(random, 60, 0.02)
        ends = unit_vectors(random, 60)
        beams.reshape(-1, 3, 3)[:, 0] = 1.2 * ends
        beams.reshape(-1, 3, 3)[:, 1] = -1.2 * ends + random.uniform(-0.2, 0.2, (60, 3))
        points = np.concatenate([beams, soup(random, 2000, 0.02)[0]])
        scene.add_instance(scene.add_mesh(points, np.arange(len(points)).reshape(-1, 3)))
    elif name == "coincident planes":
        # Grids in one plane, cut along different diagonals, and in instances one on the other.
        x, y = np.meshgrid(np.arange(9), np.arange(9))
        points = np.stack([x.ravel() / 4 - 1, y.ravel() / 4 - 1, np.zeros(81)], 1)
        a = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
        one = np.concatenate([np.stack([a, a + 1, a + 10], 1), np.stack([a, a + 10, a + 9], 1)])
        two = np.concatenate([np.stack([a, a + 1, a + 9], 1), np.stack([a + 1, a + 10, a + 9], 1)])
        mesh = scene.add_mesh(points, np.concatenate([one, two, one]))
        other = scene.add_mesh(points, two[::-1])
        tilt = np.eye(4)
        tilt[:3, :3] = [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]]
        for transform in (np.eye(4), tilt):
            for m in (other, mesh, mesh):
                scene.add_instance(m, transform)
    elif name == "instances":
        meshes = [scene.add_mesh(*soup(random, 100)) for _ in range(3)]
        for i in range(30):
            scene.add_instance(meshes[i % 3], random_transform(random, mirror=i % 2 == 1))
    elif name == "far away":
        meshes = [scene.add_mesh(*soup(random, 100)) for _ in range(2)]
        for i in range(20):
            transform = random_transform(random)
            transform[:3, 3] += (1e4, -2e4, 5e3)
            scene.add_instance(meshes[i % 2], transform)
    elif name == "scales":
        mesh = scene.add_mesh(*soup(random, 150))
        for _ in range(20):
            scene.add_instance(mesh, random_transform(random, decades=3))
    elif name == "flat boxes":
        quad = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        mesh = scene.add_mesh(quad, [[0, 1, 2], [0, 2, 3]])
        for i in range(40):
            transform = np.eye(4)[:, [i % 3, (i + 1) % 3, (i + 2) % 3, 3]]
            transform[:3, 3] = np.round(random.uniform(-2, 2, 3) * 2) / 2
            scene.add_instance(mesh, transform)
    return scene.build()


SCENES = ["soup", "slivers", "beams through clutter", "coincident planes", "instances", "far away", "scales", "flat boxes"]


def rays_for(scene, random, n):
    """Rays from around and inside the scene to points on and beside its triangles; some along the axes."""
    targets, spreads = [], []
    for _, mesh, transform, _, _ in scene.instances:
        points, triangles, _ = scene.meshes[mesh]
        corners = points[triangles[random.integers(0, len(triangles), n // len(scene.instances) + 1)]]
        picks = np.einsum("nk,nki->ni", random.dirichlet(np.ones(3), len(corners)), corners)
        targets.append(picks @ transform[:3, :3].T + transform[:3, 3])
        spreads.append(np.abs(targets[-1] - targets[-1].mean(0)).max())
    targets = np.concatenate(targets)
    targets = targets[random.permutation(len(targets))[:n]]
    spread = np.median(spreads)
    targets[::2] += random.normal(size=targets[::2].shape) * spread * 0.2
    origins = targets + unit_vectors(random, len(targets)) * spread * random.uniform(0, 5, (len(targets), 1))
    directions = targets - origins
    axis = random.random(len(targets)) < 0.15
    directions[axis] *= np.eye(3)[random.integers(0, 3, axis.sum())]
    directions[np.all(directions == 0, axis=1)] = (0, 0, 1)
    return origins.astype(np.float32), directions.astype(np.float32)


def assert_same(scene, a, b):
    for name in ("t", "uv"):
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_array_equal(x.view(np.uint32), y.view(np.uint32), name)
    np.testing.assert_array_equal(a.instance, b.instance)
    # A triangle that was cut has several records, all alike.
    np.testing.assert_array_equal(scene.mesh_triangle(a), scene.mesh_triangle(b))


@pytest.mark.parametrize("name", SCENES)
def test_equals_brute_force_to_the_bit(kernel_runner, name):
    scene = make_scene(kernel_runner, name)
    random = np.random.default_rng(1)
    for t_min, t_max in ((0.0, np.inf), (0.7, 1.1)):
        origins, directions = rays_for(scene, random, 8192)
        traced = scene.cast(CLOSEST, origins, directions, t_min, t_max)
        expected = scene.cast(BRUTE_FORCE, origins, directions, t_min, t_max)
        assert not traced.overflow.any()
        assert 0.05 < (expected.code == 1).mean() < 1
        assert_same(scene, traced, expected)


def test_beams_are_cut_in_less_than_a_tenth_more_records_and_never_more(kernel_runner):
    points, triangles, _ = make_scene(kernel_runner, "beams through clutter").meshes[0]
    build = kernel_runner._native.build_mesh_bvh
    cut, whole = (
        build(points, triangles, np.zeros(0, np.uint16), 0, splits)[1].view(np.uint32)[0::3, 3]
        for splits in (True, False)
    )
    assert len(whole) == len(triangles)
    assert len(triangles) * 1.01 < len(cut) <= len(triangles) * 1.1
    assert set(cut) == set(whole)


@pytest.mark.parametrize("name", ["soup", "instances", "scales"])
def test_agrees_with_double_precision(kernel_runner, name):
    """An independent test in numpy, on the rays whose answer does not hang on rounding."""
    scene = make_scene(kernel_runner, name)
    random = np.random.default_rng(2)
    origins, directions = rays_for(scene, random, 2000)
    hits = scene.cast(CLOSEST, origins, directions)
    o, d = origins.astype(np.float64), directions.astype(np.float64)
    best = np.full(len(o), np.inf)
    second = np.full(len(o), np.inf)
    owner = np.full((len(o), 2), -1)
    normals, offsets = np.zeros((len(o), 3)), np.zeros(len(o))
    doubtful = np.zeros(len(o), bool)
    for i, (_, mesh, transform, _, _) in enumerate(scene.instances):
        points, triangles, _ = scene.meshes[mesh]
        world = points @ transform[:3, :3].T + transform[:3, 3]
        for k, (a, b, c) in enumerate(world[triangles]):
            normal = np.cross(b - a, c - a)
            denominator = d @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                t = ((a - o) @ normal) / denominator
                p = o + t[:, None] * d
                weights = np.stack([np.cross(q - r, p - r) @ normal for q, r in ((b, a), (c, b), (a, c))]) / (
                    normal @ normal
                )
            margin = weights.min(axis=0)
            possible = (t > 0) & (margin > -1e-4)
            doubtful |= possible & (margin < 1e-4) & (t < best * 1.001)
            found = possible & (margin > 0)
            nearer = found & (t < best)
            second = np.where(nearer, best, np.where(found, np.minimum(second, t), second))
            owner[nearer] = (i, k)
            normals[nearer] = normal / np.linalg.norm(normal)
            offsets[nearer] = a @ normal / np.linalg.norm(normal)
            best = np.where(nearer, t, best)
    clear = ~doubtful & ~(second < 1.001 * best)
    assert clear.mean() > 0.8
    found = np.isfinite(best)
    np.testing.assert_array_equal(found[clear], (hits.code == 1)[clear])
    both = clear & found
    np.testing.assert_array_equal(owner[both, 0], hits.instance[both])
    np.testing.assert_array_equal(owner[both, 1], scene.mesh_triangle(hits)[both])
    # t itself is as uncertain as the ray is grazing; how far off the plane it ends is not.
    off = np.abs(np.einsum("ni,ni->n", o + hits.t[:, None] * d, normals) - offsets)[both]
    assert off.max() < 3e-5 * np.abs(o).max()
    assert np.median(np.abs(hits.t[both] / best[both] - 1)) < 1e-6


@pytest.mark.parametrize("shape", ["box", "bumpy sphere", "needles"])
@pytest.mark.parametrize("placed", ["at the origin", "sheared and far"])
def test_closed_meshes_do_not_leak(kernel_runner, shape, placed):
    """Rays from inside, aimed exactly at vertices and edges: 1.2 million in all, none may get out."""
    random = np.random.default_rng(3)
    points, triangles = {
        "box": box,
        "bumpy sphere": lambda: bumpy_sphere(60, 41),
        "needles": lambda: bumpy_sphere(1500, 5, 0.0),
    }[shape]()
    scene = Scene(kernel_runner)
    transform = np.eye(4)
    if placed == "sheared and far":
        transform[:3, :3] = [[2, 0.7, 0], [0, 0.3, 0.1], [0.2, 0, 1]]
        transform[:3, 3] = (300, -20, 1000)
    scene.add_instance(scene.add_mesh(points, triangles), transform)
    scene.build()
    n = 200_000
    corners = points[triangles[random.integers(0, len(triangles), n)]].astype(np.float64)
    along = random.uniform(0, 1, (n, 1))
    along[: n // 3] = 0  # a vertex itself
    along[n // 3 : n // 2] = np.round(along[n // 3 : n // 2] * 8) / 8
    targets = corners[:, 0] * (1 - along) + corners[:, 1] * along
    starts = unit_vectors(random, n) * random.uniform(0, 0.5, (n, 1))
    starts[: n // 8] = 0
    if shape == "box":
        starts[n // 8 : n // 4] = np.round(starts[n // 8 : n // 4] * 4) / 4
    world = [p @ transform[:3, :3].T + transform[:3, 3] for p in (starts, targets)]
    origins = world[0].astype(np.float32)
    directions = (world[1].astype(np.float32) - origins).astype(np.float32)
    hits = scene.cast(CLOSEST, origins, directions)
    assert (hits.code == 1).all(), f"{(hits.code == 0).sum()} of {n} rays leaked"
    shadow = scene.cast(SHADOW, origins, directions)
    assert (shadow.code == BLOCKED).all()


def test_ties_go_to_the_first_instance_and_triangle(kernel_runner):
    random = np.random.default_rng(4)
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    # Twenty copies of a quad within the mesh, three instances of it.
    scene = Scene(kernel_runner)
    mesh = scene.add_mesh(points, np.tile([[0, 1, 2], [0, 2, 3]], (20, 1)))
    away = np.eye(4)
    away[2, 3] = -5
    scene.add_instance(mesh, away)
    for _ in range(3):
        scene.add_instance(mesh)
    scene.build()
    origins = np.concatenate([random.uniform(-1, 1, (1000, 2)), np.full((1000, 1), 3)], 1)
    hits = scene.cast(CLOSEST, origins, np.tile([0, 0, -1], (1000, 1)))
    assert (hits.instance == 1).all()
    assert (scene.mesh_triangle(hits) < 2).all()


def test_going_on_behind_a_hit_finds_each_layer_once(kernel_runner):
    random = np.random.default_rng(5)
    points = np.array([[-9, -9, 0], [9, -9, 0], [0, 9, 0]], np.float32)
    layers = [np.concatenate([points[:, :2], np.full((3, 1), z, np.float32)], 1) for z in (0, 0, 0, -1, -2, -2)]
    scene = Scene(kernel_runner)
    mesh = scene.add_mesh(np.concatenate(layers), np.arange(18).reshape(6, 3))
    for _ in range(3):
        scene.add_instance(mesh, flags=0)
    scene.build()
    n = 500
    origins = np.concatenate([random.uniform(-1, 1, (n, 2)), np.full((n, 1), 3)], 1)
    directions = np.concatenate([random.uniform(-0.1, 0.1, (n, 2)), np.full((n, 1), -1)], 1)
    for source, found_code in ((CLOSEST, 1), (SHADOW, NEEDS_OPACITY)):
        t_min, skip = np.zeros(n), None
        seen = np.zeros((n, 3, 6), int)
        last_t = np.zeros(n)
        for _ in range(18):
            hits = scene.cast(source, origins, directions, t_min, 1e9, skip)
            assert (hits.code == found_code).all()
            assert (hits.t >= last_t).all()
            seen[np.arange(n), hits.instance, scene.mesh_triangle(hits)] += 1
            last_t = t_min = hits.t
            skip = np.stack([hits.instance, hits.record], 1)
        assert (seen == 1).all()
        assert (scene.cast(source, origins, directions, t_min, 1e9, skip).code == 0).all()


def test_visibility_masks(kernel_runner):
    scene = Scene(kernel_runner)
    mesh = scene.add_mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]])
    for visibility in (1, 2, 4):
        transform = np.eye(4)
        transform[2, 3] = -visibility
        scene.add_instance(mesh, transform, visibility=visibility)
    scene.build()
    for mask, instance in ((1, 0), (2, 1), (4, 2), (6, 1), (7, 0)):
        hits = scene.cast(CLOSEST, [[0, 0, 1]], [[0, 0, -1]], mask=mask)
        assert hits.instance[0] == instance
    assert scene.cast(CLOSEST, [[0, 0, 1]], [[0, 0, -1]], mask=8).code[0] == 0
    assert scene.cast(SHADOW, [[0, 0, 1]], [[0, 0, -1]], t_max=4.9, mask=4).code[0] == CLEAR
    assert scene.cast(SHADOW, [[0, 0, 1]], [[0, 0, -1]], t_max=5.1, mask=4).code[0] == BLOCKED


def test_shadow_rays_ask_for_opacity_where_they_must(kernel_runner):
    scene = Scene(kernel_runner)
    triangle = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]
    mesh = scene.add_mesh(triangle, [[0, 1, 2]], slots=[3])

    def at(z):
        transform = np.eye(4)
        transform[2, 3] = z
        return transform

    near_glass = scene.add_instance(mesh, at(-1), flags=0)
    scene.add_instance(mesh, at(-2), flags=0)
    wall = scene.add_instance(mesh, at(-3), flags=OPAQUE)
    scene.add_light(KIND_RECT, at(-0.5))
    scene.build()
    ray = ([[0, 0, 0]], [[0, 0, -1]])
    hit = scene.cast(SHADOW, *ray, t_max=2.5)
    assert (hit.code[0], hit.instance[0], hit.t[0]) == (NEEDS_OPACITY, near_glass, 1)
    assert scene.cast(SHADOW, *ray, t_max=4).code[0] == BLOCKED  # the wall, though glass is nearer
    assert scene.cast(SHADOW, *ray, t_max=0.75).code[0] == CLEAR  # the light shape alone
    assert scene.cast(SHADOW, *ray, t_max=2.5, opaque_slots=1 << 3).code[0] == BLOCKED
    assert scene.cast(SHADOW, *ray, t_max=2.5, opaque_slots=1 << 2).code[0] == NEEDS_OPACITY
    behind = scene.cast(SHADOW, *ray, t_min=3, t_max=9, skip=[[wall, hit.record[0]]])
    assert behind.code[0] == CLEAR


def test_unusable_rays_hit_nothing_and_end(kernel_runner):
    scene = Scene(kernel_runner)
    scene.add_instance(scene.add_mesh(*bumpy_sphere(40, 21)))
    scene.add_light(KIND_SPHERE)
    scene.build()
    origins, directions = [], []
    for bad in (np.nan, np.inf, -np.inf):
        for axis in range(3):
            for kind in range(2):
                pair = [np.array([0.1, 0.2, 0.3]), np.array([0.0, 0.6, 0.8])]
                pair[kind][axis] = bad
                origins.append(pair[0])
                directions.append(pair[1])
    origins.append([0, 0, 0])
    directions.append([0, 0, 0])
    for source in (CLOSEST, SHADOW):
        assert (scene.cast(source, origins, directions).code == 0).all()
        assert (scene.cast(source, [[0, 0, 0]], [[0, 0, 1]], t_min=np.nan).code == 0).all()
        assert (scene.cast(source, [[0, 0, 0]], [[0, 0, 1]], t_min=2, t_max=1).code == 0).all()
    # Huge and tiny directions are rays like others.
    for length in (1e-12, 1e12):
        assert scene.cast(CLOSEST, [[0, 0, 0]], [[0, 0, length]]).code[0] == 1


def test_too_many_steps_are_reported(kernel_runner):
    scene = Scene(kernel_runner)
    points = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]
    scene.add_instance(scene.add_mesh(points, np.tile([[0, 1, 2]], (30000, 1))))
    scene.build()
    hits = scene.cast(CLOSEST, [[0, 0, 1], [5, 5, 1]], [[0, 0, -1], [0, 0, -1]])
    assert hits.overflow.tolist() == [True, False]


def test_an_empty_scene(kernel_runner):
    scene = Scene(kernel_runner)
    scene.build()
    assert scene.cast(CLOSEST, [[0, 0, 1]], [[0, 0, -1]]).code[0] == 0
    scene.add_instance(scene.add_mesh(np.zeros((0, 3)), np.zeros((0, 3))))
    scene.build()
    assert scene.cast(SHADOW, [[0, 0, 1]], [[0, 0, -1]]).code[0] == CLEAR


def light_shape_roots(kind, o, d):
    """Distances at which lines meet the shining side of a unit shape, in double; NaN where they do not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if kind in (KIND_RECT, KIND_DISK):
            t = -o[:, 2] / d[:, 2]
            p = o + t[:, None] * d
            inside = np.abs(p[:, :2]).max(1) <= 0.5 if kind == KIND_RECT else (p[:, :2] ** 2).sum(1) <= 1
            return np.where(inside & (d[:, 2] > 0), t, np.nan)
        axes = slice(1, 3) if kind == KIND_CYLINDER else slice(0, 3)
        a = (d[:, axes] ** 2).sum(1)
        b = (o[:, axes] * d[:, axes]).sum(1)
        c = (o[:, axes] ** 2).sum(1) - 1
        root = np.sqrt(b * b - a * c)
        t = (-b - root) / a
        if kind == KIND_CYLINDER:
            x = o[:, 0] + t * d[:, 0]
            t = np.where(np.abs(x) <= 0.5, t, np.nan)
        return t


@pytest.mark.parametrize("kind", [KIND_RECT, KIND_DISK, KIND_SPHERE, KIND_CYLINDER])
def test_light_shapes_against_their_equations(kernel_runner, kind):
    random = np.random.default_rng(kind)
    transform = random_transform(random, decades=0.3)
    scene = Scene(kernel_runner)
    scene.add_light(kind, transform)
    scene.build()
    n = 20000
    targets = random.uniform(-1.2, 1.2, (n, 3)) * ((1, 1, 0.01) if kind in (KIND_RECT, KIND_DISK) else 1)
    starts = random.uniform(-3, 3, (n, 3))
    to_world = transform[:3, :3].T
    origins = (starts @ to_world + transform[:3, 3]).astype(np.float32)
    directions = ((targets - starts) @ to_world).astype(np.float32)
    inverse = np.linalg.inv(transform)
    o = origins.astype(np.float64) @ inverse[:3, :3].T + inverse[:3, 3]
    d = directions.astype(np.float64) @ inverse[:3, :3].T
    roots = light_shape_roots(kind, o, d)
    first = np.where(roots > 0, roots, np.inf)  # NaN becomes infinite too
    hits = scene.cast(CLOSEST, origins, directions)
    found = np.isfinite(first)
    assert 0.05 < found.mean() < 0.9
    # Where the line only just meets the outline, float and double may disagree.
    wrong = found != (hits.code == 1)
    assert wrong.mean() < 1e-3
    both = found & (hits.code == 1)
    error = np.abs(hits.t[both] / first[both] - 1)
    assert np.quantile(error, 0.999) < 1e-3
    assert np.median(error) < 1e-6
    # Behind the shining side there is nothing more: the dark side lets rays through.
    again = scene.cast(CLOSEST, origins, directions, hits.t, np.inf, np.stack([hits.instance, hits.record], 1))
    assert ((again.code == 1) & both).mean() < 1e-3
    if kind in (KIND_RECT, KIND_DISK):
        p = (o + first[:, None] * d)[both, :2] + (0.5 if kind == KIND_RECT else 0)
        assert np.quantile(np.abs(hits.uv[both] - p), 0.999) < 1e-4
    assert (scene.cast(SHADOW, origins, directions).code == CLEAR).all()


def test_records_of_what_was_not_hit(kernel_runner):
    scene = Scene(kernel_runner)
    scene.add_instance(scene.add_mesh(*box()))
    scene.build()
    hits = scene.cast(CLOSEST, [[5, 5, 5]], [[0, 0, 1]])
    assert (hits.code[0], hits.t[0]) == (0, 0)  # the caller's hit is left alone
    shadow = scene.cast(SHADOW, [[5, 5, 5]], [[0, 0, 1]], t_max=7.0)
    assert (shadow.code[0], shadow.instance[0], shadow.t[0]) == (CLEAR, NO_HIT, 7)
