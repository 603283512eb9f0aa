// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>

#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/bvh/mesh_triangles.h"
#include "wavefront/scene/bvh/spatial_split.h"
#include "wavefront/scene/bvh/wide_builder.h"

namespace wavefront::bvh {
namespace {

constexpr size_t kRecordChunk = 1u << 15;

Float3 MinOf(const Float3& a, const Float3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Float3 MaxOf(const Float3& a, const Float3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

}  // namespace

MeshBvh BuildMeshBvh(std::span<const Float3> positions, std::span<const UInt3> triangles,
                     std::span<const uint16_t> slots, const BuildOptions& options) {
  WAVEFRONT_CHECK(triangles.size() <= kMaxTriangles, "%zu triangles", triangles.size());
  WAVEFRONT_CHECK(slots.empty() || slots.size() == triangles.size(), "%zu slots for %zu triangles", slots.size(),
                  triangles.size());
  const unsigned threads = options.threads == 0 ? DefaultThreadCount() : options.threads;
  MeshBvh mesh;
  std::vector<BuildItem> items;
  items.reserve(triangles.size());
  std::vector<uint32_t> unhittable;
  for (size_t i = 0; i < triangles.size(); ++i) {
    const Corners c = CornersOf(positions, triangles[i]);
    const TriangleState state = StateOf(c);
    if (state == TriangleState::Hittable) {
      const Float3 lo = MinOf(MinOf(c.v0, c.v1), c.v2), hi = MaxOf(MaxOf(c.v0, c.v1), c.v2);
      mesh.bounds.min = MinOf(mesh.bounds.min, lo);
      mesh.bounds.max = MaxOf(mesh.bounds.max, hi);
      items.push_back(MakeItem(lo, hi, static_cast<uint32_t>(i)));
    } else {
      unhittable.push_back(static_cast<uint32_t>(i));
      if (state == TriangleState::Broken) ++mesh.brokenTriangles;
    }
  }
  WideBuildSettings settings;
  settings.maxLeafItems = kMaxLeafTriangles;
  settings.maxDepth = kMeshMaxDepth;
  settings.threads = threads;
  const TriangleCutter cutter(positions, triangles);
  if (options.spatialSplits) {
    settings.cutter = &cutter;
    settings.maxPieces = std::min(static_cast<uint32_t>(items.size() / kTrianglesPerPiece),
                                  kMaxTriangles - static_cast<uint32_t>(items.size()));
  }
  mesh.nodes = BuildWide(items, settings);
  mesh.recordsInLeaves = static_cast<uint32_t>(items.size());

  const size_t records = items.size() + unhittable.size();
  mesh.triangles.resize(records);
  const size_t chunks = (records + kRecordChunk - 1) / kRecordChunk;
  ParallelFor(chunks, threads, [&](size_t chunk) {
    const size_t end = std::min(records, (chunk + 1) * kRecordChunk);
    for (size_t i = chunk * kRecordChunk; i < end; ++i) {
      const uint32_t triangle = i < items.size() ? ItemIndex(items[i]) : unhittable[i - items.size()];
      const Corners c = CornersOf(positions, triangles[triangle]);
      mesh.triangles[i] = {c.v0, triangle, c.v1, slots.empty() ? 0u : slots[triangle], c.v2, 0u};
    }
  });
  return mesh;
}

}  // namespace wavefront::bvh
