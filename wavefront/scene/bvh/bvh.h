// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Bounding volume hierarchies as the ray kernels read them: 4-wide nodes with boxes quantised to 8 bits
// (layout: shared/scene_layout.h), one tree per mesh over triangle records, one tree over instances.
//
// Promises: the result is a function of the input alone (never of the thread count); every box holds its
// children exactly, whatever was rounded; a tree is never deeper than kMeshMaxDepth or
// kInstanceMaxDepth. All functions may be called from any thread, concurrently.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/types.h"

namespace wavefront::bvh {

// A node, byte for byte as in shared/scene_layout.h. Children fill the front places; the rest are kBvhEmpty.
struct BvhNode4 {
  float origin[3];
  uint8_t exponents[3];  // biased: plane = origin + q * 2^(exponent - 127)
  uint8_t childCount;
  uint32_t children[4];
  uint8_t loX[4], loY[4], loZ[4], hiX[4], hiY[4], hiZ[4];
  uint32_t unused[2];
};
static_assert(sizeof(BvhNode4) == 64);

// A triangle, byte for byte as in shared/scene_layout.h.
struct TriangleRecord {
  Float3 v0;
  uint32_t meshTriangle;  // index in the mesh's own order
  Float3 v1;
  uint32_t materialSlot;
  Float3 v2;
  uint32_t unused;
};
static_assert(sizeof(TriangleRecord) == 48);

// What lies beyond is never hit: products of coordinates would leave the range of a float.
constexpr float kMaxCoordinate = 1e18f;

// A leaf of a mesh tree holds at most this many triangles; a leaf of the instance tree exactly one instance.
constexpr uint32_t kMaxLeafTriangles = 4;

// The deepest tree that the builder makes, in nodes from the root to a leaf's parent: the entries that it needs on the
// traversal stack. lib/traverse.glsl sizes its stack by these.
constexpr uint32_t kMeshMaxDepth = 21;
constexpr uint32_t kInstanceMaxDepth = 15;
constexpr uint32_t kMaxTriangles = 1u << 27;   // a leaf names its first item with 27 bits
constexpr uint32_t kMaxInstances = 1u << 27;

// Spatial splits name at most one triangle more for this many of a mesh.
constexpr uint32_t kTrianglesPerPiece = 10;

struct BuildOptions {
  unsigned threads = 0;  // 0: DefaultThreadCount() of base/parallel.h
  bool spatialSplits = true;  // of meshes: a triangle may stand in several leaves, each with the box of its piece there
};

struct MeshBvh {
  std::vector<BvhNode4> nodes;             // root first, never empty; child indices relative to the root
  std::vector<TriangleRecord> triangles;   // leaf order; every one of the mesh, some several times (spatialSplits)
  Bounds3 bounds;                          // of all triangles that can be hit; min > max if there is none
  // Triangles that no ray can hit stand at the end of `triangles` and in no leaf: those with a vertex that is
  // not finite, lies beyond kMaxCoordinate or does not exist (an index out of range: its position reads as 0).
  uint32_t brokenTriangles = 0;
  uint32_t recordsInLeaves = 0;            // the first of `triangles`; those behind them are the ones that cannot be hit
};

// The tree of one mesh. `slots` holds a material slot per triangle, or is empty (all slot 0).
// At most kMaxTriangles triangles (checked). Triangles with two equal vertices have no area, cannot be hit, and
// stand behind the others in no leaf, too; they are not counted as broken.
MeshBvh BuildMeshBvh(std::span<const Float3> positions, std::span<const UInt3> triangles,
                     std::span<const uint16_t> slots, const BuildOptions& options = {});

struct InstanceBvh {
  std::vector<BvhNode4> nodes;  // root first, never empty. A leaf's "first item" is the index into worldBounds:
                                // instance records keep the order of the caller (by path), no reordering.
  Bounds3 bounds;               // of all instances in the tree
  uint32_t held = 0;            // instances in its leaves
  uint32_t skipped = 0;         // instances with empty or unusable bounds: in no leaf, never hit
};

// Bounds that a tree over instances can hold: not empty, no NaN, nothing beyond kMaxCoordinate.
bool IsUsable(const Bounds3& bounds);

// The tree over instances. Bounds as made by InstanceBounds; those that are not usable are skipped and counted.
InstanceBvh BuildInstanceBvh(std::span<const Bounds3> worldBounds, const BuildOptions& options = {});

// Rows of a 3x4 matrix as in the instance record: p'.x = dot(rows[0], (p, 1)).
using Rows3x4 = std::array<Float4, 3>;

// World bounds that hold every hit which the traversal can find on the instance, rounding of both transforms
// included. Empty (min > max) if objectBounds is empty or a transform is not finite.
Bounds3 InstanceBounds(const Bounds3& objectBounds, const Rows3x4& objectToWorld, const Rows3x4& worldToObject);

// Object bounds of an analytic light shape (kKindRect ... kKindCylinder of shared/scene_layout.h).
Bounds3 LightShapeBounds(uint32_t kind);

}  // namespace wavefront::bvh
