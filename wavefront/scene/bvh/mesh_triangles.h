// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A mesh's triangles as trees see them: which of them can be hit, and their boxes. Builds and refits must agree on both.
#pragma once

#include <cmath>
#include <span>

#include "wavefront/scene/bvh/bvh.h"

namespace wavefront::bvh {

enum class TriangleState : uint8_t { Hittable, NoArea, Broken };

struct Corners {
  Float3 v0, v1, v2;
  bool exist = true;
};

inline Corners CornersOf(std::span<const Float3> positions, const UInt3& t) {
  const size_t n = positions.size();
  const auto at = [&](uint32_t i) { return i < n ? positions[i] : Float3{}; };
  return {at(t.x), at(t.y), at(t.z), t.x < n && t.y < n && t.z < n};
}

inline TriangleState StateOf(const Corners& c) {
  // False for a NaN, too.
  const auto isUsable = [](const Float3& p) {
    return std::fabs(p.x) <= kMaxCoordinate && std::fabs(p.y) <= kMaxCoordinate && std::fabs(p.z) <= kMaxCoordinate;
  };
  const auto equal = [](const Float3& a, const Float3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  if (!c.exist || !isUsable(c.v0) || !isUsable(c.v1) || !isUsable(c.v2)) return TriangleState::Broken;
  if (equal(c.v0, c.v1) || equal(c.v1, c.v2) || equal(c.v2, c.v0)) return TriangleState::NoArea;
  return TriangleState::Hittable;
}

}  // namespace wavefront::bvh
