// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Polygons into triangles. Internal to delegate/mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "delegate/mesh/mesh_math.h"

namespace delegate {

// Newell's area vector: length = twice the area of a planar polygon, direction = its right-handed normal.
// (Sutherland et al. 1974, as given in Foley and van Dam, 2nd ed., section 11.1.3.)
Vec3 NewellNormal(std::span<const Vec3> polygon);

// True: split the quad a b c d into abc, acd (as Hydra draws it); false: into abd, bcd, because the first would fold.
bool SplitsAlongAC(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

enum class PolygonOutcome { Simple, SelfIntersecting, OverBudget };

// Reuses its scratch memory between polygons. One per thread.
class PolygonTriangulator {
 public:
  // Appends count - 2 triangles to `triangles` as numbers 0 .. count - 1, wound as the polygon. At least 3 points.
  // A simple polygon, concave or with a hole that is joined by a doubled edge, is covered exactly once. A polygon that
  // crosses itself gets count - 2 triangles too, but no promise on their shape, and is not always noticed.
  PolygonOutcome Triangulate(std::span<const Vec3> polygon, std::vector<uint32_t>& triangles);

 private:
  struct Point2 { double x, y; };
  enum class Corner { Reflex, Straight, Convex };
  void Project(std::span<const Vec3> polygon, const Vec3& normal);
  double Turn(uint32_t a, uint32_t b, uint32_t c) const;
  Corner Classify(uint32_t b) const;
  bool TurnsOnce() const;
  bool FanIsValid() const;
  bool IsEar(uint32_t b);
  bool Blocks(uint32_t p, uint32_t a, uint32_t b, uint32_t c) const;
  void Clip(uint32_t b, std::vector<uint32_t>& triangles);
  PolygonOutcome ClipEars(std::vector<uint32_t>& triangles);

  std::vector<Point2> points_;
  std::vector<uint32_t> next_, prev_;
  std::vector<Corner> corners_;
  std::vector<uint32_t> blockers_;   // corners that are not convex: only they can lie in an ear
  // Ear clipping is quadratic: a bound on the point-in-triangle tests of all polygons of a mesh, about two seconds.
  uint64_t testsLeft_ = 256'000'000;
};

}  // namespace delegate
