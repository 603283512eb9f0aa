// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The rays that wavefront-bench casts: through the pixels, and from what they hit.
#include "plugin/bench/rays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "plugin/bench/session.h"
#include "plugin/bench/sweeps.h"

namespace bench {
namespace {

using namespace wavefront;

// A square of side 2 in the plane z = 0, and another one 10 to the right and twice as large.
delegate::CapturedScene TwoSquares() {
  delegate::CapturedScene scene;
  scene.info.name = "squares";
  MeshData mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.meshes[0] = mesh;
  Matrix4d right;
  right.m[0][0] = right.m[1][1] = right.m[2][2] = 2;
  right.m[3][0] = 10;
  InstanceData group;
  group.mesh = 0;
  group.transforms = {{{0, Matrix4d()}}, {{0, right}}};
  scene.instances[0] = group;
  Matrix4d back;
  back.m[3][2] = 4;
  scene.camera.transforms = {{0, back}};
  scene.camera.left = scene.camera.bottom = -0.5f;
  scene.camera.right = scene.camera.top = 0.5f;
  scene.settings.width = 64;
  scene.settings.height = 32;
  return scene;
}

TEST(BenchRays, AllInstancesBecomeOneMesh) {
  auto flat = Flatten(TwoSquares());
  ASSERT_TRUE(flat) << flat.error().message;
  ASSERT_EQ(flat->positions.size(), 8u);
  EXPECT_EQ(flat->positions[6].x, 12);
  EXPECT_EQ(flat->positions[6].y, 2);
  ASSERT_EQ(flat->triangles.size(), 4u);
  EXPECT_EQ(flat->triangles[3].z, 7u);
  EXPECT_FALSE(Flatten(delegate::CapturedScene()).ok()) << "there is nothing to hit";
}

TEST(BenchRays, TheCamerasGoThroughItsPixelsAndNoMoreThanAskedFor) {
  const auto scene = TwoSquares();
  const auto rays = CameraRays(scene.camera, 64, 32, 5000);
  ASSERT_EQ(rays.size(), 2u * 64 * 32);
  for (const std::size_t i : {0u, 63u, 64u * 31, 64u * 32 + 5}) {
    const CasterRay& r = rays[i];
    const double x = r.direction.x / -r.direction.z, y = r.direction.y / -r.direction.z;
    const auto pixel = static_cast<double>(i % (64 * 32) % 64), row = std::floor(static_cast<double>(i % (64 * 32)) / 64);
    EXPECT_NEAR(x, -0.5 + (pixel + 0.5) / 64, 0.5 / 64 + 1e-6);
    EXPECT_NEAR(y, 0.5 - (row + 0.5) / 32, 0.5 / 32 + 1e-6) << "row 0 is at the top";
    EXPECT_EQ(r.origin.z, 4);
  }
  const auto few = CameraRays(scene.camera, 3840, 2160, 10000).size();
  EXPECT_LE(few, 10000u);
  EXPECT_GT(few, 2500u);
}

TEST(BenchRays, BouncesAreDistributedByTheCosineOnTheSideThatWasHit) {
  auto flat = Flatten(TwoSquares());
  ASSERT_TRUE(flat);
  std::vector<CasterRay> rays(20000, {{0.5f, 0.1f, 3}, 0, {0, 0, -1}, 100});
  std::vector<CasterHit> hits(rays.size(), {3, 0});
  hits[7] = {100, kNoTriangle};
  hits[8].t = std::nanf("");
  const auto bounced = Bounced(*flat, rays, hits, 3);
  ASSERT_EQ(bounced.size(), rays.size() - 2);
  double sum = 0, across = 0;
  for (const CasterRay& r : bounced) {
    EXPECT_GE(r.direction.z, 0);
    EXPECT_GT(r.origin.z, 0);
    sum += r.direction.z;
    across += r.direction.x;
  }
  // Mean of the cosine 2/3, its deviation sqrt(1/18); of a direction across 0 and 1/2. Five standard errors.
  const auto n = static_cast<double>(bounced.size());
  EXPECT_NEAR(sum / n, 2.0 / 3, 5 * std::sqrt(1.0 / 18 / n));
  EXPECT_NEAR(across / n, 0, 5 * 0.5 / std::sqrt(n));
}

TEST(BenchRays, AreCountedTimedAndWrittenDown) {
  Options options;
  options.files = {"a"};
  options.rays = true;
  options.runs = 1;
  Session session(options, {"device", "driver", "CPU", 1e9});
  session.Run(FindSweep("triangles")->make({"hills", 2000, 0}, true));
  EXPECT_TRUE(session.results()[0].diagnostics.empty());
  session.Run(delegate::CapturedScene());
  auto displaced = TwoSquares();
  displaced.meshes[0].displacements = {std::make_shared<const DisplacementData>()};
  session.Run(displaced);
  EXPECT_THAT(session.results()[2].diagnostics, testing::ElementsAre(testing::HasSubstr("without their displacements")));
  EXPECT_EQ(session.Finish(), kFailed);
  EXPECT_NE(session.results()[1].error, "") << "an empty scene";
  const SceneResult& result = session.results()[0];
  ASSERT_EQ(result.error, "");
  ASSERT_EQ(result.rays.size(), 3u);
  EXPECT_NEAR(static_cast<double>(result.rays[0].triangles), 2000, 100);
  for (std::size_t i = 0; i < 3; ++i) {
    const RayMeasurement& m = result.rays[i];
    EXPECT_GT(m.hits, 0u);
    EXPECT_EQ(m.overflows, 0u);
    if (i > 0) EXPECT_EQ(m.rays, result.rays[i - 1].hits) << "each hit goes on";
    EXPECT_GT(m.mrays(), 0);
    EXPECT_GT(m.bytes.nodes, 84) << "a ray that misses the root";
    EXPECT_GT(m.bytes.triangles, 0);
  }
}

}  // namespace
}  // namespace bench
