# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Scenes for the ray kernels' tests: meshes and instances as the texel streams of shared/scene_layout.h."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

KIND_MESH, KIND_RECT, KIND_DISK, KIND_SPHERE, KIND_CYLINDER = range(5)
OPAQUE, FLIP = 0x10, 0x20
NO_HIT = 0xFFFFFFFF
MAX_FLOAT = np.float32(3.402823466e38)
RAYS_PER_GROUP = 64

HEADER = """
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 64) in;
layout(binding = 0) uniform utextureBuffer bvhNodes;
layout(binding = 7) uniform utextureBuffer bvhWords;
layout(binding = 1) uniform textureBuffer triangleRecords;
layout(binding = 2) uniform utextureBuffer instanceRecords;
struct TestRay { vec4 originAndMin; vec4 directionAndMax; uvec4 skip; };
layout(binding = 3, std430) readonly buffer Rays { TestRay rays[]; };
layout(binding = 4, std430) buffer Hits { uvec4 hits[]; };
layout(binding = 5, std430) buffer Extra { uvec4 extra[]; };
layout(push_constant) uniform Push { uint count; uint visibilityMask; uint opaqueSlots; uint instanceCount; };
#include "lib/traverse.glsl"
#include "lib/ray_offset.glsl"
bool overflow = false;
void reportTraversalOverflow() { overflow = true; }
bool isTriangleOpaque(uint instance, uint slot) { return (opaqueSlots >> slot & 1u) != 0u; }
Ray rayOf(uint i) {
  TestRay r = rays[i];
  return Ray(r.originAndMin.xyz, r.originAndMin.w, r.directionAndMax.xyz, r.directionAndMax.w);
}
void store(uint i, Hit hit, uint code) {
  hits[i] = uvec4(floatBitsToUint(hit.t), hit.instance, hit.triangle, code | uint(overflow) << 31);
  extra[i] = uvec4(floatBitsToUint(hit.u), floatBitsToUint(hit.v), 0u, 0u);
}
"""

CLOSEST = (
    HEADER
    + """
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Hit hit = noHit(0.0);
  bool found = traverseClosest(rayOf(i), visibilityMask, rays[i].skip.x, rays[i].skip.y, hit);
  store(i, hit, uint(found));
}
"""
)

SHADOW = (
    HEADER
    + """
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Hit hit;
  uint answer = traverseShadow(rayOf(i), visibilityMask, rays[i].skip.x, rays[i].skip.y, hit);
  store(i, hit, answer);
}
"""
)

# The same triangle test over all triangles of all instances, without a tree.
BRUTE_FORCE = (
    HEADER
    + """
layout(binding = 6, std430) readonly buffer Counts { uint triangleCounts[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Ray ray = rayOf(i);
  Hit best = noHit(ray.tMax);
  uint bestMesh = kNoHit;
  for (uint instance = 0u; instance < instanceCount; ++instance) {
    InstanceVisit visit = visitInstance(instance, ray, visibilityMask, kNoHit, kNoHit);
    TriangleTestRay testRay = prepareTriangleTest(visit.origin, visit.direction);
    for (uint k = 0u; k < triangleCounts[instance]; ++k) {
      uint record = visit.triangleBase + k;
      vec4 v0 = fetchTriangle(record * 3u);
      float t, u, v;
      bool found = intersectTriangle(testRay, v0.xyz, fetchTriangle(record * 3u + 1u).xyz,
                                     fetchTriangle(record * 3u + 2u).xyz, t, u, v);
      if (found && t >= ray.tMin && visit.enter &&
          isBefore(t, instance, floatBitsToUint(v0.w), best.t, best.instance, bestMesh)) {
        best = Hit(t, instance, record, u, v);
        bestMesh = floatBitsToUint(v0.w);
      }
    }
  }
  store(i, best.instance == kNoHit ? noHit(0.0) : best, uint(best.instance != kNoHit));
}
"""
)


@dataclass
class Hits:
    t: np.ndarray
    instance: np.ndarray
    record: np.ndarray
    code: np.ndarray  # closest: 1 where something was hit; shadow: kShadow*
    uv: np.ndarray
    overflow: np.ndarray


@dataclass
class Scene:
    """Meshes first, then instances of them and light shapes; build() makes the streams."""

    runner: object
    meshes: list = field(default_factory=list)  # (positions, triangles, slots)
    instances: list = field(default_factory=list)  # (kind, mesh, object-to-world 4x4, flags, visibility)
    streams: dict = field(default_factory=dict)
    triangle_counts: np.ndarray | None = None
    mesh_orders: list = field(default_factory=list)
    triangle_bases: list = field(default_factory=list)

    def add_mesh(self, positions, triangles, slots=None) -> int:
        positions = np.ascontiguousarray(positions, np.float32).reshape(-1, 3)
        triangles = np.ascontiguousarray(triangles, np.uint32).reshape(-1, 3)
        slots = np.zeros(0, np.uint16) if slots is None else np.ascontiguousarray(slots, np.uint16)
        self.meshes.append((positions, triangles, slots))
        return len(self.meshes) - 1

    def add_instance(self, mesh: int, transform=None, flags: int = OPAQUE, visibility: int = 7, kind=KIND_MESH) -> int:
        transform = np.eye(4) if transform is None else np.asarray(transform, np.float64)
        self.instances.append((kind, mesh, transform, flags, visibility))
        return len(self.instances) - 1

    def add_light(self, kind: int, transform=None, visibility: int = 7) -> int:
        return self.add_instance(0, transform, 0, visibility, kind)

    def build(self) -> Scene:
        native = self.runner._native
        built = [native.build_mesh_bvh(p, t, s) for p, t, s in self.meshes]
        matrices = [
            (m[:3].astype(np.float32), np.linalg.inv(m)[:3].astype(np.float32)) for _, _, m, _, _ in self.instances
        ]
        lows, highs = [], []
        for (kind, mesh, _, _, _), pair in zip(self.instances, matrices, strict=True):
            bounds = built[mesh][2] if kind == KIND_MESH else native.light_shape_bounds(kind)
            low, high = native.instance_bounds(np.array(bounds, np.float32), np.array(pair))
            lows.append(low)
            highs.append(high)
        top, _ = native.build_instance_bvh(
            np.array(lows, np.float32).reshape(-1, 3), np.array(highs, np.float32).reshape(-1, 3)
        )
        nodes, triangles, node_bases = [top], [], []
        self.triangle_bases, self.mesh_orders = [], []
        node_count, triangle_count = len(top) // 4, 0
        for mesh_nodes, records, _, _ in built:
            node_bases.append(node_count)
            self.triangle_bases.append(triangle_count)
            self.mesh_orders.append(records.view(np.uint32)[0::3, 3].copy())
            nodes.append(mesh_nodes)
            triangles.append(records)
            node_count += len(mesh_nodes) // 4
            triangle_count += len(records) // 3
        records = np.zeros((len(self.instances), 9, 4), np.uint32)
        self.triangle_counts = np.zeros(max(1, len(self.instances)), np.uint32)
        for i, ((kind, mesh, _, flags, visibility), (world, inverse)) in enumerate(
            zip(self.instances, matrices, strict=True)
        ):
            records[i, 0:3] = inverse.view(np.uint32)
            records[i, 4:7] = world.view(np.uint32)
            is_mesh = kind == KIND_MESH
            records[i, 3] = (
                node_bases[mesh] if is_mesh else 0,
                self.triangle_bases[mesh] if is_mesh else 0,
                kind | flags,
                visibility,
            )
            self.triangle_counts[i] = len(self.mesh_orders[mesh]) if is_mesh else 0

        def padded(rows, dtype):
            return np.concatenate([*rows, np.zeros((3, 4), dtype)]).astype(dtype, copy=False)

        self.streams = {
            0: (padded(nodes, np.uint32), "rgba32ui"),
            1: (padded(triangles, np.float32), "rgba32f"),
            2: (padded([records.reshape(-1, 4)], np.uint32), "rgba32ui"),
        }
        self.streams[7] = (self.streams[0][0], "r32ui")
        return self

    def cast(
        self,
        source: str,
        origins,
        directions,
        t_min=0.0,
        t_max=np.inf,
        skip=None,
        mask: int = 7,
        opaque_slots: int = 0,
        repeat: int = 1,
    ) -> Hits:
        origins = np.asarray(origins, np.float32).reshape(-1, 3)
        n = len(origins)
        rays = np.zeros((n, 12), np.float32)
        rays[:, 0:3] = origins
        rays[:, 3] = t_min
        rays[:, 4:7] = directions
        rays[:, 7] = t_max
        rays.view(np.uint32)[:, 8:10] = NO_HIT if skip is None else skip
        buffers = {
            3: rays,
            4: np.zeros((n, 4), np.uint32),
            5: np.zeros((n, 4), np.uint32),
        }
        if "binding = 6" in source:
            buffers[6] = self.triangle_counts
        push = np.array([n, mask, opaque_slots, len(self.instances)], np.uint32).tobytes()
        groups = ((n + RAYS_PER_GROUP - 1) // RAYS_PER_GROUP,)
        out = self.runner.run(source, buffers, groups, push=push, texel=self.streams, repeat=repeat)
        hits = out[4]
        return Hits(
            t=hits[:, 0].copy().view(np.float32),
            instance=hits[:, 1],
            record=hits[:, 2],
            code=hits[:, 3] & 0x7FFFFFFF,
            uv=out[5][:, :2].copy().view(np.float32),
            overflow=(hits[:, 3] >> 31).astype(bool),
        )

    def mesh_triangle(self, hits: Hits) -> np.ndarray:
        """Index in the mesh's own order, 0 on light shapes and where nothing was hit."""
        order = self.streams[1][0].view(np.uint32)[0::3, 3]
        found = hits.instance != NO_HIT
        kinds = np.array([kind for kind, *_ in self.instances] + [KIND_RECT])
        is_mesh = found & (kinds[np.where(found, hits.instance, len(kinds) - 1)] == KIND_MESH)
        return np.where(is_mesh, order[np.where(is_mesh, hits.record, 0)], 0)


def closed_grid(columns: int, rows: int, shape) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface: shape(u, v) on a grid that wraps in u, with one vertex for each pole."""
    u = np.arange(columns) / columns
    v = np.arange(1, rows) / rows
    uu, vv = np.meshgrid(u, v)
    inner = shape(uu.ravel(), vv.ravel())
    poles = shape(np.zeros(2), np.array([0.0, 1.0]))
    points = np.concatenate([inner, poles]).astype(np.float32)
    south, north = len(inner), len(inner) + 1
    triangles = []
    for r in range(rows - 2):
        a = r * columns + np.arange(columns)
        b = r * columns + (np.arange(columns) + 1) % columns
        triangles.append(np.stack([a, b, b + columns], 1))
        triangles.append(np.stack([a, b + columns, a + columns], 1))
    first = np.arange(columns)
    last = (rows - 2) * columns + first
    triangles.append(np.stack([np.full(columns, south), (first + 1) % columns, first], 1))
    triangles.append(np.stack([np.full(columns, north), last, (rows - 2) * columns + (first + 1) % columns], 1))
    return points, np.concatenate(triangles).astype(np.uint32)


def bumpy_sphere(columns: int, rows: int, bumps: float = 0.1, centre=(0, 0, 0), radius: float = 1.0):
    def shape(u, v):
        r = radius * (1 + bumps * np.sin(2 * np.pi * 7 * u) * np.sin(np.pi * 5 * v) * np.sin(np.pi * v))
        return np.stack(
            [
                centre[0] + r * np.cos(2 * np.pi * u) * np.sin(np.pi * v),
                centre[1] + r * np.sin(2 * np.pi * u) * np.sin(np.pi * v),
                centre[2] + r * np.cos(np.pi * v),
            ],
            1,
        )

    return closed_grid(columns, rows, shape)


def box(half=1.0):
    points = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)], np.float32)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return points, np.array(triangles, np.uint32)


def merge(parts):
    points, triangles, base = [], [], 0
    for p, t in parts:
        points.append(p)
        triangles.append(t + base)
        base += len(p)
    return np.concatenate(points), np.concatenate(triangles)


def unit_vectors(random: np.random.Generator, n: int) -> np.ndarray:
    d = random.normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)
