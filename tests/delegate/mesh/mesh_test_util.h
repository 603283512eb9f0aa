// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Small meshes and the promises that every built mesh must keep.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "delegate/mesh/build_mesh.h"
#include "delegate/mesh/mesh_math.h"

namespace delegate::mesh_test {

using wavefront::Diagnostic;
using wavefront::Float3;
using wavefront::Interpolation;
using wavefront::MeshData;
using wavefront::PrimvarData;

// Collects diagnostics and what was built.
struct Built {
  std::optional<MeshData> mesh;
  std::vector<Diagnostic> diagnostics;

  bool Told(const std::string& code, const std::string& part = "") const {
    return std::any_of(diagnostics.begin(), diagnostics.end(), [&](const Diagnostic& d) {
      return d.code == code && d.message.find(part) != std::string::npos && d.location == "/World/mesh";
    });
  }
  const PrimvarData* Find(const std::string& name) const {
    for (const PrimvarData& p : mesh->primvars)
      if (p.name == name) return &p;
    return nullptr;
  }
};

inline MeshInput Polygons(std::vector<Float3> points, std::vector<int32_t> counts, std::vector<int32_t> indices) {
  MeshInput input;
  input.path = "/World/mesh";
  input.topology.scheme = "none";
  input.points = std::move(points);
  input.topology.faceVertexCounts = std::move(counts);
  input.topology.faceVertexIndices = std::move(indices);
  return input;
}

// Corners at +-1, outward faces: bottom, top, front (-y), right (+x), back, left.
inline MeshInput Cube(const std::string& scheme) {
  MeshInput input = Polygons({{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}},
                             {4, 4, 4, 4, 4, 4},
                             {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7});
  input.topology.scheme = scheme;
  return input;
}

// n x n quads over [0, 1]^2, normal +z.
inline MeshInput Grid(int n, const std::string& scheme) {
  std::vector<Float3> points;
  std::vector<int32_t> counts, indices;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) points.push_back({float(x) / float(n), float(y) / float(n), 0});
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x;
      counts.push_back(4);
      indices.insert(indices.end(), {a, a + 1, a + n + 2, a + n + 1});
    }
  MeshInput input = Polygons(std::move(points), std::move(counts), std::move(indices));
  input.topology.scheme = scheme;
  return input;
}

inline Vec3 TriangleAreaVector(const MeshData& mesh, size_t t) {
  const auto& tri = mesh.triangles[t];
  const Vec3 a(mesh.positions[tri.x]), b(mesh.positions[tri.y]), c(mesh.positions[tri.z]);
  return Cross(b - a, c - a) * 0.5;
}

inline double Area(const MeshData& mesh) {
  double area = 0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) area += Length(TriangleAreaVector(mesh, t));
  return area;
}

// Sum of the tetrahedra to the origin: positive if a closed mesh faces outward.
inline double Volume(const MeshData& mesh) {
  double volume = 0;
  for (const auto& tri : mesh.triangles)
    volume += Dot(Vec3(mesh.positions[tri.x]), Cross(Vec3(mesh.positions[tri.y]), Vec3(mesh.positions[tri.z]))) / 6;
  return volume;
}

// The element that corner k (0..2) of triangle t reads.
inline std::vector<float> Value(const MeshData& mesh, const PrimvarData& p, size_t t, size_t k) {
  const uint32_t corner[3] = {mesh.triangles[t].x, mesh.triangles[t].y, mesh.triangles[t].z};
  size_t element = 0;
  if (p.interpolation == Interpolation::Uniform) element = mesh.faceIds[t];
  if (p.interpolation == Interpolation::Vertex) element = corner[k];
  if (p.interpolation == Interpolation::FaceVarying) element = p.indices.empty() ? 3 * t + k : p.indices[3 * t + k];
  return {p.values.begin() + static_cast<std::ptrdiff_t>(element * p.components),
          p.values.begin() + static_cast<std::ptrdiff_t>((element + 1) * p.components)};
}

inline Vec3 NormalAt(const Built& built, size_t t, size_t k) {
  const auto v = Value(*built.mesh, *built.Find("normals"), t, k);
  return {v[0], v[1], v[2]};
}

// Everything that build_mesh.h promises about a result.
inline void ExpectValid(const MeshData& mesh, size_t authoredFaces, size_t slots) {
  ASSERT_FALSE(mesh.triangles.empty());
  ASSERT_EQ(mesh.faceIds.size(), mesh.triangles.size());
  ASSERT_TRUE(mesh.materialSlots.empty() || mesh.materialSlots.size() == mesh.triangles.size());
  for (const auto& tri : mesh.triangles) {
    ASSERT_LT(std::max({tri.x, tri.y, tri.z}), mesh.positions.size());
    ASSERT_TRUE(tri.x != tri.y && tri.y != tri.z && tri.z != tri.x);
  }
  for (const uint32_t id : mesh.faceIds) ASSERT_LT(id, authoredFaces);
  for (const uint16_t slot : mesh.materialSlots) ASSERT_LT(slot, slots);
  for (const Float3& p : mesh.positions) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  for (const PrimvarData& p : mesh.primvars) {
    ASSERT_EQ(p.values.size() % p.components, 0u) << p.name;
    const size_t elements = p.values.size() / p.components;
    for (const float v : p.values) ASSERT_TRUE(std::isfinite(v)) << p.name;
    if (p.interpolation == Interpolation::Constant) { ASSERT_EQ(elements, 1u) << p.name; }
    if (p.interpolation == Interpolation::Uniform) { ASSERT_EQ(elements, authoredFaces) << p.name; }
    if (p.interpolation == Interpolation::Vertex) { ASSERT_EQ(elements, mesh.positions.size()) << p.name; }
    if (p.interpolation == Interpolation::FaceVarying) {
      ASSERT_EQ(p.indices.empty() ? elements : p.indices.size(), 3 * mesh.triangles.size()) << p.name;
      for (const uint32_t i : p.indices) ASSERT_LT(i, elements) << p.name;
    } else {
      ASSERT_TRUE(p.indices.empty()) << p.name;
    }
    if (p.name != "normals") continue;
    for (size_t i = 0; i < elements; ++i) {
      ASSERT_NEAR(Length({p.values[3 * i], p.values[3 * i + 1], p.values[3 * i + 2]}), 1, 1e-5) << "normal " << i;
    }
  }
}

inline Built Build(const MeshInput& input) {
  Built built;
  built.mesh = BuildMesh(input, [&](const Diagnostic& d) { built.diagnostics.push_back(d); });
  if (built.mesh) ExpectValid(*built.mesh, input.topology.faceVertexCounts.size(), input.topology.subsets.size() + 1);
  return built;
}

inline void ExpectNear(const Vec3& a, const Vec3& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// Whether some position is within 1e-5.
inline bool HasPosition(const MeshData& mesh, const Vec3& p) {
  return std::any_of(mesh.positions.begin(), mesh.positions.end(), [&](const Float3& q) { return Length(Vec3(q) - p) < 1e-5; });
}

}  // namespace delegate::mesh_test
