// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/triangulate.h"

#include <cmath>
#include <numbers>

namespace delegate {

Vec3 NewellNormal(std::span<const Vec3> polygon) {
  // Relative to the first point, so that polygons far from the origin lose no digits.
  Vec3 sum;
  for (size_t i = 1; i + 1 < polygon.size(); ++i) sum += Cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  return sum;
}

bool SplitsAlongAC(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 normal = Cross(c - a, d - b);
  const auto faces = [&](const Vec3& p, const Vec3& q, const Vec3& r) { return Dot(Cross(q - p, r - p), normal) >= 0; };
  const bool acIsGood = faces(a, b, c) && faces(a, c, d);
  return acIsGood || !(faces(a, b, d) && faces(b, c, d));
}

// Drops the axis along which the polygon is seen best; keeps the winding counter-clockwise.
void PolygonTriangulator::Project(std::span<const Vec3> polygon, const Vec3& normal) {
  const double ax = std::fabs(normal.x), ay = std::fabs(normal.y), az = std::fabs(normal.z);
  points_.resize(polygon.size());
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 p = polygon[i] - polygon[0];
    if (az >= ax && az >= ay) points_[i] = normal.z >= 0 ? Point2{p.x, p.y} : Point2{p.y, p.x};
    else if (ax >= ay) points_[i] = normal.x >= 0 ? Point2{p.y, p.z} : Point2{p.z, p.y};
    else points_[i] = normal.y >= 0 ? Point2{p.z, p.x} : Point2{p.x, p.z};
  }
}

// Twice the signed area of the triangle; positive: counter-clockwise.
double PolygonTriangulator::Turn(uint32_t a, uint32_t b, uint32_t c) const {
  const Point2 p = points_[a], q = points_[b], r = points_[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

PolygonTriangulator::Corner PolygonTriangulator::Classify(uint32_t b) const {
  const double turn = Turn(prev_[b], b, next_[b]);
  return turn > 0 ? Corner::Convex : turn < 0 ? Corner::Reflex : Corner::Straight;
}

// Whether the outline turns by a full circle in all, as every simple polygon does (Hopf 1935). True as well where it
// turns back on itself, because the sense of that turn cannot be told.
bool PolygonTriangulator::TurnsOnce() const {
  const size_t n = points_.size();
  Point2 first{0, 0}, last{0, 0};
  double sum = 0;
  const auto turn = [&](const Point2& from, const Point2& to) {
    const double cross = from.x * to.y - from.y * to.x, dot = from.x * to.x + from.y * to.y;
    sum += std::atan2(cross, dot);
    return !(cross == 0 && dot < 0);
  };
  for (size_t i = 0; i < n; ++i) {
    const Point2 a = points_[i], b = points_[(i + 1) % n], edge{b.x - a.x, b.y - a.y};
    if (edge.x == 0 && edge.y == 0) continue;
    if (last.x == 0 && last.y == 0) first = edge;
    else if (!turn(last, edge)) return true;
    last = edge;
  }
  return !turn(last, first) || std::fabs(sum - 2 * std::numbers::pi) < 1;
}

bool PolygonTriangulator::FanIsValid() const {
  const uint32_t n = static_cast<uint32_t>(points_.size());
  for (uint32_t i = 0; i < n; ++i)
    if (Turn(i, (i + 1) % n, (i + 2) % n) < 0) return false;
  for (uint32_t i = 1; i + 1 < n; ++i)
    if (Turn(0, i, i + 1) < 0) return false;
  return true;
}

// Whether corner p lies in the closed triangle abc in a way that forbids cutting along ac.
bool PolygonTriangulator::Blocks(uint32_t p, uint32_t a, uint32_t b, uint32_t c) const {
  const auto same = [&](uint32_t i, uint32_t j) { return points_[i].x == points_[j].x && points_[i].y == points_[j].y; };
  if (Turn(a, b, p) < 0 || Turn(b, c, p) < 0 || Turn(c, a, p) < 0) return false;
  // A twin of a or c (doubled edges of a joined hole) does not forbid the cut: whatever of its chain enters the
  // triangle has a reflex corner of its own in there. A twin of b does if its chain leads into the triangle.
  if (same(p, a) || same(p, c)) return false;
  if (!same(p, b)) return true;
  const auto leadsInside = [&](uint32_t q) { return Turn(a, b, q) > 0 && Turn(b, c, q) > 0; };
  return leadsInside(prev_[p]) || leadsInside(next_[p]);
}

bool PolygonTriangulator::IsEar(uint32_t b) {
  const uint32_t a = prev_[b], c = next_[b];
  for (size_t i = 0; i < blockers_.size();) {
    const uint32_t p = blockers_[i];
    // Convex by now, or cut off: it never blocks again.
    if (corners_[p] == Corner::Convex) {
      blockers_[i] = blockers_.back();
      blockers_.pop_back();
      continue;
    }
    ++i;
    if (p == a || p == b || p == c) continue;
    if (testsLeft_ == 0) return false;
    --testsLeft_;
    if (Blocks(p, a, b, c)) return false;
  }
  return true;
}

void PolygonTriangulator::Clip(uint32_t b, std::vector<uint32_t>& triangles) {
  const uint32_t a = prev_[b], c = next_[b];
  triangles.insert(triangles.end(), {a, b, c});
  next_[a] = c;
  prev_[c] = a;
  corners_[b] = Corner::Convex;
  for (const uint32_t corner : {a, c}) {
    const Corner before = corners_[corner];
    corners_[corner] = Classify(corner);
    if (before == Corner::Convex && corners_[corner] != Corner::Convex) blockers_.push_back(corner);
  }
}

// Ear clipping (Meisters 1975), ears tried in turn around the polygon. If none is left, straight corners are cut as
// flat triangles, then, which only happens where the polygon crosses itself, any convex corner, then any.
PolygonOutcome PolygonTriangulator::ClipEars(std::vector<uint32_t>& triangles) {
  const uint32_t n = static_cast<uint32_t>(points_.size());
  next_.resize(n);
  prev_.resize(n);
  corners_.resize(n);
  blockers_.clear();
  for (uint32_t i = 0; i < n; ++i) {
    next_[i] = (i + 1) % n;
    prev_[i] = (i + n - 1) % n;
  }
  for (uint32_t i = 0; i < n; ++i) {
    corners_[i] = Classify(i);
    if (corners_[i] != Corner::Convex) blockers_.push_back(i);
  }
  enum Effort { Ears, Straights, Convexes, Anything };
  PolygonOutcome outcome = TurnsOnce() ? PolygonOutcome::Simple : PolygonOutcome::SelfIntersecting;
  uint32_t current = 0, left = n, misses = 0;
  int effort = Ears;
  while (left > 3) {
    if (testsLeft_ == 0) {
      outcome = PolygonOutcome::OverBudget;
      effort = Anything;
    }
    const Corner corner = corners_[current];
    const bool take = effort == Anything || (effort == Convexes && corner == Corner::Convex) ||
                      (effort == Straights && corner == Corner::Straight) ||
                      (effort == Ears && corner == Corner::Convex && IsEar(current));
    if (!take) {
      current = next_[current];
      if (++misses >= left) {
        misses = 0;
        ++effort;
      }
      continue;
    }
    if (effort >= Convexes && outcome == PolygonOutcome::Simple) outcome = PolygonOutcome::SelfIntersecting;
    const uint32_t following = next_[current];
    Clip(current, triangles);
    --left;
    misses = 0;
    effort = Ears;
    current = next_[following];
  }
  triangles.insert(triangles.end(), {prev_[current], current, next_[current]});
  return outcome;
}

PolygonOutcome PolygonTriangulator::Triangulate(std::span<const Vec3> polygon, std::vector<uint32_t>& triangles) {
  const uint32_t n = static_cast<uint32_t>(polygon.size());
  if (n == 3) {
    triangles.insert(triangles.end(), {0, 1, 2});
    return PolygonOutcome::Simple;
  }
  if (n == 4) {
    if (SplitsAlongAC(polygon[0], polygon[1], polygon[2], polygon[3])) triangles.insert(triangles.end(), {0, 1, 2, 0, 2, 3});
    else triangles.insert(triangles.end(), {0, 1, 3, 1, 2, 3});
    return PolygonOutcome::Simple;
  }
  Project(polygon, NewellNormal(polygon));
  if (!FanIsValid() || !TurnsOnce()) return ClipEars(triangles);
  for (uint32_t i = 1; i + 1 < n; ++i) triangles.insert(triangles.end(), {0, i, i + 1});
  return PolygonOutcome::Simple;
}

}  // namespace delegate
