// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>
#include <cmath>
#include <limits>

#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/bvh/wide_builder.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront::bvh {
namespace {

bool IsFinite(const Rows3x4& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const Float4& r) {
    return std::isfinite(r.x) && std::isfinite(r.y) && std::isfinite(r.z) && std::isfinite(r.w);
  });
}

std::array<double, 4> RowOf(const Rows3x4& m, int i) { return {m[i].x, m[i].y, m[i].z, m[i].w}; }

// A float at or beyond `value` in the direction away from the box.
float RoundedDown(double value) {
  const float f = static_cast<float>(value);
  return f > value ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float RoundedUp(double value) {
  const float f = static_cast<float>(value);
  return f < value ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace

bool IsUsable(const Bounds3& b) {
  const auto axis = [](float lo, float hi) { return lo <= hi && lo >= -kMaxCoordinate && hi <= kMaxCoordinate; };
  return axis(b.min.x, b.max.x) && axis(b.min.y, b.max.y) && axis(b.min.z, b.max.z);
}

InstanceBvh BuildInstanceBvh(std::span<const Bounds3> worldBounds, const BuildOptions& options) {
  WAVEFRONT_CHECK(worldBounds.size() <= kMaxInstances, "%zu instances", worldBounds.size());
  InstanceBvh result;
  std::vector<BuildItem> items;
  items.reserve(worldBounds.size());
  for (size_t i = 0; i < worldBounds.size(); ++i) {
    const Bounds3& b = worldBounds[i];
    if (!IsUsable(b)) {
      ++result.skipped;
      continue;
    }
    items.push_back(MakeItem(b.min, b.max, static_cast<uint32_t>(i)));
    Bounds3& all = result.bounds;
    all.min = {std::min(all.min.x, b.min.x), std::min(all.min.y, b.min.y), std::min(all.min.z, b.min.z)};
    all.max = {std::max(all.max.x, b.max.x), std::max(all.max.y, b.max.y), std::max(all.max.z, b.max.z)};
  }
  result.held = static_cast<uint32_t>(items.size());
  WideBuildSettings settings;
  settings.maxLeafItems = 1;
  settings.maxDepth = kInstanceMaxDepth;
  settings.leafIsItemIndex = true;
  settings.threads = options.threads == 0 ? DefaultThreadCount() : options.threads;
  result.nodes = BuildWide(items, settings);
  return result;
}

// A ray goes to object space as o' = W o + w, rounded to float; a hit at distance t there stands for o + t d in
// the world. The error of o' and d' is at most about 4 eps (|W| |o| + |w|) per component (4 products and sums),
// and |M| brings it back to the world, where M W = 1 up to the rounding of both matrices (2 eps |M| |W|).
// What is proportional to the ray's own origin is covered by the traversal's slack (traverse.glsl) as long as
// |M| |W| is small; what is proportional to the instance's own coordinates and grows with shear is added here.
Bounds3 InstanceBounds(const Bounds3& o, const Rows3x4& objectToWorld, const Rows3x4& worldToObject) {
  Bounds3 result;
  if (!IsUsable(o) || !IsFinite(objectToWorld) || !IsFinite(worldToObject)) return result;
  constexpr double kErrorFactor = 8 * 5.9604644775390625e-8;  // 8 * 2^-24
  const double lo[3] = {o.min.x, o.min.y, o.min.z}, hi[3] = {o.max.x, o.max.y, o.max.z};
  double worldLo[3], worldHi[3], reach[3];
  for (int i = 0; i < 3; ++i) {
    const auto m = RowOf(objectToWorld, i);
    worldLo[i] = worldHi[i] = m[3];
    for (int j = 0; j < 3; ++j) {
      worldLo[i] += std::min(m[j] * lo[j], m[j] * hi[j]);
      worldHi[i] += std::max(m[j] * lo[j], m[j] * hi[j]);
    }
    reach[i] = std::max(std::fabs(worldLo[i]), std::fabs(worldHi[i]));
  }
  double objectError[3];  // of a point of this instance that went to object space and is compared there
  for (int j = 0; j < 3; ++j) {
    const auto w = RowOf(worldToObject, j);
    objectError[j] = std::fabs(w[3]);
    for (int i = 0; i < 3; ++i) objectError[j] += std::fabs(w[i]) * reach[i];
  }
  float* const outLo[3] = {&result.min.x, &result.min.y, &result.min.z};
  float* const outHi[3] = {&result.max.x, &result.max.y, &result.max.z};
  for (int i = 0; i < 3; ++i) {
    const auto m = RowOf(objectToWorld, i);
    double error = reach[i];
    for (int j = 0; j < 3; ++j) error += std::fabs(m[j]) * objectError[j];
    *outLo[i] = RoundedDown(worldLo[i] - kErrorFactor * error);
    *outHi[i] = RoundedUp(worldHi[i] + kErrorFactor * error);
  }
  return result;
}

Bounds3 LightShapeBounds(uint32_t kind) {
  switch (kind) {
    case layout::kKindRect: return {{-0.5f, -0.5f, 0}, {0.5f, 0.5f, 0}};
    case layout::kKindDisk: return {{-1, -1, 0}, {1, 1, 0}};
    case layout::kKindSphere: return {{-1, -1, -1}, {1, 1, 1}};
    case layout::kKindCylinder: return {{-0.5f, -1, -1}, {0.5f, 1, 1}};
    default: break;
  }
  WAVEFRONT_CHECK(false, "kind %u is no light shape", kind);
  return {};
}

}  // namespace wavefront::bvh
