// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>
#include <cmath>

#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/bvh/spatial_split.h"
#include "wavefront/scene/bvh/wide_builder.h"

namespace wavefront::bvh {
namespace {

// From this size on a mesh is worth all threads at once.
constexpr size_t kLargeMeshTriangles = 1u << 16;
constexpr size_t kRecordChunk = 1u << 15;

enum class TriangleState : uint8_t { Hittable, NoArea, Broken };

bool IsUsable(const Float3& p) {
  // False for a NaN, too.
  return std::fabs(p.x) <= kMaxCoordinate && std::fabs(p.y) <= kMaxCoordinate && std::fabs(p.z) <= kMaxCoordinate;
}

bool Equal(const Float3& a, const Float3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

Float3 MinOf(const Float3& a, const Float3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Float3 MaxOf(const Float3& a, const Float3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

struct Corners {
  Float3 v0, v1, v2;
  bool exist = true;
};

Corners CornersOf(std::span<const Float3> positions, const UInt3& t) {
  const size_t n = positions.size();
  const auto at = [&](uint32_t i) { return i < n ? positions[i] : Float3{}; };
  return {at(t.x), at(t.y), at(t.z), t.x < n && t.y < n && t.z < n};
}

TriangleState StateOf(const Corners& c) {
  if (!c.exist || !IsUsable(c.v0) || !IsUsable(c.v1) || !IsUsable(c.v2)) return TriangleState::Broken;
  if (Equal(c.v0, c.v1) || Equal(c.v1, c.v2) || Equal(c.v2, c.v0)) return TriangleState::NoArea;
  return TriangleState::Hittable;
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

std::vector<MeshBvh> BuildMeshBvhs(std::span<const MeshInput> meshes, const BuildOptions& options) {
  const unsigned threads = options.threads == 0 ? DefaultThreadCount() : options.threads;
  std::vector<MeshBvh> result(meshes.size());
  std::vector<size_t> small, large;
  for (size_t i = 0; i < meshes.size(); ++i) {
    (meshes[i].triangles.size() < kLargeMeshTriangles ? small : large).push_back(i);
  }
  const auto build = [&](size_t i, unsigned threadCount) {
    result[i] = BuildMeshBvh(meshes[i].positions, meshes[i].triangles, meshes[i].slots, {threadCount, options.spatialSplits});
  };
  for (const size_t i : large) build(i, threads);
  // The largest first, so that no thread ends late with one of them.
  std::sort(small.begin(), small.end(), [&](size_t a, size_t b) {
    const size_t sizeA = meshes[a].triangles.size(), sizeB = meshes[b].triangles.size();
    return sizeA != sizeB ? sizeA > sizeB : a < b;
  });
  ParallelFor(small.size(), threads, [&](size_t i) { build(small[i], 1); });
  return result;
}

}  // namespace wavefront::bvh
