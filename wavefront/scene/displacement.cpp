// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/displacement.h"

#include <algorithm>
#include <cmath>

#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/transforms.h"

namespace wavefront {
namespace {

constexpr double kSameNormal = 0.99985;  // cosine of a degree

Double3 Wide(const Float3& v) { return {v.x, v.y, v.z}; }
Float3 Narrow(const Double3& v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }
Double3 operator-(const Double3& a, const Double3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Double3 operator*(const Double3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Double3& operator+=(Double3& a, const Double3& b) {
  a.x += b.x;
  a.y += b.y;
  a.z += b.z;
  return a;
}
double Dot(const Double3& a, const Double3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Double3 Cross(const Double3& a, const Double3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Zero where it has no length.
Double3 Normalized(const Double3& v) {
  const double length = std::sqrt(Dot(v, v));
  return length > 0 && std::isfinite(length) ? v * (1 / length) : Double3();
}

const uint32_t* Corners(const MeshData& mesh, std::size_t triangle) { return &mesh.triangles[triangle].x; }

struct TriangleShape {
  Double3 cross;     // twice the area long
  double angles[3];  // at the corners
};
TriangleShape ShapeOf(const MeshData& mesh, std::size_t triangle) {
  const uint32_t* v = Corners(mesh, triangle);
  const Double3 p[3] = {Wide(mesh.positions[v[0]]), Wide(mesh.positions[v[1]]), Wide(mesh.positions[v[2]])};
  TriangleShape shape;
  shape.cross = Cross(p[1] - p[0], p[2] - p[0]);
  for (int c = 0; c < 3; ++c) {
    const Double3 a = p[(c + 1) % 3] - p[c], b = p[(c + 2) % 3] - p[c], across = Cross(a, b);
    shape.angles[c] = std::atan2(std::sqrt(Dot(across, across)), Dot(a, b));
  }
  return shape;
}

const PrimvarData* FindNormals(const MeshData& mesh) {
  for (const PrimvarData& primvar : mesh.primvars)
    if (primvar.name == "normals" && primvar.components == 3) return &primvar;
  return nullptr;
}

std::size_t ElementOf(const MeshData& mesh, const PrimvarData& primvar, std::size_t triangle, std::size_t corner) {
  switch (primvar.interpolation) {
    case Interpolation::Uniform: return mesh.faceIds.empty() ? triangle : mesh.faceIds[triangle];
    case Interpolation::Vertex: return Corners(mesh, triangle)[corner];
    case Interpolation::FaceVarying:
      return primvar.indices.empty() ? 3 * triangle + corner : primvar.indices[3 * triangle + corner];
    default: return 0;
  }
}

}  // namespace

std::vector<Float3> CornerNormals(const MeshData& mesh) {
  std::vector<Float3> result(3 * mesh.triangles.size());
  const PrimvarData* normals = FindNormals(mesh);
  std::vector<Double3> faces;  // sums of the triangles of an authored face
  const auto faceOf = [&](std::size_t t) { return mesh.faceIds.empty() ? t : std::size_t{mesh.faceIds[t]}; };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (faceOf(t) >= faces.size()) faces.resize(faceOf(t) + 1);
    faces[faceOf(t)] += ShapeOf(mesh, t).cross;
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Float3 flat = Narrow(Normalized(faces[faceOf(t)]));
    for (std::size_t c = 0; c < 3; ++c) {
      Float3& out = result[3 * t + c];
      out = flat;
      if (normals == nullptr) continue;
      const std::size_t at = 3 * ElementOf(mesh, *normals, t, c);
      if (at + 3 <= normals->values.size()) out = {normals->values[at], normals->values[at + 1], normals->values[at + 2]};
    }
  }
  return result;
}

std::vector<Float3> PointNormals(const MeshData& mesh, std::span<const Float3> cornerNormals) {
  const PrimvarData* normals = FindNormals(mesh);
  const bool isPerPoint = normals != nullptr && normals->interpolation == Interpolation::Vertex;
  std::vector<Double3> sums(mesh.positions.size());
  std::vector<Float3> result(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TriangleShape shape = ShapeOf(mesh, t);
    for (std::size_t c = 0; c < 3; ++c) {
      const uint32_t point = Corners(mesh, t)[c];
      const Float3& normal = cornerNormals[3 * t + c];
      sums[point] += Wide(normal) * shape.angles[c];
      // Where they cancel out, or the triangles have no angles: the first.
      if (isPerPoint || Dot(Wide(result[point]), Wide(result[point])) == 0) result[point] = normal;
    }
  }
  for (std::size_t i = 0; i < result.size() && !isPerPoint; ++i)
    if (Dot(sums[i], sums[i]) > 1e-12) result[i] = Narrow(Normalized(sums[i]));
  return result;
}

uint64_t MovePoints(MeshData& mesh, std::span<const Float3> offsets, std::span<const uint8_t> moves) {
  std::vector<Double3> sums(mesh.positions.size());
  std::vector<uint32_t> counts(mesh.positions.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const uint32_t point = Corners(mesh, t)[c];
      ++counts[point];
      if (moves[t]) sums[point] += Wide(offsets[3 * t + c]);
    }
  }
  uint64_t stayed = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    if (counts[i] == 0) continue;
    Double3 moved = Wide(mesh.positions[i]);
    moved += sums[i] * (1.0 / counts[i]);
    const double far = std::max({std::fabs(moved.x), std::fabs(moved.y), std::fabs(moved.z)});
    const bool isNumber = std::isfinite(moved.x) && std::isfinite(moved.y) && std::isfinite(moved.z);
    if (isNumber && far < bvh::kMaxCoordinate) mesh.positions[i] = Narrow(moved);
    else ++stayed;
  }
  return stayed;
}

void RenewNormals(MeshData& mesh, std::span<const Float3> cornerNormals) {
  // The corners of each point, in order.
  std::vector<uint32_t> first(mesh.positions.size() + 1, 0), corners(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) ++first[Corners(mesh, t)[c] + 1];
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  std::vector<TriangleShape> shapes(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    shapes[t] = ShapeOf(mesh, t);
    for (std::size_t c = 0; c < 3; ++c)
      corners[next[Corners(mesh, t)[c]]++] = static_cast<uint32_t>(3 * t + c);
  }
  PrimvarData normals{"normals", Interpolation::Vertex, 3, std::vector<float>(3 * mesh.positions.size()), {}};
  std::vector<uint32_t> elements(corners.size());
  struct Group {
    Double3 before, sum;
    uint32_t element;
  };
  std::vector<Group> groups;  // of one point
  for (std::size_t point = 0; point < mesh.positions.size(); ++point) {
    groups.clear();
    for (uint32_t k = first[point]; k < first[point + 1]; ++k) {
      const uint32_t corner = corners[k];
      const Double3 before = Wide(cornerNormals[corner]);
      auto group = std::find_if(groups.begin(), groups.end(),
                                [&](const Group& g) { return Dot(g.before, before) >= kSameNormal; });
      if (group == groups.end()) {
        uint32_t element = static_cast<uint32_t>(point);
        if (!groups.empty()) {
          element = static_cast<uint32_t>(normals.values.size() / 3);
          normals.values.resize(normals.values.size() + 3);
          normals.interpolation = Interpolation::FaceVarying;
        }
        groups.push_back({before, {}, element});
        group = groups.end() - 1;
      }
      group->sum += Normalized(shapes[corner / 3].cross) * shapes[corner / 3].angles[corner % 3];
      elements[corner] = group->element;
    }
    for (const Group& group : groups) {
      const Double3 unit = Normalized(group.sum);
      const Float3 normal = Narrow(Dot(unit, unit) > 0 ? unit : group.before);
      std::copy_n(&normal.x, 3, normals.values.begin() + static_cast<std::ptrdiff_t>(3 * group.element));
    }
  }
  if (normals.interpolation == Interpolation::FaceVarying) normals.indices = std::move(elements);
  std::erase_if(mesh.primvars, [](const PrimvarData& primvar) { return primvar.name == "normals"; });
  mesh.primvars.push_back(std::move(normals));
}

}  // namespace wavefront
