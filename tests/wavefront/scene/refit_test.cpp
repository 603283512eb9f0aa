// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What refits promise: the boxes of a build for triangles that moved, in a tree that stays, and no tree where other
// triangles can be hit; and that costs tell a tree which has suffered from one that has not.
#include "wavefront/scene/bvh/refit.h"

#include <limits>

#include "tests/wavefront/scene/bvh_fixture.h"
#include "wavefront/scene/bvh/mesh_trees.h"
#include "wavefront/scene/bvh/tree_cost.h"

namespace wavefront::bvh {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<Float3> Moved(const Soup& soup, float by, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-by, by);
  std::vector<Float3> positions = soup.positions;
  for (Float3& p : positions) p = {p.x + unit(random), p.y + unit(random), p.z + unit(random)};
  return positions;
}

// Every record in one leaf, with the corners of its triangle, and all boxes above it around all of it.
void CheckHolds(const MeshBvh& mesh, const std::vector<Float3>& positions, const std::vector<UInt3>& triangles) {
  Walk walk{mesh.nodes, kMaxLeafTriangles, [&](uint32_t i) { return TriangleBox(mesh.triangles[i]); },
            std::vector<uint32_t>(mesh.recordsInLeaves), std::vector<uint32_t>(mesh.nodes.size())};
  const Box all = walk.Node(0, 1);
  EXPECT_TRUE(std::all_of(walk.itemUses.begin(), walk.itemUses.end(), [](uint32_t n) { return n == 1; }));
  EXPECT_TRUE(std::all_of(walk.nodeUses.begin(), walk.nodeUses.end(), [](uint32_t n) { return n == 1; }));
  const double bounds[2][3] = {{mesh.bounds.min.x, mesh.bounds.min.y, mesh.bounds.min.z},
                               {mesh.bounds.max.x, mesh.bounds.max.y, mesh.bounds.max.z}};
  EXPECT_TRUE(std::equal(all.lo, all.lo + 3, bounds[0]));
  EXPECT_TRUE(std::equal(all.hi, all.hi + 3, bounds[1]));
  for (const TriangleRecord& t : mesh.triangles) {
    const UInt3 corners = triangles[t.meshTriangle];
    EXPECT_EQ(std::memcmp(&t.v0, &positions[corners.x], sizeof t.v0), 0);
    EXPECT_EQ(std::memcmp(&t.v1, &positions[corners.y], sizeof t.v1), 0);
    EXPECT_EQ(std::memcmp(&t.v2, &positions[corners.z], sizeof t.v2), 0);
  }
}

TEST(Refit, BoxesHoldMovedTriangles) {
  for (const Soup& soup : {RandomSoup(1, 0.05f, 1), RandomSoup(5, 0.05f, 2), RandomSoup(3000, 0.05f, 3), RandomSoup(70000, 0.05f, 4),
                           BeamsThroughClutter(5000, 100)}) {
    SCOPED_TRACE(soup.triangles.size());
    const MeshBvh built = BuildMeshBvh(soup.positions, soup.triangles, {});
    MeshBvh mesh = built;
    for (const float by : {0.001f, 0.1f, 30.0f}) {
      const std::vector<Float3> positions = Moved(soup, by, 5);
      ASSERT_TRUE(RefitMeshBvh(positions, soup.triangles, {}, mesh));
      CheckHolds(mesh, positions, soup.triangles);
    }
    EXPECT_EQ(mesh.triangles.size(), built.triangles.size());
  }
}

// To where the triangles were: the same boxes to the bit, so those of a refit are no looser than a build's.
TEST(Refit, LeadsBackToTheBuild) {
  for (const float scale : {1e-38f, 1e-4f, 1.0f, 1e17f}) {
    SCOPED_TRACE(scale);
    const Soup soup = RandomSoup(20000, 0.05f, 6, scale);
    const MeshBvh built = BuildMeshBvh(soup.positions, soup.triangles, {}, {.spatialSplits = false});
    MeshBvh mesh = built;
    ASSERT_TRUE(RefitMeshBvh(soup.positions, soup.triangles, {}, mesh));
    EXPECT_TRUE(SameBytes(mesh, built));
    ASSERT_TRUE(RefitMeshBvh(Moved(soup, 0.2f * scale, 7), soup.triangles, {}, mesh));
    EXPECT_FALSE(SameBytes(mesh, built));
    ASSERT_TRUE(RefitMeshBvh(soup.positions, soup.triangles, {}, mesh));
    EXPECT_TRUE(SameBytes(mesh, built));
  }
}

TEST(Refit, ThreadCountDoesNotShow) {
  const Soup soup = BeamsThroughClutter(100000, 300);
  const std::vector<Float3> positions = Moved(soup, 0.01f, 8);
  const MeshBvh built = BuildMeshBvh(soup.positions, soup.triangles, {});
  MeshBvh one = built;
  ASSERT_TRUE(RefitMeshBvh(positions, soup.triangles, {}, one, 1));
  const TreeCost cost = CostOf(one, 1);
  for (const unsigned threads : {2u, 3u, 7u}) {
    MeshBvh many = built;
    ASSERT_TRUE(RefitMeshBvh(positions, soup.triangles, {}, many, threads));
    EXPECT_TRUE(SameBytes(one, many)) << threads;
    EXPECT_EQ(CostOf(many, threads).visits, cost.visits);
    EXPECT_EQ(CostOf(many, threads).items, cost.items);
  }
}

TEST(Refit, IsRefusedWhereOtherTrianglesCanBeHit) {
  Soup soup = RandomSoup(100, 0.1f, 9);
  soup.Add({kNan, 0, 0}, {1, 0, 0}, {0, 1, 0});
  soup.Add({0, 0, 0}, {1, 0, 0}, {1, 0, 0});  // no area
  const std::vector<uint16_t> slots(soup.triangles.size(), 7);
  const MeshBvh built = BuildMeshBvh(soup.positions, soup.triangles, {});
  const auto refits = [&](size_t vertex, Float3 to, uint32_t broken) {
    std::vector<Float3> positions = soup.positions;
    positions[vertex] = to;
    MeshBvh mesh = built;
    const bool done = RefitMeshBvh(positions, soup.triangles, slots, mesh);
    if (done) {
      EXPECT_EQ(mesh.brokenTriangles, broken);
      for (const TriangleRecord& t : mesh.triangles) EXPECT_EQ(t.materialSlot, 7u);
    }
    return done;
  };
  EXPECT_TRUE(refits(5, {1, 2, 3}, 1));
  EXPECT_FALSE(refits(5, {1, kNan, 3}, 0));            // broken now
  EXPECT_FALSE(refits(5, {1, 2e18f, 3}, 0));
  EXPECT_FALSE(refits(5, soup.positions[4], 0));       // without area now
  EXPECT_FALSE(refits(300, {0, 0, 0}, 0));             // no longer broken
  EXPECT_FALSE(refits(305, {0, 1, 0}, 0));             // has area now
  EXPECT_TRUE(refits(305, {0, kNan, 0}, 2));           // in no leaf before and after
}

// Leaves that hold all of a long triangle, where they held a piece, make a tree that rays would be lost in: the first edit builds it
// fast, those after it are refits.
TEST(MeshTrees, AMeshWithManyCutsIsBuiltFastOnce) {
  const Soup soup = BeamsThroughClutter(5000, 100);
  std::vector<TreeJob> jobs(1);
  TreeCounts counts;
  for (const TreeJob::Way expected : {TreeJob::Way::Build, TreeJob::Way::BuildFast, TreeJob::Way::Refit, TreeJob::Way::Refit}) {
    const std::vector<Float3> positions = Moved(soup, 0.0001f, 11);
    jobs[0].positions = positions;
    jobs[0].triangles = soup.triangles;
    MakeTrees(jobs, 2, counts);
    EXPECT_EQ(jobs[0].way, expected);
    if (expected != TreeJob::Way::Build) CheckHolds(jobs[0].mesh, positions, soup.triangles);  // those boxes hold pieces
    jobs[0].way = TreeJob::Way::Refit;
  }
  EXPECT_EQ(counts.built, 1u);
  EXPECT_EQ(counts.builtFast, 1u);
  EXPECT_EQ(counts.refitted, 2u);
}

TEST(Refit, OfInstancesHoldsThemAndKnowsWhoIsMissing) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Bounds3> bounds(3000);
  const auto place = [&](Bounds3& b) {
    b.min = {unit(random), unit(random), unit(random)};
    b.max = {b.min.x + 0.1f * unit(random), b.min.y + 0.1f, b.min.z};
  };
  for (Bounds3& b : bounds) place(b);
  bounds[17] = Bounds3{};
  const InstanceBvh built = BuildInstanceBvh(bounds);
  for (Bounds3& b : bounds) place(b);
  InstanceBvh tree = built;
  EXPECT_FALSE(RefitInstanceBvh(bounds, tree)) << "one came";
  bounds[18] = Bounds3{};
  tree = built;
  EXPECT_FALSE(RefitInstanceBvh(bounds, tree)) << "one came, another went";
  std::swap(bounds[17], bounds[18]);
  tree = built;
  ASSERT_TRUE(RefitInstanceBvh(bounds, tree));
  std::vector<uint32_t> uses(bounds.size());
  Walk walk{tree.nodes, 1,
            [&](uint32_t i) {
              const Bounds3& b = bounds[i];
              return Box{{b.min.x, b.min.y, b.min.z}, {b.max.x, b.max.y, b.max.z}};
            },
            uses, std::vector<uint32_t>(tree.nodes.size())};
  const Box all = walk.Node(0, 1);
  EXPECT_EQ(std::count(walk.itemUses.begin(), walk.itemUses.end(), 1u), 2999);
  EXPECT_EQ(all.hi[1], tree.bounds.max.y);
  EXPECT_EQ(tree.skipped, 1u);
}

TEST(TreeCost, GrowsWithDisorderAndNotWithSize) {
  const Soup soup = RandomSoup(5000, 0.01f, 10);
  const MeshBvh built = BuildMeshBvh(soup.positions, soup.triangles, {}, {.spatialSplits = false});
  const auto growth = [&](const auto& move) {
    std::vector<Float3> positions = soup.positions;
    for (size_t i = 0; i < positions.size(); ++i) move(i, positions[i]);
    MeshBvh mesh = built;
    EXPECT_TRUE(RefitMeshBvh(positions, soup.triangles, {}, mesh));
    return Growth(CostOf(built), CostOf(mesh));
  };
  EXPECT_EQ(growth([](size_t, Float3&) {}), 1);
  EXPECT_EQ(growth([](size_t, Float3& p) { p = {4 * p.x, 4 * p.y, 4 * p.z}; }), 1);
  EXPECT_LT(growth([](size_t, Float3& p) { p.y += 0.1f * p.x; }), kMostGrowth);
  // Triangles change places.
  EXPECT_GT(growth([&](size_t i, Float3& p) { p = soup.positions[(i + 3000) % soup.positions.size()]; }), 1.2 * kMostGrowth);
  // A few are dragged far out: only the items' measure sees it.
  EXPECT_GT(growth([](size_t i, Float3& p) { if (i < 3) p.y += 40; }), kMostGrowth);
}

// Triangles that grow with the nodes around them: only the root's measure sees it.
TEST(TreeCost, GrowsWhereACoherentMeshFallsApart) {
  Soup grid;
  constexpr uint32_t kSide = 60;
  for (uint32_t i = 0; i <= kSide; ++i)
    for (uint32_t j = 0; j <= kSide; ++j) grid.positions.push_back({0.1f * static_cast<float>(i), 0.01f * static_cast<float>(i * j % 7), 0.1f * static_cast<float>(j)});
  for (uint32_t i = 0; i < kSide; ++i)
    for (uint32_t j = 0; j < kSide; ++j) {
      const uint32_t a = i * (kSide + 1) + j;
      grid.triangles.insert(grid.triangles.end(), {{a, a + 1, a + kSide + 1}, {a + 1, a + kSide + 2, a + kSide + 1}});
    }
  const MeshBvh built = BuildMeshBvh(grid.positions, grid.triangles, {});
  MeshBvh mesh = built;
  ASSERT_TRUE(RefitMeshBvh(Moved(grid, 2, 12), grid.triangles, {}, mesh));
  EXPECT_GT(Growth(CostOf(built), CostOf(mesh)), 2 * kMostGrowth);
}

}  // namespace
}  // namespace wavefront::bvh
