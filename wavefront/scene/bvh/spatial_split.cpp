// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/bvh/spatial_split.h"

#include <algorithm>
#include <cmath>

namespace wavefront::bvh {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Vec4 ToVec4(const Float3& p) {
  alignas(16) const float v[4] = {p.x, p.y, p.z, 0};
  return Load(v);
}

float Coordinate(const Float3& p, int axis) { return axis == 0 ? p.x : (axis == 1 ? p.y : p.z); }

float RoundedDown(double value) {
  const float f = static_cast<float>(value);
  return f > value ? std::nextafter(f, -kInfinity) : f;
}
float RoundedUp(double value) {
  const float f = static_cast<float>(value);
  return f < value ? std::nextafter(f, kInfinity) : f;
}

// Extends a piece, whose lane 3 is left alone, by a point between rounded bounds.
void Extend(BuildItem& piece, int axis, double value) {
  piece.lo[axis] = std::min(piece.lo[axis], RoundedDown(value));
  piece.hi[axis] = std::max(piece.hi[axis], RoundedUp(value));
}

bool IsEmpty(const BuildItem& piece) {
  return piece.lo[0] > piece.hi[0] || piece.lo[1] > piece.hi[1] || piece.lo[2] > piece.hi[2];
}

}  // namespace

Slabs::Slabs(const Box4& bounds) {
  const auto lo = Store(bounds.lo), hi = Store(bounds.hi);
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = hi[axis] - lo[axis];
    for (uint32_t i = 0; i <= kSpatialBins; ++i) {
      planes[axis][i] = lo[axis] + extent * (static_cast<float>(i) / kSpatialBins);
    }
    planes[axis][kSpatialBins] = hi[axis];
    scale[axis] = extent > 0 ? kSpatialBins / extent : 0;
    if (!(scale[axis] <= std::numeric_limits<float>::max())) scale[axis] = 0;  // extent is a denormal
  }
}

void Slabs::Find(int axis, float lo, float hi, uint32_t& first, uint32_t& last) const {
  const auto& at = planes[axis];
  constexpr float kLast = kSpatialBins - 1;
  first = static_cast<uint32_t>(std::clamp((lo - at[0]) * scale[axis], 0.0f, kLast));
  last = static_cast<uint32_t>(std::clamp((hi - at[0]) * scale[axis], 0.0f, kLast));
  while (first > 0 && at[first] > lo) --first;  // the product was rounded
  while (first < kSpatialBins - 1 && at[first + 1] <= lo) ++first;
  while (last < kSpatialBins - 1 && at[last + 1] < hi) ++last;
  while (last > first && at[last] >= hi) --last;
  last = std::max(first, last);
}

std::array<Float3, 3> TriangleCutter::CornersOf(const BuildItem& item) const {
  const UInt3& t = triangles_[ItemIndex(item)];
  return {positions_[t.x], positions_[t.y], positions_[t.z]};
}

void TriangleCutter::Fill(std::span<const BuildItem> items, const Slabs& slabs, SpatialBins& bins) const {
  for (const BuildItem& item : items) {
    const Vec4 lo = Load(item.lo), hi = Load(item.hi);
    for (int axis = 0; axis < 3; ++axis) {
      if (slabs.scale[axis] == 0) continue;
      uint32_t first, last;
      slabs.Find(axis, item.lo[axis], item.hi[axis], first, last);
      auto& row = bins[axis];
      ++row[first].begin;
      ++row[last].end;
      if (first == last) {
        row[first].bounds.Extend({lo, hi});
        continue;
      }
      // A piece is convex: its box is that of the corners in the slab and of where edges cross the slab's planes.
      const auto corners = CornersOf(item);
      for (int e = 0; e < 3; ++e) {
        const bool rises = Coordinate(corners[e], axis) <= Coordinate(corners[(e + 1) % 3], axis);
        const Float3& from = corners[rises ? e : (e + 1) % 3];
        const Float3& to = corners[rises ? (e + 1) % 3 : e];
        const float begin = std::max(Coordinate(from, axis), item.lo[axis]);
        const float end = std::min(Coordinate(to, axis), item.hi[axis]);
        if (begin > end) continue;
        const Vec4 origin = ToVec4(from), along = Sub(ToVec4(to), origin);
        const float base = Coordinate(from, axis), length = Coordinate(to, axis) - base;
        const auto extend = [&](uint32_t slab, float at) {
          const Vec4 p = length > 0 ? Add(origin, Mul(along, Splat((at - base) / length))) : origin;
          const Vec4 inside = Min(Max(p, lo), hi);
          row[slab].bounds.Extend({inside, inside});
        };
        uint32_t slab, lastSlab;
        slabs.Find(axis, begin, end, slab, lastSlab);
        extend(slab, begin);
        for (; slab < lastSlab; ++slab) {
          extend(slab, slabs.planes[axis][slab + 1]);
          extend(slab + 1, slabs.planes[axis][slab + 1]);
        }
        if (length > 0) {
          extend(slab, end);
        } else {
          const Vec4 inside = Min(Max(ToVec4(to), lo), hi);
          row[slab].bounds.Extend({inside, inside});
        }
      }
    }
  }
}

bool TriangleCutter::Cut(const BuildItem& item, int axis, float plane, BuildItem& left, BuildItem& right) const {
  left = right = item;
  for (BuildItem* piece : {&left, &right}) {
    std::fill_n(piece->lo, 3, kInfinity);
    std::fill_n(piece->hi, 3, -kInfinity);
  }
  const auto corners = CornersOf(item);
  for (int e = 0; e < 3; ++e) {
    const Float3 &from = corners[e], &to = corners[(e + 1) % 3];
    const double begin = Coordinate(from, axis), end = Coordinate(to, axis);
    const bool crosses = (begin < plane && end > plane) || (begin > plane && end < plane);
    const double s = crosses ? (plane - begin) / (end - begin) : 0;
    for (int i = 0; i < 3; ++i) {
      const double a = Coordinate(from, i), b = Coordinate(to, i);
      if (begin <= plane) Extend(left, i, a);
      if (begin >= plane) Extend(right, i, a);
      if (crosses) {
        // What is rounded off a double is far below the slack that traversal gives to boxes.
        const double at = i == axis ? double(plane) : a + s * (b - a);
        Extend(left, i, at);
        Extend(right, i, at);
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (BuildItem* piece : {&left, &right}) {
      piece->lo[i] = std::max(piece->lo[i], item.lo[i]);
      piece->hi[i] = std::min(piece->hi[i], item.hi[i]);
    }
  }
  left.hi[axis] = std::min(left.hi[axis], plane);
  right.lo[axis] = std::max(right.lo[axis], plane);
  return !IsEmpty(left) && !IsEmpty(right);
}

SpatialSplit BestSpatialSplit(const Slabs& slabs, const SpatialBins& bins, uint32_t count, uint32_t room) {
  SpatialSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& row = bins[axis];
    std::array<double, kSpatialBins> areaRight{};
    std::array<uint32_t, kSpatialBins> countRight{};
    Box4 box;
    uint32_t items = 0;
    for (uint32_t i = kSpatialBins; i-- > 1;) {
      box.Extend(row[i].bounds);
      items += row[i].end;
      areaRight[i] = box.HalfArea();
      countRight[i] = items;
    }
    box = Box4{};
    items = 0;
    for (uint32_t i = 1; i < kSpatialBins; ++i) {
      box.Extend(row[i - 1].bounds);
      items += row[i - 1].begin;
      if (items == 0 || countRight[i] == 0 || (items == count && countRight[i] == count)) continue;
      if (items + countRight[i] - count > room) continue;
      const double cost = box.HalfArea() * items + areaRight[i] * countRight[i];
      if (cost < best.cost) best = {axis, slabs.planes[axis][i], cost};
    }
  }
  return best;
}

}  // namespace wavefront::bvh
