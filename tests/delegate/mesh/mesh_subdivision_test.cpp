// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Subdivision against closed forms of the limit surface, and the rules for creases, boundaries and primvars.
#include <chrono>
#include <cstdio>
#include <cstring>

#include "tests/delegate/mesh/mesh_test_util.h"

namespace delegate::mesh_test {
namespace {

MeshInput Refined(MeshInput input, int level) {
  input.refineLevel = level;
  return input;
}

MeshInput Octahedron() {
  MeshInput input = Polygons({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, std::vector<int32_t>(8, 3),
                             {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5});
  input.topology.scheme = "loop";
  return input;
}

// Normals of all triangle corners at a place.
std::vector<Vec3> NormalsAt(const Built& built, const Vec3& place) {
  std::vector<Vec3> result;
  for (size_t t = 0; t < built.mesh->triangles.size(); ++t) {
    const auto& tri = built.mesh->triangles[t];
    const uint32_t corner[3] = {tri.x, tri.y, tri.z};
    for (size_t k = 0; k < 3; ++k)
      if (Length(Vec3(built.mesh->positions[corner[k]]) - place) < 1e-5) result.push_back(NormalAt(built, t, k));
  }
  return result;
}

// Halstead, Kass, DeRose 1993: the limit of a vertex of valence n is (n^2 V + 4 sum E + sum F) / (n (n + 5)).
// Cube corner: (9 (1,1,1) + 4 (1,1,1) - (1,1,1)) / 24 = 1/2. Face centre, from the first refinement's points:
// (16 + 4 * 4 * 3/4 + 4 * 5/9) / 36 = 68/81.
TEST(MeshSubdivision, CubeLimitPositionsAndNormals) {
  for (const int level : {1, 2, 3}) {
    const Built built = Build(Refined(Cube("catmullClark"), level));
    EXPECT_TRUE(built.diagnostics.empty());
    EXPECT_EQ(built.mesh->triangles.size(), 12u << (2 * level));
    for (const double s : {-1.0, 1.0}) {
      EXPECT_TRUE(HasPosition(*built.mesh, {0.5 * s, 0.5, 0.5 * s}));
      EXPECT_TRUE(HasPosition(*built.mesh, {0, 68.0 / 81 * s, 0}));
    }
    const auto corner = NormalsAt(built, {0.5, 0.5, 0.5});
    ASSERT_FALSE(corner.empty());
    for (const Vec3& n : corner) ExpectNear(n, Normalized({1, 1, 1}), 1e-5);
    for (const Vec3& n : NormalsAt(built, {0, 0, 68.0 / 81})) ExpectNear(n, {0, 0, 1}, 1e-5);
    EXPECT_EQ(built.Find("normals")->interpolation, Interpolation::Vertex);
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t) {
      const auto& tri = built.mesh->triangles[t];
      EXPECT_GT(Dot(Vec3(built.mesh->positions[tri.x]), TriangleAreaVector(*built.mesh, t)), 0);
      EXPECT_GT(Dot(NormalAt(built, t, 0), TriangleAreaVector(*built.mesh, t)), 0);
    }
    for (uint32_t f = 0; f < 6; ++f)
      EXPECT_EQ(std::count(built.mesh->faceIds.begin(), built.mesh->faceIds.end(), f), 2 << (2 * level));
  }
}

// Loop 1987: the limit is (w V + sum E) / (w + n), w = 3 / (8 beta), n beta = 5/8 - (3/8 + cos(2 pi / n) / 4)^2.
TEST(MeshSubdivision, LoopLimits) {
  for (const int level : {1, 3}) {
    const Built octahedron = Build(Refined(Octahedron(), level));
    EXPECT_TRUE(octahedron.diagnostics.empty());
    EXPECT_EQ(octahedron.mesh->triangles.size(), 8u << (2 * level));
    const double beta4 = (5.0 / 8 - 9.0 / 64) / 4, w4 = 3 / (8 * beta4);
    EXPECT_TRUE(HasPosition(*octahedron.mesh, {0, 0, w4 / (w4 + 4)}));  // the four neighbours cancel
    for (const Vec3& n : NormalsAt(octahedron, {0, 0, w4 / (w4 + 4)})) ExpectNear(n, {0, 0, 1}, 1e-5);
    EXPECT_GT(Volume(*octahedron.mesh), 0);
    MeshInput tetrahedron =
        Polygons({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {3, 3, 3, 3}, {0, 2, 3, 0, 3, 1, 0, 1, 2, 1, 3, 2});
    tetrahedron.topology.scheme = "loop";
    // beta = 3/16, w = 2, and the three neighbours add up to -V.
    EXPECT_TRUE(HasPosition(*Build(Refined(tetrahedron, level)).mesh, {0.2, 0.2, 0.2}));
  }
}

TEST(MeshSubdivision, LoopTakesQuadsCutInTriangles) {
  const Built built = Build(Refined(Cube("loop"), 1));
  EXPECT_TRUE(built.Told("mesh-loop-needs-triangles", "6 larger faces"));
  EXPECT_EQ(built.mesh->triangles.size(), 48u);
  EXPECT_EQ(built.mesh->faceIds.back(), 5u);
}

TEST(MeshSubdivision, BilinearStaysOnTheCage) {
  const Built built = Build(Refined(Cube("bilinear"), 2));
  EXPECT_NEAR(Area(*built.mesh), 24, 1e-5);
  EXPECT_EQ(built.Find("normals"), nullptr);
}

TEST(MeshSubdivision, AllEdgesInfinitelySharpKeepTheCubeAndItsNormals) {
  MeshInput input = Refined(Cube("catmullClark"), 2);
  input.topology.creaseIndices = {0, 1, 2, 3, 0, 4, 5, 6, 7, 4, 1, 5, 2, 6, 3, 7};
  input.topology.creaseLengths = {10, 2, 2, 2};
  input.topology.creaseSharpnesses = {10, 10, 10, 10};
  const Built built = Build(input);
  EXPECT_TRUE(built.diagnostics.empty());
  EXPECT_NEAR(Area(*built.mesh), 24, 1e-5);
  EXPECT_NEAR(Volume(*built.mesh), 8, 1e-5);
  EXPECT_EQ(built.Find("normals")->interpolation, Interpolation::FaceVarying);
  for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
    for (size_t k = 0; k < 3; ++k) ExpectNear(NormalAt(built, t, k), Normalized(TriangleAreaVector(*built.mesh, t)), 1e-5);
}

TEST(MeshSubdivision, CreaseKeepsItsEdgeOnly) {
  MeshInput input = Refined(Cube("catmullClark"), 3);
  input.topology.creaseIndices = {4, 5, 6, 7, 4};
  input.topology.creaseLengths = {5};
  input.topology.creaseSharpnesses = {10, 10, 10, 10};  // one per edge
  const Built built = Build(input);
  EXPECT_TRUE(built.diagnostics.empty());
  float top = -1, bottom = 1;
  for (const Float3& p : built.mesh->positions) {
    top = std::max(top, p.z);
    bottom = std::min(bottom, p.z);
  }
  EXPECT_FLOAT_EQ(top, 1);
  EXPECT_GT(bottom, -1);
  // The creased loop is a cubic B-spline through (2 C + C' / 2 + C'' / 2) / 3; both sides have their own normal there.
  const Vec3 corner(2.0 / 3, 2.0 / 3, 1);
  ASSERT_TRUE(HasPosition(*built.mesh, corner));
  double highest = -1, lowest = 1;
  for (const Vec3& n : NormalsAt(built, corner)) {
    highest = std::max(highest, n.z);
    lowest = std::min(lowest, n.z);
  }
  EXPECT_GT(highest, 0.99);
  EXPECT_LT(lowest, 0.8);
}

TEST(MeshSubdivision, SemiSharpLiesBetween) {
  const auto topArea = [](float sharpness) {
    MeshInput input = Refined(Cube("catmullClark"), 3);
    input.topology.creaseIndices = {4, 5, 6, 7, 4};
    input.topology.creaseLengths = {5};
    input.topology.creaseSharpnesses = {sharpness};
    double area = 0;
    const Built built = Build(input);
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
      if (built.mesh->faceIds[t] == 1) area += Length(TriangleAreaVector(*built.mesh, t));
    return area;
  };
  const double smooth = topArea(0), one = topArea(1), two = topArea(2), infinite = topArea(10);
  EXPECT_LT(smooth, one);
  EXPECT_LT(one, two);
  EXPECT_LT(two, infinite);
}

TEST(MeshSubdivision, SharpCornerStays) {
  MeshInput input = Refined(Cube("catmullClark"), 2);
  input.topology.cornerIndices = {6};
  input.topology.cornerSharpnesses = {10};
  const Built built = Build(input);
  EXPECT_TRUE(HasPosition(*built.mesh, {1, 1, 1}));
  EXPECT_FALSE(HasPosition(*built.mesh, {-1, -1, -1}));
  for (const Vec3& n : NormalsAt(built, {1, 1, 1})) ExpectNear(n, Normalized({1, 1, 1}), 1e-4);
}

TEST(MeshSubdivision, BoundaryRules) {
  MeshInput input = Refined(Grid(3, "catmullClark"), 2);
  const Built corners = Build(input);
  EXPECT_NEAR(Area(*corners.mesh), 1, 1e-5);
  EXPECT_TRUE(HasPosition(*corners.mesh, {0, 0, 0}));
  for (const float n : corners.Find("normals")->values) EXPECT_TRUE(std::fabs(n) < 1e-6f || std::fabs(n - 1) < 1e-6f);
  input.topology.interpolateBoundary = "edgeOnly";
  const Built edges = Build(input);
  EXPECT_FALSE(HasPosition(*edges.mesh, {0, 0, 0}));
  EXPECT_LT(Area(*edges.mesh), 0.999);
  input.topology.interpolateBoundary = "none";
  const Built none = Build(input);
  EXPECT_EQ(std::set<uint32_t>(none.mesh->faceIds.begin(), none.mesh->faceIds.end()), (std::set<uint32_t>{4}));
}

TEST(MeshSubdivision, HolesShapeTheSurfaceButAreNotDrawn) {
  MeshInput input = Refined(Cube("catmullClark"), 2);
  const double whole = Area(*Build(input).mesh);
  input.topology.holeIndices = {1};
  const Built built = Build(input);
  EXPECT_NEAR(Area(*built.mesh), whole * 5 / 6, 1e-5);
  EXPECT_TRUE(HasPosition(*built.mesh, {0.5, 0.5, 0.5}));
}

TEST(MeshSubdivision, VertexPrimvarsFollowThePointsAndVaryingOnesAreLinear) {
  MeshInput input = Refined(Cube("catmullClark"), 2);
  input.points.insert(input.points.begin(), Float3{9, 9, 9});  // not used by any face
  for (int32_t& i : input.topology.faceVertexIndices) ++i;
  std::vector<float> rest, wide, perFace = {0, 1, 2, 3, 4, 5};
  for (const Float3& p : input.points) {
    rest.insert(rest.end(), {p.x, p.y, p.z});
    for (int k = 0; k < 16; ++k) wide.push_back(p.x * float(k + 1));
  }
  input.primvars = {{"rest", "vertex", 3, rest, {}},
                    {"linear", "varying", 3, rest, {}},
                    {"wide", "vertex", 16, wide, {}},
                    {"perFace", "uniform", 1, perFace, {}}};
  const Built built = Build(input);
  const auto& positions = built.mesh->positions;
  double largest = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    const float* r = built.Find("rest")->values.data() + 3 * i;
    EXPECT_EQ(r[0], positions[i].x);
    EXPECT_EQ(r[1], positions[i].y);
    EXPECT_EQ(r[2], positions[i].z);
    EXPECT_NEAR(built.Find("wide")->values[16 * i + 15], positions[i].x * 16, 1e-4);
    const float* l = built.Find("linear")->values.data() + 3 * i;
    largest = std::max({largest, std::fabs(double(l[0])), std::fabs(double(l[1])), std::fabs(double(l[2]))});
    EXPECT_FLOAT_EQ(std::max({std::fabs(l[0]), std::fabs(l[1]), std::fabs(l[2])}), 1);  // on the cube's faces
  }
  EXPECT_DOUBLE_EQ(largest, 1);
  EXPECT_EQ(built.Find("perFace")->values, perFace);
}

// Where the face-varying topology equals the mesh's, it must follow the points exactly, welded or indexed.
TEST(MeshSubdivision, FaceVaryingWithoutSeamsFollowsThePoints) {
  for (const bool indexed : {false, true}) {
    MeshInput input = Refined(Grid(3, "catmullClark"), 2);
    std::vector<float> st;
    if (indexed)
      for (const Float3& p : input.points) st.insert(st.end(), {p.x, p.y});
    else
      for (const int32_t i : input.topology.faceVertexIndices) st.insert(st.end(), {input.points[i].x, input.points[i].y});
    input.primvars = {{"st", "faceVarying", 2, st, indexed ? input.topology.faceVertexIndices : std::vector<int32_t>{}}};
    const Built built = Build(input);
    EXPECT_EQ(built.Find("st")->values.size() / 2, built.mesh->positions.size());
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t) {
      const auto value = Value(*built.mesh, *built.Find("st"), t, 2);
      const Float3 p = built.mesh->positions[built.mesh->triangles[t].z];
      EXPECT_NEAR(value[0], p.x, 1e-6);
      EXPECT_NEAR(value[1], p.y, 1e-6);
    }
  }
}

TEST(MeshSubdivision, FaceVaryingSeamStaysASeam) {
  for (const char* rule : {"none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"}) {
    MeshInput input = Refined(Grid(2, "catmullClark"), 2);
    input.topology.faceVaryingLinearInterpolation = rule;
    std::vector<float> st;
    for (size_t c = 0; c < 16; ++c) {
      const Float3 p = input.points[input.topology.faceVertexIndices[c]];
      st.insert(st.end(), {p.x + (c / 4 % 2 == 1 ? 5.0f : 0.0f), p.y});  // the right half lies elsewhere
    }
    input.primvars = {{"st", "faceVarying", 2, st, {}}};
    const Built built = Build(input);
    EXPECT_TRUE(built.diagnostics.empty());
    const bool keepsBoundary = std::strcmp(rule, "boundaries") == 0 || std::strcmp(rule, "all") == 0;
    float leftMost = 9, rightMost = 0;
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
      for (size_t k = 0; k < 3; ++k) {
        const float s = Value(*built.mesh, *built.Find("st"), t, k)[0];
        if (built.mesh->faceIds[t] % 2 == 0) {
          EXPECT_LE(s, 0.5f + 1e-6f) << rule;
          rightMost = std::max(rightMost, s);
        } else {
          EXPECT_GE(s, 5.5f - 1e-6f) << rule;
          leftMost = std::min(leftMost, s);
        }
      }
    if (keepsBoundary) {
      EXPECT_NEAR(rightMost, 0.5, 1e-6) << rule;
      EXPECT_NEAR(leftMost, 5.5, 1e-6) << rule;
    }
  }
}

// Corners of an island of one face: smooth by "none", kept by the others.
TEST(MeshSubdivision, FaceVaryingRulesDiffer) {
  const auto smallest = [](const char* rule) {
    MeshInput input = Refined(Cube("catmullClark"), 2);
    input.topology.faceVaryingLinearInterpolation = rule;
    std::vector<float> st;
    for (int f = 0; f < 6; ++f) st.insert(st.end(), {0, 0, 1, 0, 1, 1, 0, 1});
    // Each face its own square: indices that no two faces share.
    std::vector<int32_t> indices;
    for (int i = 0; i < 24; ++i) indices.push_back(i);
    input.primvars = {{"st", "faceVarying", 2, st, indices}};
    const Built built = Build(input);
    float sum = 9;
    for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
      for (size_t k = 0; k < 3; ++k) {
        const auto v = Value(*built.mesh, *built.Find("st"), t, k);
        sum = std::min(sum, v[0] + v[1]);
      }
    return sum;
  };
  EXPECT_GT(smallest("none"), 0.1f);
  for (const char* rule : {"cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"}) EXPECT_NEAR(smallest(rule), 0, 1e-6) << rule;
}

TEST(MeshSubdivision, TriangleRuleMatters) {
  MeshInput input = Octahedron();
  input.topology.scheme = "catmullClark";
  input.refineLevel = 2;
  const double catmullClark = Volume(*Build(input).mesh);
  input.topology.triangleSubdivisionRule = "smooth";
  EXPECT_GT(std::fabs(Volume(*Build(input).mesh) - catmullClark), 1e-4);
}

TEST(MeshSubdivision, NonManifoldAndRepeatedPoints) {
  MeshInput input = Polygons({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 0, -1}, {1, 0, -1}}, {4, 4, 4, 4},
                             {0, 1, 2, 3, 0, 1, 5, 4, 1, 0, 6, 7, 0, 0, 1, 2});
  for (const char* scheme : {"catmullClark", "bilinear", "loop"}) {
    input.topology.scheme = scheme;
    input.refineLevel = 2;
    EXPECT_TRUE(Build(input).mesh) << scheme;
  }
}

TEST(MeshSubdivision, SameInputSameBits) {
  MeshInput input = Refined(Cube("catmullClark"), 3);
  input.topology.creaseIndices = {4, 5, 6};
  input.topology.creaseLengths = {3};
  input.topology.creaseSharpnesses = {2.5f};
  std::vector<float> st(48);
  for (size_t i = 0; i < st.size(); ++i) st[i] = float(i % 5);
  input.primvars = {{"st", "faceVarying", 2, st, {}}};
  const Built a = Build(input), b = Build(input);
  EXPECT_EQ(std::memcmp(a.mesh->positions.data(), b.mesh->positions.data(), a.mesh->positions.size() * sizeof(Float3)), 0);
  EXPECT_EQ(std::memcmp(a.mesh->triangles.data(), b.mesh->triangles.data(), a.mesh->triangles.size() * sizeof(a.mesh->triangles[0])), 0);
  ASSERT_EQ(a.mesh->primvars.size(), b.mesh->primvars.size());
  for (size_t i = 0; i < a.mesh->primvars.size(); ++i) {
    EXPECT_EQ(a.mesh->primvars[i].values, b.mesh->primvars[i].values);
    EXPECT_EQ(a.mesh->primvars[i].indices, b.mesh->primvars[i].indices);
  }
}

TEST(MeshThroughput, SubdivisionToAMillionQuads) {
  MeshInput input = Refined(Grid(250, "catmullClark"), 2);
  std::vector<float> st;
  for (const int32_t i : input.topology.faceVertexIndices) st.insert(st.end(), {input.points[i].x, input.points[i].y});
  input.primvars = {{"st", "faceVarying", 2, st, {}}};
  const auto start = std::chrono::steady_clock::now();
  const auto mesh = BuildMesh(input, nullptr);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->triangles.size(), 2000000u);
  EXPECT_NEAR(Area(*mesh), 1, 1e-4);
  std::printf("1M quads by subdivision of 62,500 with face-varying st: %.2f s\n", seconds);
}

}  // namespace
}  // namespace delegate::mesh_test
