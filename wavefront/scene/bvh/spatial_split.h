// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Planes that part triangles instead of lists of triangles: Stich, Friedrich and Dietrich, "Spatial splits in bounding
// volume hierarchies", HPG 2009. A triangle across the plane stands on both sides, each with the box of its piece there.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "wavefront/scene/bvh/vector4.h"
#include "wavefront/scene/bvh/wide_builder.h"

namespace wavefront::bvh {

constexpr uint32_t kSpatialBins = 32;

// Equal slabs of a box, along each axis.
struct Slabs {
  std::array<std::array<float, kSpatialBins + 1>, 3> planes;
  std::array<float, 3> scale;  // slabs per unit; 0 along an axis without extent

  explicit Slabs(const Box4& bounds);
  // The first and the last slab that [lo, hi] has more than an end in.
  void Find(int axis, float lo, float hi, uint32_t& first, uint32_t& last) const;
};

struct SpatialBin {
  Box4 bounds;  // of the pieces in the slab
  uint32_t begin = 0, end = 0;  // items whose first and last slab it is
};
using SpatialBins = std::array<std::array<SpatialBin, kSpatialBins>, 3>;

struct SpatialSplit {
  int axis = -1;
  float plane = 0;
  double cost = std::numeric_limits<double>::infinity();
};

// What a plane parts: the triangles behind the items.
class TriangleCutter {
 public:
  TriangleCutter(std::span<const Float3> positions, std::span<const UInt3> triangles)
      : positions_(positions), triangles_(triangles) {}

  // Adds the items to the slabs. Bounds are those of the pieces up to rounding: good for costs, not for a tree.
  void Fill(std::span<const BuildItem> items, const Slabs& slabs, SpatialBins& bins) const;

  // Boxes of the triangle's pieces on both sides of the plane, within the item's box, rounded outwards: together they
  // hold all of the triangle that the item held. False where one side has none of it.
  bool Cut(const BuildItem& item, int axis, float plane, BuildItem& left, BuildItem& right) const;

 private:
  std::array<Float3, 3> CornersOf(const BuildItem& item) const;

  std::span<const Float3> positions_;
  std::span<const UInt3> triangles_;
};

// The cheapest plane that puts at most `room` of the `count` items on both sides; ties go to the first axis, then to the
// first plane. No axis if there is none that parts anything.
SpatialSplit BestSpatialSplit(const Slabs& slabs, const SpatialBins& bins, uint32_t count, uint32_t room);

}  // namespace wavefront::bvh
