// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/ray_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace wavefront {
namespace {

TEST(RayCaster, FindsTheNearestTriangleInTheMeshsOrder) {
  // Two quads, the farther one first.
  std::vector<Float3> points;
  for (const float z : {-2.0f, -1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      for (const float x : {-1.0f, 1.0f}) points.push_back({x, y, z});
    }
  }
  const std::vector<UInt3> triangles = {{0, 1, 2}, {1, 3, 2}, {4, 5, 6}, {5, 7, 6}};
  auto caster = RayCaster::Create("", points, triangles);
  ASSERT_TRUE(caster) << caster.error().message;
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const std::vector<CasterRay> rays = {{{-0.5f, -0.5f, 1}, 0, {0, 0, -1}, kInfinite},
                                       {{0.5f, 0.5f, -1.5f}, 0, {0, 0, -1}, kInfinite},
                                       {{5, 5, 1}, 0, {0, 0, -1}, kInfinite}};
  Status set = caster.value()->SetRays(rays);
  ASSERT_TRUE(set) << set.error().message;
  Status cast = caster.value()->Cast();
  ASSERT_TRUE(cast) << cast.error().message;
  auto hits = caster.value()->Hits();
  ASSERT_TRUE(hits) << hits.error().message;
  ASSERT_EQ(hits.value().size(), rays.size());
  EXPECT_EQ(hits.value()[0].triangle, 2u);
  EXPECT_EQ(hits.value()[0].t, 2.0f);
  EXPECT_EQ(hits.value()[1].triangle, 1u);
  EXPECT_EQ(hits.value()[1].t, 0.5f);
  EXPECT_EQ(hits.value()[2].triangle, kNoTriangle);

  auto seconds = caster.value()->CastTimed(5);
  ASSERT_TRUE(seconds) << seconds.error().message;
  EXPECT_GT(seconds.value(), 0);
  EXPECT_EQ(caster.value()->Hits().value()[0].t, 2.0f);
}

TEST(RayCaster, CountsWhatARayFetches) {
  const std::vector<Float3> points = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  const std::vector<UInt3> triangles = {{0, 1, 2}};
  auto caster = RayCaster::Create("", points, triangles);
  ASSERT_TRUE(caster) << caster.error().message;
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const CasterRay aside{{5, 5, 1}, 0, {0, 0, -1}, kInfinite}, through{{0, 0, 1}, 0, {0, 0, -1}, kInfinite}, none{{0, 0, 1}, 0, {0, 0, 0}, kInfinite};
  // A tree: 16 bytes for its reach. A step: 64 of the node, and the 4 of the child that is next, as each time that something
  // comes off the stack.
  struct Row { CasterRay ray; double nodes, triangles; };
  for (const Row& row : {Row{none, 0, 0}, {aside, 16 + 64 + 4, 0}, {through, 2 * (16 + 64) + 4 * 4, 48}}) {
    ASSERT_TRUE(caster.value()->SetRays(std::vector<CasterRay>{row.ray, row.ray}).ok());
    auto bytes = caster.value()->CountBytes();
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(bytes->nodes, row.nodes);
    EXPECT_EQ(bytes->triangles, row.triangles);
  }
  EXPECT_EQ(caster.value()->Hits().value()[1].t, 1.0f) << "the hits of a cast are left";
}

TEST(RayCaster, RaysOfNoLengthEndAtOnceWhateverTheSignOfZero) {
  // More triangles than a ray has steps, all of them behind the ray.
  std::vector<Float3> points;
  std::vector<UInt3> triangles;
  constexpr uint32_t kSide = 80;
  for (uint32_t y = 0; y <= kSide; ++y) {
    for (uint32_t x = 0; x <= kSide; ++x) points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>((x * y) % 3)});
  }
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t i = y * (kSide + 1) + x;
      triangles.push_back({i, i + 1, i + kSide + 1});
      triangles.push_back({i + 1, i + kSide + 2, i + kSide + 1});
    }
  }
  auto caster = RayCaster::Create("", points, triangles);
  ASSERT_TRUE(caster) << caster.error().message;
  const std::vector<CasterRay> rays = {{{200, 200, 200}, 0.0f, {0.6f, 0.64f, 0.48f}, -0.0f},
                                       {{200, 200, 200}, -0.0f, {0.6f, 0.64f, 0.48f}, 0.0f},
                                       {{200, 200, 200}, -1.0f, {0.6f, 0.64f, 0.48f}, -0.5f}};
  ASSERT_TRUE(caster.value()->SetRays(rays).ok());
  ASSERT_TRUE(caster.value()->Cast().ok());
  auto hits = caster.value()->Hits();
  ASSERT_TRUE(hits) << hits.error().message;
  for (const CasterHit& hit : hits.value()) {
    EXPECT_EQ(hit.triangle, kNoTriangle);
    EXPECT_FALSE(std::isnan(hit.t)) << "the ray took too many steps";
  }
}

}  // namespace
}  // namespace wavefront
