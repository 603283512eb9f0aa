// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/bvh/refit.h"

#include <algorithm>
#include <atomic>

#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/mesh_triangles.h"
#include "wavefront/scene/bvh/refit_nodes.h"

namespace wavefront::bvh {
namespace {

Vec4 ToVec4(const Float3& p) {
  alignas(16) const float v[4] = {p.x, p.y, p.z, 0};
  return Load(v);
}

Bounds3 ToBounds(const Box4& box) {
  Bounds3 bounds;
  const auto lo = Store(box.lo), hi = Store(box.hi);
  if (lo[0] <= hi[0]) bounds = {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
  return bounds;
}

// In place of what has no box, until the refit has come to its end in vain.
Box4 PointBox() { return {Splat(0), Splat(0)}; }

}  // namespace

bool RefitMeshBvh(std::span<const Float3> positions, std::span<const UInt3> triangles, std::span<const uint16_t> slots,
                  MeshBvh& mesh, unsigned threads) {
  WAVEFRONT_CHECK(slots.empty() || slots.size() == triangles.size(), "%zu slots for %zu triangles", slots.size(), triangles.size());
  const auto move = [&](TriangleRecord& record) {
    WAVEFRONT_CHECK(record.meshTriangle < triangles.size(), "triangle %u of %zu", record.meshTriangle, triangles.size());
    const uint32_t triangle = record.meshTriangle;
    const Corners c = CornersOf(positions, triangles[triangle]);
    record = {c.v0, triangle, c.v1, slots.empty() ? 0u : slots[triangle], c.v2, 0u};
    return StateOf(c);
  };
  mesh.brokenTriangles = 0;
  for (size_t i = mesh.recordsInLeaves; i < mesh.triangles.size(); ++i) {
    const TriangleState state = move(mesh.triangles[i]);
    if (state == TriangleState::Hittable) return false;
    mesh.brokenTriangles += state == TriangleState::Broken;
  }
  std::atomic<bool> isSame = true;
  const auto leafBox = [&](uint32_t first, uint32_t count) {
    Box4 box;
    for (uint32_t i = first; i < first + count; ++i) {
      TriangleRecord& record = mesh.triangles[i];
      if (move(record) != TriangleState::Hittable) {
        isSame.store(false, std::memory_order_relaxed);
        box.Extend(PointBox());
        continue;
      }
      const Vec4 v0 = ToVec4(record.v0), v1 = ToVec4(record.v1), v2 = ToVec4(record.v2);
      box.Extend({Min(Min(v0, v1), v2), Max(Max(v0, v1), v2)});
    }
    return box;
  };
  mesh.bounds = ToBounds(NodeRefit(std::span(mesh.nodes), leafBox).Run(threads == 0 ? DefaultThreadCount() : threads));
  return isSame;
}

bool RefitInstanceBvh(std::span<const Bounds3> worldBounds, InstanceBvh& tree, unsigned threads) {
  const auto usable = static_cast<uint32_t>(std::count_if(worldBounds.begin(), worldBounds.end(), IsUsable));
  if (usable != tree.held) return false;
  // As many as before can be hit; if all that stand in leaves can, they are the same.
  std::atomic<bool> isSame = true;
  const auto leafBox = [&](uint32_t first, uint32_t) {
    if (first < worldBounds.size() && IsUsable(worldBounds[first])) {
      return Box4{ToVec4(worldBounds[first].min), ToVec4(worldBounds[first].max)};
    }
    isSame.store(false, std::memory_order_relaxed);
    return PointBox();
  };
  tree.bounds = ToBounds(NodeRefit(std::span(tree.nodes), leafBox).Run(threads == 0 ? DefaultThreadCount() : threads));
  tree.skipped = static_cast<uint32_t>(worldBounds.size()) - usable;
  return isSame;
}

}  // namespace wavefront::bvh
