// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/ray_caster.h"

#include <gtest/gtest.h>

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
}

}  // namespace
}  // namespace wavefront
