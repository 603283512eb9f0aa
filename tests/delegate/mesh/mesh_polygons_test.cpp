// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Triangulation, orientation, holes, primvars and normals of polygon meshes and of cages.
#include <chrono>
#include <ctime>
#include <cstdio>
#include <random>

#include "delegate/mesh/triangulate.h"
#include "tests/delegate/mesh/mesh_test_util.h"

namespace delegate::mesh_test {
namespace {

MeshInput OnePolygon(const std::vector<Float3>& points) {
  std::vector<int32_t> indices;
  for (size_t i = 0; i < points.size(); ++i) indices.push_back(static_cast<int32_t>(i));
  return Polygons(points, {static_cast<int32_t>(points.size())}, indices);
}

// Covers a simple polygon exactly once: the areas of the triangles, all wound alike, add up to the polygon's.
void ExpectCovered(const std::vector<Float3>& points) {
  std::vector<Vec3> polygon;
  for (const Float3& p : points) polygon.emplace_back(p);
  const Vec3 normal = NewellNormal(polygon) * 0.5;
  const Built built = Build(OnePolygon(points));
  ASSERT_TRUE(built.mesh);
  EXPECT_TRUE(built.diagnostics.empty());
  EXPECT_NEAR(Area(*built.mesh), Length(normal), 1e-6 * Length(normal));
  for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
    EXPECT_GE(Dot(TriangleAreaVector(*built.mesh, t), normal), -1e-9 * Dot(normal, normal));
}

TEST(MeshTriangulation, ConcaveQuadIsCutAtItsNotch) {
  const std::vector<Float3> dart = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5f, 1, 0}};
  for (size_t shift = 0; shift < 4; ++shift) {
    std::vector<Float3> turned;
    for (size_t i = 0; i < 4; ++i) turned.push_back(dart[(i + shift) % 4]);
    ExpectCovered(turned);
  }
}

TEST(MeshTriangulation, ConvexQuadIsCutAsHydraDoes) {
  const Built built = Build(OnePolygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(built.mesh->triangles[0].y, 1u);
  EXPECT_EQ(built.mesh->triangles[0].z, 2u);
}

TEST(MeshTriangulation, ConcavePolygons) {
  ExpectCovered({{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}});  // U
  ExpectCovered({{0, 0, 0}, {0, 0, 3}, {0, 3, 3}, {0, 1, 1}, {0, 3, 0}});                                  // in the yz plane
  ExpectCovered({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}});           // straight corners
  // A square with a square hole, joined by a doubled edge.
  ExpectCovered({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}});
}

TEST(MeshTriangulation, StarsAndSpiralsInAnyPlane) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 300; ++round) {
    const Vec3 u = Normalized({unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5});
    const Vec3 v = Normalized(Cross(u, Vec3(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5)));
    const int n = 5 + static_cast<int>(unit(random) * 60);
    std::vector<Float3> points;
    for (int i = 0; i < n; ++i) {  // star-shaped around the origin: simple whatever the radii
      const double angle = 2 * 3.14159265358979 * i / n, r = 0.1 + unit(random);
      points.push_back(ToFloat3(u * (r * std::cos(angle)) + v * (r * std::sin(angle))));
    }
    ExpectCovered(points);
  }
  std::vector<Float3> spiral;  // a band of six turns
  for (int i = 0; i <= 400; ++i) {
    const double a = i * 0.1;
    spiral.push_back({float((1 + a) * std::cos(a)), float((1 + a) * std::sin(a)), 0});
  }
  for (int i = 400; i >= 0; --i) {
    const double a = i * 0.1;
    spiral.push_back({float((3 + a) * std::cos(a)), float((3 + a) * std::sin(a)), 0});
  }
  ExpectCovered(spiral);
}

TEST(MeshTriangulation, CrossedPolygonsEndAndAreNamed) {
  std::vector<Float3> pentagram;
  for (int i = 0; i < 5; ++i) pentagram.push_back({float(std::cos(i * 4 * 3.14159265 / 5)), float(std::sin(i * 4 * 3.14159265 / 5)), 0});
  const Built built = Build(OnePolygon(pentagram));
  EXPECT_TRUE(built.Told("mesh-bad-topology", "cross themselves"));
  EXPECT_EQ(built.mesh->triangles.size(), 3u);
}

TEST(MeshTriangulation, HugeCombEndsInTime) {
  std::vector<Float3> comb;  // 100,000 reflex corners: quadratic work without a bound
  const int teeth = 100000;
  for (int i = 0; i < teeth; ++i) {
    comb.push_back({float(2 * i), 0, 0});
    comb.push_back({float(2 * i + 1), 10, 0});
  }
  comb.push_back({float(2 * teeth), 0, 0});
  comb.push_back({float(teeth), -1000, 0});
  std::reverse(comb.begin(), comb.end());
  const std::clock_t start = std::clock();  // of this process: not what else the machine does
  const Built built = Build(OnePolygon(comb));
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  ASSERT_TRUE(built.mesh);
  EXPECT_EQ(built.mesh->triangles.size(), comb.size() - 2);
  EXPECT_LT(seconds, 60);
}

TEST(MeshPolygons, HolesAreNotDrawn) {
  MeshInput input = Cube("none");
  input.topology.holeIndices = {1};
  const Built built = Build(input);
  EXPECT_TRUE(built.diagnostics.empty());
  EXPECT_DOUBLE_EQ(Area(*built.mesh), 20);
  EXPECT_EQ(std::count(built.mesh->faceIds.begin(), built.mesh->faceIds.end(), 1u), 0);
  input.topology.holeIndices = {0, 1, 2, 3, 4, 5};
  const Built none = Build(input);
  EXPECT_FALSE(none.mesh);
  EXPECT_TRUE(none.diagnostics.empty());
}

TEST(MeshPolygons, LeftHandedTurnsTheWinding) {
  MeshInput input = Cube("none");
  EXPECT_NEAR(Volume(*Build(input).mesh), 8, 1e-6);
  input.topology.orientation = "leftHanded";
  EXPECT_NEAR(Volume(*Build(input).mesh), -8, 1e-6);
  input.topology.scheme = "catmullClark";
  for (const int level : {0, 1, 2}) {
    input.refineLevel = level;
    const Built built = Build(input);
    EXPECT_LT(Volume(*built.mesh), 0);
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
      EXPECT_GT(Dot(NormalAt(built, t, 0), TriangleAreaVector(*built.mesh, t)), 0);
  }
}

// A value that tells where it was authored must come out at that place, whatever the cut and the winding.
TEST(MeshPolygons, EveryInterpolationIndexedAndNot) {
  for (const char* orientation : {"rightHanded", "leftHanded"}) {
    MeshInput input = Cube("none");
    input.topology.orientation = orientation;
    input.topology.faceVertexCounts[2] = 1;  // a broken face shifts nothing
    input.topology.faceVertexCounts.insert(input.topology.faceVertexCounts.begin() + 3, 3);
    const auto& indices = input.topology.faceVertexIndices;
    std::vector<float> perFace, perPoint, perCorner;
    for (size_t f = 0; f < 7; ++f) perFace.push_back(float(f));
    for (const Float3& p : input.points) perPoint.insert(perPoint.end(), {p.x, p.y, p.z});
    for (size_t c = 0; c < indices.size(); ++c) {
      const Float3& p = input.points[indices[c]];
      perCorner.insert(perCorner.end(), {p.x, p.y, p.z});
    }
    std::vector<int32_t> reversed, cornerIndices;
    for (int i = 7; i >= 0; --i) reversed.push_back(i);
    std::vector<float> reversedPoints;
    for (int i = 7; i >= 0; --i) reversedPoints.insert(reversedPoints.end(), perPoint.begin() + 3 * i, perPoint.begin() + 3 * i + 3);
    input.primvars = {{"constant", "constant", 2, {7, 8}, {}},
                      {"constantIndexed", "constant", 2, {1, 2, 7, 8}, {1}},
                      {"uniform", "uniform", 1, perFace, {}},
                      {"uniformIndexed", "uniform", 1, {6, 5, 4, 3, 2, 1, 0}, {6, 5, 4, 3, 2, 1, 0}},
                      {"vertex", "vertex", 3, perPoint, {}},
                      {"varyingIndexed", "varying", 3, reversedPoints, reversed},
                      {"faceVarying", "faceVarying", 3, perCorner, {}},
                      {"faceVaryingIndexed", "faceVarying", 3, perPoint, indices}};
    const Built built = Build(input);
    ASSERT_EQ(built.mesh->primvars.size(), 8u);
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t) {
      const auto& tri = built.mesh->triangles[t];
      const uint32_t corner[3] = {tri.x, tri.y, tri.z};
      for (size_t k = 0; k < 3; ++k) {
        const Float3 p = built.mesh->positions[corner[k]];
        const auto value = [&](const char* name) { return Value(*built.mesh, *built.Find(name), t, k); };
        EXPECT_EQ(value("constant"), (std::vector<float>{7, 8}));
        EXPECT_EQ(value("constantIndexed"), (std::vector<float>{7, 8}));
        EXPECT_EQ(value("uniform"), (std::vector<float>{float(built.mesh->faceIds[t])}));
        EXPECT_EQ(value("uniformIndexed"), (std::vector<float>{float(built.mesh->faceIds[t])}));
        for (const char* name : {"vertex", "varyingIndexed", "faceVarying", "faceVaryingIndexed"})
          EXPECT_EQ(value(name), (std::vector<float>{p.x, p.y, p.z})) << name;
      }
    }
  }
}

TEST(MeshNormals, PolygonsWithoutAreFlatAndWithAreNormalised) {
  MeshInput input = Cube("none");
  EXPECT_EQ(Build(input).Find("normals"), nullptr);
  std::vector<float> up;
  for (int i = 0; i < 8; ++i) up.insert(up.end(), {0, 0, 3});
  input.primvars = {{"normals", "vertex", 3, up, {}}};
  const Built built = Build(input);
  EXPECT_TRUE(built.diagnostics.empty());
  ExpectNear(NormalAt(built, 0, 0), {0, 0, 1}, 1e-7);
}

TEST(MeshNormals, ZeroNormalsAreComputed) {
  MeshInput input = Cube("none");
  const Vec3 diagonal = Normalized({1, 1, 1});
  input.primvars = {{"normals", "vertex", 3, std::vector<float>(24, 0.0f), {}}};
  const Built vertex = Build(input);
  EXPECT_TRUE(vertex.Told("mesh-bad-primvar", "have no length"));
  const auto& values = vertex.Find("normals")->values;
  ExpectNear({values[18], values[19], values[20]}, diagonal, 1e-6);
  input.primvars = {{"normals", "faceVarying", 3, std::vector<float>(72, 0.0f), {}}};
  const Built corner = Build(input);
  input.primvars = {{"normals", "uniform", 3, std::vector<float>(18, 0.0f), {}}};
  const Built face = Build(input);
  for (size_t t = 0; t < 12; ++t) {
    ExpectNear(NormalAt(corner, t, 1), Normalized(TriangleAreaVector(*corner.mesh, t)), 1e-6);
    ExpectNear(NormalAt(face, t, 1), Normalized(TriangleAreaVector(*face.mesh, t)), 1e-6);
  }
  input.primvars = {{"normals", "constant", 3, {0, 0, 0}, {}}};
  EXPECT_EQ(Build(input).Find("normals"), nullptr);
}

TEST(MeshNormals, CagesAreSmoothAndIgnoreAuthoredOnes) {
  for (const char* scheme : {"catmullClark", "loop"}) {
    MeshInput input = Cube(scheme);
    input.primvars = {{"normals", "constant", 3, {1, 0, 0}, {}}};
    const Built built = Build(input);
    EXPECT_TRUE(built.Told("mesh-normals-ignored"));
    EXPECT_EQ(built.mesh->triangles.size(), 12u);
    const auto& values = built.Find("normals")->values;
    ExpectNear({values[18], values[19], values[20]}, Normalized({1, 1, 1}), 1e-6);
  }
  EXPECT_EQ(Build(Cube("bilinear")).Find("normals"), nullptr);
}

TEST(MeshThroughput, MillionQuads) {
  MeshInput input = Grid(1000, "none");
  std::vector<float> st;
  for (const int32_t i : input.topology.faceVertexIndices) st.insert(st.end(), {input.points[i].x, input.points[i].y});
  input.primvars = {{"st", "faceVarying", 2, st, {}}};
  const auto start = std::chrono::steady_clock::now();
  const auto mesh = BuildMesh(input, nullptr);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->triangles.size(), 2000000u);
  EXPECT_NEAR(Area(*mesh), 1, 1e-4);
  std::printf("1M quads as polygons with face-varying st: %.2f s\n", seconds);
}

}  // namespace
}  // namespace delegate::mesh_test
