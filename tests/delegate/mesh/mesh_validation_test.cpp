// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Broken meshes: what is broken is left out and named, the rest is drawn.
#include <limits>

#include "tests/delegate/mesh/mesh_test_util.h"

namespace delegate::mesh_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(MeshValidation, GoodMeshTellsNothing) {
  const Built built = Build(Cube("none"));
  EXPECT_TRUE(built.diagnostics.empty());
  EXPECT_EQ(built.mesh->triangles.size(), 12u);
}

TEST(MeshValidation, EmptyMesh) {
  const Built noPoints = Build(Polygons({}, {3}, {0, 1, 2}));
  EXPECT_FALSE(noPoints.mesh);
  EXPECT_TRUE(noPoints.Told("mesh-empty", "points"));
  const Built noFaces = Build(Polygons({{0, 0, 0}}, {}, {}));
  EXPECT_FALSE(noFaces.mesh);
  EXPECT_TRUE(noFaces.Told("mesh-empty", "faces"));
}

TEST(MeshValidation, BadFacesAreLeftOutAloneAndKeepTheirNumbers) {
  const std::vector<Float3> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const Built built = Build(Polygons(points, {-1, 2, 3, 3, 3, 3, 3}, {0, 1, 0, 1, 2, 0, 1, 9, 0, 1, -1, 2, 2, 2, 0, 2, 3}));
  ASSERT_TRUE(built.mesh);
  EXPECT_EQ(built.mesh->faceIds, (std::vector<uint32_t>{2, 6}));
  EXPECT_DOUBLE_EQ(Area(*built.mesh), 1.0);
  EXPECT_TRUE(built.Told("mesh-bad-topology", "1 face (first: face 0) with a negative"));
  EXPECT_TRUE(built.Told("mesh-bad-topology", "1 face (first: face 1) with fewer than 3 points"));
  EXPECT_TRUE(built.Told("mesh-bad-topology", "2 faces (first: face 3) naming points"));
  EXPECT_TRUE(built.Told("mesh-bad-topology", "1 face (first: face 5) with fewer than 3 different points"));
}

TEST(MeshValidation, CountsAndIndicesDisagree) {
  const std::vector<Float3> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const Built tooFewIndices = Build(Polygons(points, {3, 3, 1000000000}, {0, 1, 2, 0, 1}));
  ASSERT_TRUE(tooFewIndices.mesh);
  EXPECT_EQ(tooFewIndices.mesh->triangles.size(), 1u);
  EXPECT_TRUE(tooFewIndices.Told("mesh-bad-topology", "2 faces (first: face 1) reaching past the end"));
  const Built tooMany = Build(Polygons(points, {3}, {0, 1, 2, 0, 1}));
  ASSERT_TRUE(tooMany.mesh);
  EXPECT_TRUE(tooMany.Told("mesh-bad-topology", "sum to 3 but there are 5"));
}

TEST(MeshValidation, NothingLeftToDraw) {
  const Built built = Build(Polygons({{0, 0, 0}}, {3}, {0, 1, 2}));
  EXPECT_FALSE(built.mesh);
  EXPECT_TRUE(built.Told("mesh-empty"));
}

TEST(MeshValidation, PointsThatAreNotFinite) {
  for (const char* scheme : {"none", "catmullClark"}) {
    MeshInput input = Cube(scheme);
    input.refineLevel = 1;
    input.points[6] = {kNan, 0, 0};
    const Built built = Build(input);
    ASSERT_TRUE(built.mesh);
    EXPECT_TRUE(built.Told("mesh-bad-points", "3 faces (first: face 1)"));
    EXPECT_EQ(std::set<uint32_t>(built.mesh->faceIds.begin(), built.mesh->faceIds.end()), (std::set<uint32_t>{0, 2, 5}));
  }
  MeshInput huge = Polygons({{0, 0, 0}, {3e38f, 0, 0}, {0, 3e38f, 0}}, {3}, {0, 1, 2});
  EXPECT_FALSE(Build(huge).mesh);
}

TEST(MeshValidation, HolesOutOfRange) {
  MeshInput input = Cube("none");
  input.topology.holeIndices = {-1, 6, 2};
  const Built built = Build(input);
  EXPECT_TRUE(built.Told("mesh-bad-topology", "2 holeIndices (first: entry 0) name faces"));
  EXPECT_EQ(built.mesh->triangles.size(), 10u);
}

TEST(MeshValidation, UnknownTokens) {
  MeshInput input = Cube("loopy");
  input.topology.orientation = "upsideDown";
  input.refineLevel = 99;
  const Built built = Build(input);
  EXPECT_TRUE(built.Told("mesh-bad-token", "loopy"));
  EXPECT_TRUE(built.Told("mesh-bad-token", "upsideDown"));
  EXPECT_TRUE(built.Told("mesh-bad-refine-level", "99"));
  EXPECT_EQ(built.mesh->triangles.size(), 12u);
  MeshInput tags = Cube("catmullClark");
  tags.refineLevel = 1;
  tags.topology.interpolateBoundary = "what";
  tags.topology.faceVaryingLinearInterpolation = "what";
  tags.topology.triangleSubdivisionRule = "what";
  EXPECT_EQ(Build(tags).diagnostics.size(), 3u);
}

TEST(MeshValidation, Subsets) {
  MeshInput input = Cube("none");
  input.topology.subsets = {{"/World/mesh/a", {0, 1, 1}}, {"/World/mesh/b", {1, 2, -1, 77}}};
  for (const char* scheme : {"none", "catmullClark"}) {
    input.topology.scheme = scheme;
    input.refineLevel = 2;
    const Built built = Build(input);
    EXPECT_TRUE(built.Told("mesh-bad-subset", "/World/mesh/b names 2 faces (first: face -1) that the mesh does not have"));
    EXPECT_TRUE(built.Told("mesh-bad-subset", "/World/mesh/b names 1 face (first: face 1) of an earlier subset"));
    EXPECT_EQ(built.diagnostics.size(), 2u);
    const uint16_t expected[] = {1, 1, 2, 0, 0, 0};
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t) EXPECT_EQ(built.mesh->materialSlots[t], expected[built.mesh->faceIds[t]]);
  }
}

TEST(MeshValidation, BadPrimvarsAreLeftOutAlone) {
  MeshInput input = Cube("none");
  const std::vector<float> eight(8, 1.0f);
  input.primvars = {{"good", "vertex", 1, eight, {}},
                    {"short", "vertex", 1, {1, 2}, {}},
                    {"shortUniform", "uniform", 1, {1, 2}, {}},
                    {"shortFaceVarying", "faceVarying", 1, eight, {}},
                    {"none", "constant", 1, {}, {}},
                    {"badIndex", "vertex", 1, {1}, {0, 0, 0, 0, 0, 0, 0, 1}},
                    {"negativeIndex", "vertex", 1, {1}, {0, 0, 0, 0, 0, 0, 0, -1}},
                    {"ragged", "constant", 3, {1, 2}, {}},
                    {"odd", "constant", 5, std::vector<float>(5, 0.0f), {}},
                    {"zero", "constant", 0, {}, {}},
                    {"token", "sideways", 1, {1}, {}},
                    {"normals", "vertex", 1, eight, {}},
                    {"good", "constant", 1, {1}, {}}};
  const Built built = Build(input);
  ASSERT_EQ(built.mesh->primvars.size(), 1u);
  EXPECT_EQ(built.mesh->primvars[0].name, "good");
  EXPECT_EQ(built.diagnostics.size(), 12u);
  for (const Diagnostic& d : built.diagnostics) EXPECT_EQ(d.code, "mesh-bad-primvar");
  EXPECT_TRUE(built.Told("mesh-bad-primvar", "\"short\" (vertex) has 2 elements where the mesh needs 8"));
}

TEST(MeshValidation, PrimvarsTooLongOrNotFiniteAreMended) {
  MeshInput input = Cube("none");
  input.primvars = {{"long", "vertex", 1, std::vector<float>(9, 2.0f), {}}, {"nan", "constant", 2, {kNan, 5}, {}}};
  const Built built = Build(input);
  EXPECT_EQ(built.Find("long")->values.size(), 8u);
  EXPECT_EQ(built.Find("nan")->values, (std::vector<float>{0, 5}));
  EXPECT_EQ(built.diagnostics.size(), 2u);
}

TEST(MeshValidation, SubdivisionTags) {
  MeshInput input = Cube("catmullClark");
  input.refineLevel = 1;
  auto& t = input.topology;
  t.cornerIndices = {0, 8, -1, 1};
  t.cornerSharpnesses = {10, 10, 10};
  t.creaseIndices = {0, 1, 0, 6, 2, 2, 0, 99};
  t.creaseLengths = {2, 2, 2, 2, 1};
  t.creaseSharpnesses = {10, 10, 10, kNan, 1};
  const Built built = Build(input);
  EXPECT_TRUE(built.Told("mesh-bad-subdivision-tag", "4 cornerIndices but 3 cornerSharpnesses"));
  EXPECT_TRUE(built.Told("mesh-bad-subdivision-tag", "2 corners (first: entry 1)"));
  EXPECT_TRUE(built.Told("mesh-bad-subdivision-tag", "sum to 9 but there are 8"));
  EXPECT_TRUE(built.Told("mesh-bad-subdivision-tag", "4 crease edges"));
  EXPECT_TRUE(HasPosition(*built.mesh, {-1, -1, -1}));
  t.creaseSharpnesses = {1, 2};
  EXPECT_TRUE(Build(input).Told("mesh-bad-subdivision-tag", "2 creaseSharpnesses for 5 creases with 4 edges"));
}

TEST(MeshValidation, TooManyTrianglesLowerTheLevel) {
  MeshInput input = Cube("catmullClark");
  input.refineLevel = 8;
  input.maxTriangles = 200;
  const Built built = Build(input);
  EXPECT_TRUE(built.Told("mesh-too-fine", "level 2 is taken"));
  EXPECT_EQ(built.mesh->triangles.size(), 192u);
  input.maxTriangles = 1;
  const Built cage = Build(input);
  EXPECT_TRUE(cage.Told("mesh-too-fine", "level 0 is taken"));
  EXPECT_EQ(cage.mesh->triangles.size(), 12u);
}

TEST(MeshValidation, FaceBeyondOpenSubdivsLimitIsDrawnAsPolygon) {
  std::vector<Float3> points;
  std::vector<int32_t> indices;
  const int n = 70000;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * 3.141592653589793 * i / n;
    points.push_back({float(std::cos(angle)), float(std::sin(angle)), 0});
    indices.push_back(i);
  }
  MeshInput input = Polygons(points, {n}, indices);
  input.topology.scheme = "catmullClark";
  input.refineLevel = 1;
  const Built built = Build(input);
  EXPECT_TRUE(built.Told("mesh-not-subdivided"));
  EXPECT_NEAR(Area(*built.mesh), 3.14159265, 1e-4);
}

}  // namespace
}  // namespace delegate::mesh_test
