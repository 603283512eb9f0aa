# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Rays that start on a surface: never hit it again (acne), never start behind it (leaks), at any scale and place."""

from __future__ import annotations

import numpy as np
import pytest
from traversal_scene import CLOSEST, HEADER, NO_HIT, RAYS_PER_GROUP, Scene, box, bumpy_sphere, unit_vectors

# From each ray's hit, a second ray: on the side of `side`, in the direction that `local` gives in the surface's frame.
# The surface itself is not excluded by name, so that only the offset is at work.
BOUNCE = (
    HEADER
    + """
layout(binding = 6, std430) readonly buffer Bounces { vec4 bounces[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Hit hit = noHit(0.0);
  bool found = traverseClosest(rayOf(i), visibilityMask, kNoHit, kNoHit, hit);
  hits[i] = uvec4(0u, kNoHit, 0u, 9u);
  if (!found) return;
  vec3 v0 = fetchTriangle(hit.triangle * 3u).xyz;
  vec3 v1 = fetchTriangle(hit.triangle * 3u + 1u).xyz;
  vec3 v2 = fetchTriangle(hit.triangle * 3u + 2u).xyz;
  vec3 p = (1.0 - hit.u - hit.v) * v0 + hit.u * v1 + hit.v * v2;
  uint at = hit.instance * kInstanceTexels;
  vec4 q = vec4(p, 1.0);
  vec3 pWorld = vec3(dot(fetchInstanceF(at + 4u), q), dot(fetchInstanceF(at + 5u), q), dot(fetchInstanceF(at + 6u), q));
  vec3 n = cross(v1 - v0, v2 - v0);
  n = normalize(n.x * fetchInstanceF(at).xyz + n.y * fetchInstanceF(at + 1u).xyz + n.z * fetchInstanceF(at + 2u).xyz);
  vec3 error = surfacePointError(hit.instance, v0, v1, v2, pWorld);
  vec3 d = bounces[i].xyz;
  for (uint k = 0u; k < 2u; ++k) d = normalize(d - dot(d, n) * n);  // along the surface, twice for precision
  d += bounces[i].w * n;                                            // and a little (or much) to one side
  vec3 o = offsetRayOrigin(pWorld, error, n, d);
  Hit second = noHit(0.0);
  bool again = traverseClosest(Ray(o, 0.0, d, 3.4e38), visibilityMask, kNoHit, kNoHit, second);
  hits[i] = uvec4(floatBitsToUint(second.t), second.instance, hit.triangle, uint(again) | uint(overflow) << 31);
  extra[i] = uvec4(floatBitsToUint(distance(o, pWorld)), floatBitsToUint(min(hit.u, min(hit.v, 1.0 - hit.u - hit.v))),
                   floatBitsToUint(max(error.x, max(error.y, error.z))), 0u);
}
"""
)

PLACES = {
    "at the origin": (1.0, 0.0),
    "small": (1e-4, 0.0),
    "tiny, off the origin": (1e-4, 1e-2),
    "large": (1e4, 0.0),
    "far": (30.0, 1e5),
    "very far": (3e3, 1e7),
}


def place(name, random):
    scale, offset = PLACES[name]
    transform = np.eye(4)
    rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
    transform[:3, :3] = rotation @ np.diag([1, 0.5, 2]) * scale
    transform[:3, 3] = offset * np.array([1, -0.7, 0.3])
    return transform


def bounce(kernel_runner, scene, transform, starts, targets, heights):
    """Second rays after hits of rays from `starts` to `targets`, in object space."""
    random = np.random.default_rng(17)
    n = len(starts)
    world = [p @ transform[:3, :3].T + transform[:3, 3] for p in (starts, targets)]
    rays = np.zeros((n, 12), np.float32)
    rays[:, 0:3] = world[0]
    rays[:, 4:7] = world[1].astype(np.float32) - rays[:, 0:3]
    rays[:, 7] = np.inf
    rays.view(np.uint32)[:, 8:10] = NO_HIT
    bounces = np.concatenate([unit_vectors(random, n), heights[:, None]], 1).astype(np.float32)
    push = np.array([n, 7, 0, 1], np.uint32).tobytes()
    out = kernel_runner.run(
        BOUNCE,
        {3: rays, 4: np.zeros((n, 4), np.uint32), 5: np.zeros((n, 4), np.uint32), 6: bounces},
        ((n + RAYS_PER_GROUP - 1) // RAYS_PER_GROUP,),
        push=push,
        texel=scene.streams,
    )
    extra = out[5].view(np.float32)
    return out[4][:, 3], extra[:, 0], extra[:, 1]


def heights_for(random, n):
    """Tangents of the angle above the surface: from grazing to steep. Normals and directions are floats: small
    triangles' normals are off by 2e-6, so that what is meant to graze by less may really point inwards."""
    return 10 ** random.uniform(-5, 1, n)


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("shape", ["box", "sphere"])
def test_no_acne_on_convex_shapes(kernel_runner, shape, where):
    """From a convex surface outwards there is nothing to hit."""
    random = np.random.default_rng(1)
    points, triangles = box() if shape == "box" else bumpy_sphere(96, 64, 0.0)
    transform = place(where, random)
    scene = Scene(kernel_runner)
    scene.add_instance(scene.add_mesh(points, triangles), transform)
    scene.build()
    n = 60_000
    starts = unit_vectors(random, n) * 4
    targets = random.uniform(-0.6, 0.6, (n, 3))
    heights = heights_for(random, n)
    code, distance, _ = bounce(kernel_runner, scene, transform, starts, targets, outward(scene, heights))
    assert (code != 9).mean() > 0.8
    assert (code == 1).sum() == 0, f"{(code == 1).sum()} of {n} rays hit the surface they left"
    # The offset is rounding, not a safety margin: within 100 floats' spacing of the largest coordinate.
    size = np.abs(points @ transform[:3, :3].T + transform[:3, 3]).max()
    assert distance[code != 9].max() < 100 * size * 2.0**-24


def outward(scene, heights):
    """The kernel's normal follows the winding: outwards, unless the transform mirrors."""
    flips = np.linalg.det(scene.instances[0][2][:3, :3]) < 0
    return -heights if flips != WOUND_INWARD.get(len(scene.mesh_orders[0]), False) else heights


# Winding of the shapes, by their number of triangles, found once from their volume.
def _is_wound_inward(points, triangles):
    a, b, c = (points[triangles[:, i]].astype(np.float64) for i in range(3))
    return np.einsum("ni,ni->", a, np.cross(b, c)) < 0


WOUND_INWARD = {
    len(t): _is_wound_inward(p, t) for p, t in (box(), bumpy_sphere(96, 64, 0.0), bumpy_sphere(96, 64, 0.15))
}


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("shape", ["box", "bumpy sphere"])
def test_no_leaks_into_closed_shapes(kernel_runner, shape, where):
    """From a closed surface inwards there is always something to hit, also right beside an edge of the mesh."""
    random = np.random.default_rng(2)
    points, triangles = box() if shape == "box" else bumpy_sphere(96, 64, 0.15)
    transform = place(where, random)
    scene = Scene(kernel_runner)
    scene.add_instance(scene.add_mesh(points, triangles), transform)
    scene.build()
    n = 60_000
    starts = random.uniform(-0.2, 0.2, (n, 3))
    targets = starts + unit_vectors(random, n)
    heights = heights_for(random, n)
    code, distance, edge = bounce(kernel_runner, scene, transform, starts, targets, -outward(scene, heights))
    # So near to the box's sharp edges that the offset leaves through the other side, no offset helps.
    smallest = 2 * np.linalg.svd(transform[:3, :3])[1].min()
    clear = edge * smallest > 3 * distance if shape == "box" else np.ones(n, bool)
    assert clear.mean() > 0.9
    assert (code != 9).all()
    assert (code[clear] == 1).all(), f"{(code[clear] == 0).sum()} of {clear.sum()} rays got out"


def test_the_named_surface_is_never_hit(kernel_runner):
    """A ray that starts exactly on a triangle and names it passes through it."""
    scene = Scene(kernel_runner)
    scene.add_instance(scene.add_mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]]))
    scene.build()
    for z in (0.0, 1e-7, 1.0):
        assert scene.cast(CLOSEST, [[0, 0, z]], [[0, 0, -1]], skip=[[0, 0]]).code[0] == 0
        assert scene.cast(CLOSEST, [[0, 0, z]], [[0, 0, -1]]).code[0] == 1


SPAWN_TO = (
    HEADER
    + """
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  // From triangle 0 of instance 0 to triangle 0 of instance 1, at barycentrics given in the ray's places.
  vec3 points[2], errors[2], normals[2];
  for (uint k = 0u; k < 2u; ++k) {
    uint at = k * kInstanceTexels;
    uint record = fetchInstanceU(at + 3u).y;
    vec3 v0 = fetchTriangle(record * 3u).xyz, v1 = fetchTriangle(record * 3u + 1u).xyz;
    vec3 v2 = fetchTriangle(record * 3u + 2u).xyz;
    vec2 b = k == 0u ? rays[i].originAndMin.xy : rays[i].directionAndMax.xy;
    vec4 q = vec4((1.0 - b.x - b.y) * v0 + b.x * v1 + b.y * v2, 1.0);
    points[k] = vec3(dot(fetchInstanceF(at + 4u), q), dot(fetchInstanceF(at + 5u), q), dot(fetchInstanceF(at + 6u), q));
    vec3 n = cross(v1 - v0, v2 - v0);
    n = n.x * fetchInstanceF(at).xyz + n.y * fetchInstanceF(at + 1u).xyz + n.z * fetchInstanceF(at + 2u).xyz;
    normals[k] = normalize(n);
    errors[k] = surfacePointError(k, v0, v1, v2, points[k]);
  }
  Ray ray = spawnRayTo(points[0], errors[0], normals[0], points[1], errors[1], normals[1]);
  Hit hit;
  store(i, noHit(0.0), traverseShadow(ray, 7u, kNoHit, kNoHit, hit));
}
"""
)


@pytest.mark.parametrize("where", PLACES)
def test_rays_between_two_surfaces_meet_neither(kernel_runner, where):
    random = np.random.default_rng(3)
    transform = place(where, random)
    scene = Scene(kernel_runner)
    mesh = scene.add_mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]])
    above = np.eye(4)
    above[:3, :3] = [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]]
    above[:3, 3] = (0.3, 0.2, 1.5)
    scene.add_instance(mesh, transform)
    scene.add_instance(mesh, transform @ above)
    scene.build()
    n = 20_000
    weights = random.dirichlet(np.ones(3), (2, n))[:, :, :2]
    pad = np.zeros((n, 1))
    hits = scene.cast(SPAWN_TO, np.concatenate([weights[0], pad], 1), np.concatenate([weights[1], pad], 1))
    assert (hits.code == 0).all(), f"{(hits.code != 0).sum()} of {n} rays blocked by their own ends"
