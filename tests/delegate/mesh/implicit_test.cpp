// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Implicit shapes: closed, outward, of the right size and place, with normals that belong to the surface.
#include "delegate/mesh/implicit.h"

#include <limits>
#include <numbers>
#include <tuple>

#include "tests/delegate/mesh/mesh_test_util.h"

namespace delegate::mesh_test {
namespace {

constexpr double kPi = std::numbers::pi;

Built BuildShape(ImplicitInput input) {
  input.path = "/World/mesh";
  Built built;
  built.mesh = BuildImplicit(input, [&](const Diagnostic& d) { built.diagnostics.push_back(d); });
  if (built.mesh) ExpectValid(*built.mesh, 6, 1);
  return built;
}

ImplicitInput Shape(ImplicitShape shape) {
  ImplicitInput input;
  input.shape = shape;
  return input;
}

// Every edge, by position, is used once in each direction.
void ExpectClosed(const MeshData& mesh) {
  using Key = std::tuple<float, float, float>;
  std::map<std::pair<Key, Key>, int> edges;
  const auto key = [&](uint32_t i) {
    const Float3 p = mesh.positions[i];
    return Key{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
  };
  for (const auto& t : mesh.triangles) {
    const Key k[3] = {key(t.x), key(t.y), key(t.z)};
    for (int i = 0; i < 3; ++i) ++edges[{k[i], k[(i + 1) % 3]}];
  }
  int open = 0;
  for (const auto& [edge, count] : edges) {
    const auto twin = edges.find({edge.second, edge.first});
    if (count != 1 || twin == edges.end()) ++open;
  }
  EXPECT_EQ(open, 0);
}

// Shading normals agree with the triangles within `degrees`.
void ExpectNormalsFit(const Built& built, double degrees) {
  double worst = 0;
  for (size_t t = 0; t < built.mesh->triangles.size(); ++t)
    for (size_t k = 0; k < 3; ++k) worst = std::max(worst, AngleBetween(NormalAt(built, t, k), TriangleAreaVector(*built.mesh, t)));
  EXPECT_LT(worst * 180 / kPi, degrees);
}

std::pair<Vec3, Vec3> Extent(const MeshData& mesh) {
  Vec3 low(1e9, 1e9, 1e9), high(-1e9, -1e9, -1e9);
  for (const Float3& p : mesh.positions) {
    low = {std::min<double>(low.x, p.x), std::min<double>(low.y, p.y), std::min<double>(low.z, p.z)};
    high = {std::max<double>(high.x, p.x), std::max<double>(high.y, p.y), std::max<double>(high.z, p.z)};
  }
  return {low, high};
}

void ExpectSolid(const Built& built, double volume, const Vec3& low, const Vec3& high) {
  ASSERT_TRUE(built.mesh);
  ExpectClosed(*built.mesh);
  ExpectNormalsFit(built, 2.1);
  EXPECT_NEAR(Volume(*built.mesh) / volume, 1, 1e-3);
  const auto [l, h] = Extent(*built.mesh);
  ExpectNear(l, low, 1e-6);
  ExpectNear(h, high, 1e-6);
}

TEST(Implicit, Sphere) {
  ImplicitInput input = Shape(ImplicitShape::Sphere);
  input.radius = 3;
  const Built built = BuildShape(input);
  ExpectSolid(built, 4.0 / 3 * kPi * 27, {-3, -3, -3}, {3, 3, 3});
  double gap = 0;
  // The deepest that an edge of the flat quads lies inside; their diagonals (x to y of every second triangle) are
  // never part of the outline.
  for (const auto& t : built.mesh->triangles)
    gap = std::max(gap, 3 - Length((Vec3(built.mesh->positions[t.y]) + Vec3(built.mesh->positions[t.z])) * 0.5));
  EXPECT_LT(gap / 3 * 540, 0.1);  // pixels, where the sphere fills 1080 rows
}

TEST(Implicit, Cube) {
  ImplicitInput input = Shape(ImplicitShape::Cube);
  input.size = 4;
  const Built built = BuildShape(input);
  ExpectSolid(built, 64, {-2, -2, -2}, {2, 2, 2});
  const Vec3 outward[] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  for (size_t t = 0; t < 12; ++t) ExpectNear(NormalAt(built, t, 0), outward[built.mesh->faceIds[t]], 1e-7);
}

TEST(Implicit, Cone) {
  ImplicitInput input = Shape(ImplicitShape::Cone);
  input.radius = 2;
  input.height = 3;
  ExpectSolid(BuildShape(input), kPi * 4, {-2, -2, -1.5}, {2, 2, 1.5});
  input.axis = "Y";
  const Built onY = BuildShape(input);
  ExpectSolid(onY, kPi * 4, {-2, -1.5, -2}, {2, 1.5, 2});
  EXPECT_TRUE(HasPosition(*onY.mesh, {0, 1.5, 0}));  // the tip is at +axis
  input.axis = "X";
  ExpectSolid(BuildShape(input), kPi * 4, {-1.5, -2, -2}, {1.5, 2, 2});
}

TEST(Implicit, Cylinder) {
  ImplicitInput input = Shape(ImplicitShape::Cylinder);
  input.height = 5;
  input.axis = "X";
  ExpectSolid(BuildShape(input), kPi * 5, {-2.5, -1, -1}, {2.5, 1, 1});
  input.axis = "Z";
  input.radiusBottom = 2;
  input.radiusTop = 1;
  ExpectSolid(BuildShape(input), kPi * 5 * (4 + 2 + 1) / 3, {-2, -2, -2.5}, {2, 2, 2.5});
  input.radiusTop = 0;
  ExpectSolid(BuildShape(input), kPi * 5 * 4 / 3, {-2, -2, -2.5}, {2, 2, 2.5});
}

TEST(Implicit, Capsule) {
  ImplicitInput input = Shape(ImplicitShape::Capsule);
  input.radius = 0.5;
  input.height = 1;
  const double ball = 4.0 / 3 * kPi / 8;
  ExpectSolid(BuildShape(input), ball + kPi / 4, {-0.5, -0.5, -1}, {0.5, 0.5, 1});
  input.height = 0;
  ExpectSolid(BuildShape(input), ball, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  input.height = 2;
  input.radiusBottom = 1;
  input.radiusTop = 0.25;
  input.axis = "Y";
  ExpectSolid(BuildShape(input), 2.0 / 3 * kPi * (1 + 1.0 / 64) + kPi * 2 / 3 * (1 + 0.25 + 1.0 / 16), {-1, -2, -1}, {1, 1.25, 1});
  input.radiusTop = 0;
  ExpectSolid(BuildShape(input), 2.0 / 3 * kPi + kPi * 2 / 3, {-1, -2, -1}, {1, 1, 1});
}

TEST(Implicit, Plane) {
  ImplicitInput input = Shape(ImplicitShape::Plane);
  input.width = 2;
  input.length = 6;
  const std::map<std::string, std::pair<Vec3, Vec3>> expected = {
      {"X", {{0, 3, 1}, {1, 0, 0}}}, {"Y", {{1, 0, 3}, {0, 1, 0}}}, {"Z", {{1, 3, 0}, {0, 0, 1}}}};
  for (const auto& [axis, place] : expected) {
    input.axis = axis;
    const Built built = BuildShape(input);
    const auto [low, high] = Extent(*built.mesh);
    ExpectNear(high, place.first, 1e-6);
    ExpectNear(low, -place.first, 1e-6);
    for (size_t t = 0; t < 2; ++t) {
      ExpectNear(NormalAt(built, t, 0), place.second, 1e-7);
      ExpectNear(Normalized(TriangleAreaVector(*built.mesh, t)), place.second, 1e-7);
    }
  }
}

// st is not mirrored: it turns as the triangle does, seen from outside.
TEST(Implicit, TextureCoordinatesFaceOutward) {
  for (const ImplicitShape shape : {ImplicitShape::Sphere, ImplicitShape::Cube, ImplicitShape::Cone, ImplicitShape::Cylinder,
                                    ImplicitShape::Capsule, ImplicitShape::Plane})
    for (const char* axis : {"X", "Y", "Z"}) {
      ImplicitInput input = Shape(shape);
      input.axis = axis;
      const Built built = BuildShape(input);
      for (size_t t = 0; t < built.mesh->triangles.size(); ++t) {
        std::vector<float> st[3];
        for (size_t k = 0; k < 3; ++k) {
          st[k] = Value(*built.mesh, *built.Find("st"), t, k);
          ASSERT_TRUE(st[k][0] >= 0 && st[k][0] <= 1.01 && st[k][1] >= 0 && st[k][1] <= 1);
        }
        const double turn = (st[1][0] - st[0][0]) * (st[2][1] - st[0][1]) - (st[1][1] - st[0][1]) * (st[2][0] - st[0][0]);
        ASSERT_GT(turn, 0) << static_cast<int>(shape) << axis;
      }
    }
}

TEST(Implicit, BadSizesAndAxes) {
  const double bad[] = {0, -1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
  for (const ImplicitShape shape : {ImplicitShape::Sphere, ImplicitShape::Cube, ImplicitShape::Cone, ImplicitShape::Cylinder,
                                    ImplicitShape::Capsule, ImplicitShape::Plane})
    for (const double size : bad) {
      ImplicitInput input = Shape(shape);
      input.size = input.radius = input.width = size;
      const Built built = BuildShape(input);
      EXPECT_FALSE(built.mesh);
      EXPECT_TRUE(built.Told("implicit-bad-size"));
    }
  ImplicitInput input = Shape(ImplicitShape::Cone);
  input.axis = "W";
  const Built built = BuildShape(input);
  EXPECT_TRUE(built.mesh);
  EXPECT_TRUE(built.Told("implicit-bad-axis", "\"W\""));
}

}  // namespace
}  // namespace delegate::mesh_test
