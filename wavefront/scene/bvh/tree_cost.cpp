// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/bvh/tree_cost.h"

#include <algorithm>
#include <vector>

#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/node_boxes.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront::bvh {
namespace {

constexpr size_t kChunk = 1u << 14;

// Sums of equal parts, added in their order: the thread count does not show in the last bits.
template <typename Of>
double Sum(size_t count, unsigned threads, const Of& of) {
  std::vector<double> parts((count + kChunk - 1) / kChunk);
  ParallelFor(parts.size(), threads, [&](size_t part) {
    const size_t end = std::min(count, (part + 1) * kChunk);
    double sum = 0;
    for (size_t i = part * kChunk; i < end; ++i) sum += of(i);
    parts[part] = sum;
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return sum;
}

double NodesCost(std::span<const BvhNode4> nodes, unsigned threads) {
  return Sum(nodes.size(), threads, [&](size_t i) {
    double cost = 0;
    for (uint32_t c = 0; c < nodes[i].childCount; ++c) {
      const uint32_t reference = nodes[i].children[c];
      const bool isLeaf = (reference & layout::kBvhLeafBit) != 0;
      cost += QuantisedHalfArea(nodes[i], c) * (isLeaf ? (reference >> layout::kBvhLeafCountShift & 7u) + 1 : kNodeCost);
    }
    return cost;
  });
}

double HalfArea(double x, double y, double z) { return x * y + y * z + z * x; }

double HalfArea(const Bounds3& b) {
  if (!IsUsable(b)) return 0;
  return HalfArea(double(b.max.x) - b.min.x, double(b.max.y) - b.min.y, double(b.max.z) - b.min.z);
}

double HalfArea(const TriangleRecord& t) {
  const auto extent = [](float a, float b, float c) { return double(std::max(std::max(a, b), c)) - std::min(std::min(a, b), c); };
  return HalfArea(extent(t.v0.x, t.v1.x, t.v2.x), extent(t.v0.y, t.v1.y, t.v2.y), extent(t.v0.z, t.v1.z, t.v2.z));
}

TreeCost CostOfTree(std::span<const BvhNode4> nodes, const Bounds3& bounds, double items, unsigned threads) {
  return {NodesCost(nodes, threads), items, HalfArea(bounds)};
}

}  // namespace

TreeCost CostOf(const MeshBvh& mesh, unsigned threads) {
  const double items = Sum(mesh.recordsInLeaves, threads, [&](size_t i) { return HalfArea(mesh.triangles[i]); });
  return CostOfTree(mesh.nodes, mesh.bounds, items, threads);
}

TreeCost CostOf(const InstanceBvh& tree, std::span<const Bounds3> worldBounds, unsigned threads) {
  const double items = Sum(worldBounds.size(), threads, [&](size_t i) { return HalfArea(worldBounds[i]); });
  return CostOfTree(tree.nodes, tree.bounds, items, threads);
}

double Growth(const TreeCost& before, const TreeCost& after) {
  // Without area nothing can be hit, and no order is better than another.
  const auto growth = [&](double unitBefore, double unitAfter) {
    return before.visits > 0 && unitBefore > 0 && unitAfter > 0 ? (after.visits / unitAfter) / (before.visits / unitBefore) : 1;
  };
  return std::max(growth(before.items, after.items), growth(before.root, after.root));
}

}  // namespace wavefront::bvh
