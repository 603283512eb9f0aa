// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the BVH builder promises: every item in exactly one leaf or, cut by spatial splits, held by several leaves
// together, boxes that hold their children exactly, bounded stack, the same bytes on any number of threads, and no harm from broken or absurd input.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "tests/wavefront/scene/bvh_fixture.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/mesh_trees.h"

namespace wavefront::bvh {
namespace {

// Checks all promises about one mesh tree; `inTree` triangles are expected in leaves.
void CheckMesh(const Soup& soup, const MeshBvh& mesh, size_t inTree) {
  ASSERT_FALSE(mesh.nodes.empty());
  ASSERT_EQ(mesh.triangles.size(), soup.triangles.size());
  Walk walk{mesh.nodes, kMaxLeafTriangles, [&](uint32_t i) { return TriangleBox(mesh.triangles[i]); },
            std::vector<uint32_t>(inTree), std::vector<uint32_t>(mesh.nodes.size())};
  const Box all = walk.Node(0, 1);
  EXPECT_TRUE(std::all_of(walk.itemUses.begin(), walk.itemUses.end(), [](uint32_t n) { return n == 1; }));
  EXPECT_TRUE(std::all_of(walk.nodeUses.begin(), walk.nodeUses.end(), [](uint32_t n) { return n == 1; }));
  EXPECT_LE(walk.depth, kMeshMaxDepth);
  if (inTree > 0) {
    EXPECT_EQ(all.lo[0], mesh.bounds.min.x);
    EXPECT_EQ(all.hi[2], mesh.bounds.max.z);
  } else {
    EXPECT_GT(mesh.bounds.min.x, mesh.bounds.max.x);
  }
  std::vector<bool> seen(soup.triangles.size());
  for (const TriangleRecord& t : mesh.triangles) {
    ASSERT_LT(t.meshTriangle, seen.size());
    EXPECT_FALSE(seen[t.meshTriangle]);
    seen[t.meshTriangle] = true;
    const UInt3 corners = soup.triangles[t.meshTriangle];
    if (corners.x < soup.positions.size()) {
      EXPECT_EQ(std::memcmp(&t.v0, &soup.positions[corners.x], sizeof t.v0), 0);
    }
  }
}

// The boxes that a ray has to meet to test each triangle: a row for each leaf that it stands in.
std::vector<std::vector<Box>> BoxesOnTheWay(const MeshBvh& mesh, size_t triangles) {
  std::vector<std::vector<Box>> result(triangles);
  const std::function<void(uint32_t, const Box&)> walk = [&](uint32_t index, const Box& above) {
    const BvhNode4& node = mesh.nodes[index];
    for (uint32_t c = 0; c < node.childCount; ++c) {
      Box box = ChildBox(node, c);
      for (int i = 0; i < 3; ++i) box.lo[i] = std::max(box.lo[i], above.lo[i]), box.hi[i] = std::min(box.hi[i], above.hi[i]);
      if ((node.children[c] & layout::kBvhLeafBit) == 0) {
        walk(node.children[c], box);
        continue;
      }
      const uint32_t first = node.children[c] & layout::kBvhLeafFirstMask;
      const uint32_t count = (node.children[c] >> layout::kBvhLeafCountShift & 7u) + 1;
      for (uint32_t i = first; i < first + count; ++i) result[mesh.triangles[i].meshTriangle].push_back(box);
    }
  };
  Box all;
  for (int i = 0; i < 3; ++i) all.lo[i] = -1e300, all.hi[i] = 1e300;
  walk(0, all);
  return result;
}

// Checks all promises about a tree with spatial splits: each record of an own leaf, each triangle within what its
// leaves hold, point by point.
void CheckCutMesh(const Soup& soup, const MeshBvh& mesh, size_t inTree) {
  const size_t broken = soup.triangles.size() - inTree;
  ASSERT_GE(mesh.triangles.size(), soup.triangles.size());
  ASSERT_LE(mesh.triangles.size(), soup.triangles.size() + inTree / kTrianglesPerPiece);
  Walk walk{mesh.nodes, kMaxLeafTriangles, [](uint32_t) { return Box{}; },
            std::vector<uint32_t>(mesh.triangles.size() - broken), std::vector<uint32_t>(mesh.nodes.size())};
  walk.Node(0, 1);
  EXPECT_TRUE(std::all_of(walk.itemUses.begin(), walk.itemUses.end(), [](uint32_t n) { return n == 1; }));
  EXPECT_TRUE(std::all_of(walk.nodeUses.begin(), walk.nodeUses.end(), [](uint32_t n) { return n == 1; }));
  EXPECT_LE(walk.depth, kMeshMaxDepth);
  const auto boxes = BoxesOnTheWay(mesh, soup.triangles.size());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  size_t lost = 0, held = 0;
  for (size_t i = 0; i < soup.triangles.size(); ++i) {
    held += !boxes[i].empty();
    const Float3 corners[3] = {soup.positions[soup.triangles[i].x], soup.positions[soup.triangles[i].y],
                               soup.positions[soup.triangles[i].z]};
    for (int k = 0; k < 24 && !boxes[i].empty(); ++k) {
      // The corners, points of the edges, and points inside.
      double w[3] = {unit(random), unit(random), unit(random)};
      if (k < 3) w[(k + 1) % 3] = w[(k + 2) % 3] = 0;
      if (k >= 3 && k < 12) w[k % 3] = 0;
      const double sum = w[0] + w[1] + w[2];
      double p[3] = {}, reach = 0;
      for (int c = 0; c < 3; ++c) {
        const double corner[3] = {corners[c].x, corners[c].y, corners[c].z};
        for (int a = 0; a < 3; ++a) p[a] += w[c] / sum * corner[a], reach = std::max(reach, std::fabs(corner[a]));
      }
      const auto holds = [&](const Box& box) {
        for (int a = 0; a < 3; ++a) {
          if (p[a] < box.lo[a] - 1e-14 * reach || p[a] > box.hi[a] + 1e-14 * reach) return false;
        }
        return true;
      };
      lost += std::none_of(boxes[i].begin(), boxes[i].end(), holds);
    }
  }
  EXPECT_EQ(lost, 0u);
  EXPECT_EQ(held, inTree);
}

void BuildAndCheck(const Soup& soup, size_t inTree) {
  CheckMesh(soup, BuildMeshBvh(soup.positions, soup.triangles, {}, {.spatialSplits = false}), inTree);
  CheckCutMesh(soup, BuildMeshBvh(soup.positions, soup.triangles, {}), inTree);
}

TEST(MeshBvh, CutsLongTrianglesWithinItsRoom) {
  for (const float scale : {1e-30f, 1.0f, 1e17f}) {
    SCOPED_TRACE(scale);
    const Soup soup = BeamsThroughClutter(5000, 100, scale);
    const MeshBvh mesh = BuildMeshBvh(soup.positions, soup.triangles, {});
    EXPECT_GT(mesh.triangles.size(), soup.triangles.size() + 100);
    CheckCutMesh(soup, mesh, soup.triangles.size());
  }
}

TEST(MeshBvh, WithoutSpatialSplitsHasEachTriangleOnce) {
  const Soup soup = BeamsThroughClutter(5000, 100);
  CheckMesh(soup, BuildMeshBvh(soup.positions, soup.triangles, {}, {.spatialSplits = false}), soup.triangles.size());
}

TEST(MeshBvh, HoldsEveryTriangle) {
  for (const uint32_t count : {1u, 2u, 3u, 4u, 5u, 8u, 9u, 17u, 100u, 5000u, 70000u}) {
    SCOPED_TRACE(count);
    BuildAndCheck(RandomSoup(count, 0.05f, count), count);
  }
}

TEST(MeshBvh, EmptyMeshHasARootWithoutChildren) {
  const MeshBvh mesh = BuildMeshBvh({}, {}, {});
  ASSERT_EQ(mesh.nodes.size(), 1u);
  EXPECT_EQ(mesh.nodes[0].childCount, 0);
  CheckMesh({}, mesh, 0);
}

TEST(MeshBvh, ScalesAndOffsetsKeepBoxesConservative) {
  for (const float scale : {1e-38f, 1e-30f, 1e-4f, 1e5f, 1e17f}) {
    SCOPED_TRACE(scale);
    BuildAndCheck(RandomSoup(3000, 0.1f, 7, scale), 3000);
  }
  Soup far = RandomSoup(3000, 0.1f, 8);
  for (Float3& p : far.positions) p.x += 1e5f, p.y -= 3e7f;
  size_t withArea = 0;
  for (const UInt3& t : far.triangles) {
    const auto same = [&](uint32_t a, uint32_t b) {
      return std::memcmp(&far.positions[a], &far.positions[b], sizeof(Float3)) == 0;
    };
    withArea += !same(t.x, t.y) && !same(t.y, t.z) && !same(t.z, t.x);
  }
  BuildAndCheck(far, withArea);
}

TEST(MeshBvh, MixedSizesStayWithinTheStack) {
  // Sizes over 30 orders of magnitude around one point: SAH alone would make a chain of single triangles.
  Soup soup;
  for (int i = 0; i < 2000; ++i) {
    const float s = std::pow(10.0f, -15.0f + 30.0f * i / 2000.0f);
    soup.Add({-s, -s, s}, {s, -s, s}, {0, s, s});
  }
  BuildAndCheck(soup, 2000);
}

TEST(MeshBvh, CoincidentTrianglesNeitherRecurseNorCrawl) {
  Soup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles.assign(1000000, {0, 1, 2});
  BuildAndCheck(soup, soup.triangles.size());
}

TEST(MeshBvh, BrokenTrianglesAreCountedAndStandInNoLeaf) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  Soup soup = RandomSoup(100, 0.1f, 3);
  soup.Add({kNan, 0, 0}, {1, 0, 0}, {0, 1, 0});
  soup.Add({0, 0, 0}, {kInf, 0, 0}, {0, 1, 0});
  soup.Add({0, 0, 0}, {1e30f, 0, 0}, {0, 1e30f, 0});
  soup.Add({0, 0, 0}, {1, 0, 0}, {1, 0, 0});  // no area
  soup.triangles.push_back({0, 1, 0xffffffffu});
  const MeshBvh mesh = BuildMeshBvh(soup.positions, soup.triangles, {});
  CheckMesh(soup, mesh, 100);
  EXPECT_EQ(mesh.brokenTriangles, 4u);
  Soup beams = BeamsThroughClutter(1000, 50);
  const size_t whole = beams.triangles.size();
  beams.Add({kNan, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const MeshBvh cut = BuildMeshBvh(beams.positions, beams.triangles, {});
  EXPECT_EQ(cut.triangles.back().meshTriangle, whole);
  CheckCutMesh(beams, cut, whole);
}

TEST(MeshBvh, KeepsMaterialSlots) {
  const Soup soup = RandomSoup(500, 0.1f, 5);
  std::vector<uint16_t> slots(500);
  for (uint16_t i = 0; i < 500; ++i) slots[i] = i * 131;
  for (const TriangleRecord& t : BuildMeshBvh(soup.positions, soup.triangles, slots).triangles) {
    EXPECT_EQ(t.materialSlot, slots[t.meshTriangle]);
  }
}

TEST(MeshBvh, ThreadCountDoesNotShow) {
  const Soup soup = BeamsThroughClutter(300000, 500);
  const MeshBvh one = BuildMeshBvh(soup.positions, soup.triangles, {}, {1});
  for (const unsigned threads : {2u, 3u, 7u}) {
    EXPECT_TRUE(SameBytes(one, BuildMeshBvh(soup.positions, soup.triangles, {}, {threads}))) << threads;
  }
}

TEST(MeshTrees, ManyMeshesEqualSingleBuilds) {
  std::vector<Soup> soups;
  std::vector<TreeJob> jobs(40);
  for (uint32_t i = 0; i < jobs.size(); ++i) soups.push_back(RandomSoup(i == 20 ? 80000 : i * 37, 0.1f, i));
  for (size_t i = 0; i < jobs.size(); ++i) jobs[i].positions = soups[i].positions, jobs[i].triangles = soups[i].triangles;
  TreeCounts counts;
  MakeTrees(jobs, 3, counts);
  EXPECT_EQ(counts.built, soups.size());
  for (size_t i = 0; i < soups.size(); ++i) {
    EXPECT_TRUE(SameBytes(jobs[i].mesh, BuildMeshBvh(soups[i].positions, soups[i].triangles, {}, {1}))) << i;
  }
}

TEST(InstanceBvh, HoldsEveryUsableInstanceOnceUnderItsOwnIndex) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const uint32_t count : {0u, 1u, 2u, 5u, 16u, 17u, 3000u}) {
    SCOPED_TRACE(count);
    std::vector<Bounds3> bounds(count);
    for (Bounds3& b : bounds) {
      b.min = {unit(random), unit(random), unit(random)};
      b.max = {b.min.x + 0.1f * unit(random), b.min.y + 0.1f, b.min.z};
    }
    const InstanceBvh tree = BuildInstanceBvh(bounds);
    EXPECT_EQ(tree.skipped, 0u);
    Walk walk{tree.nodes, 1,
              [&](uint32_t i) {
                const Bounds3& b = bounds[i];
                return Box{{b.min.x, b.min.y, b.min.z}, {b.max.x, b.max.y, b.max.z}};
              },
              std::vector<uint32_t>(count), std::vector<uint32_t>(tree.nodes.size())};
    walk.Node(0, 1);
    EXPECT_TRUE(std::all_of(walk.itemUses.begin(), walk.itemUses.end(), [](uint32_t n) { return n == 1; }));
    EXPECT_LE(walk.depth, kInstanceMaxDepth);
  }
}

TEST(InstanceBvh, SkipsUnusableBoundsAndSurvivesCoincidentOnes) {
  std::vector<Bounds3> bounds(100000, Bounds3{{0, 0, 0}, {1, 1, 1}});
  bounds[5] = Bounds3{};  // empty
  bounds[6].max.y = std::numeric_limits<float>::quiet_NaN();
  bounds[7].max.y = std::numeric_limits<float>::infinity();
  EXPECT_EQ(BuildInstanceBvh(bounds).skipped, 3u);
}

TEST(InstanceBounds, HoldTransformedCornersAndAllowForRounding) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int trial = 0; trial < 1000; ++trial) {
    Rows3x4 m, w{};
    for (Float4& row : m) row = {unit(random), unit(random), unit(random), 100 * unit(random)};
    const Bounds3 object{{-1, -2, 0}, {1, 3, 0}};
    const Bounds3 world = InstanceBounds(object, m, w);
    for (int corner = 0; corner < 4; ++corner) {
      const double x = corner & 1 ? 1 : -1, y = corner & 2 ? 3 : -2;
      const double px = double(m[0].x) * x + double(m[0].y) * y + m[0].w;
      EXPECT_LT(world.min.x, px);
      EXPECT_GT(world.max.x, px);
    }
    EXPECT_LT(double(world.max.x) - world.min.x, 2 * (std::fabs(m[0].x) + 3 * std::fabs(m[0].y)) + 1e-3);
  }
}

TEST(InstanceBounds, SingularTransformsAreEmpty) {
  Rows3x4 m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, w = m;
  w[0].x = std::numeric_limits<float>::infinity();
  const Bounds3 b = InstanceBounds({{0, 0, 0}, {1, 1, 1}}, m, w);
  EXPECT_GT(b.min.x, b.max.x);
  EXPECT_GT(InstanceBounds(Bounds3{}, m, m).min.x, 0);
}

TEST(ParallelFor, CallsEachIndexOnceAndPassesErrorsOn) {
  std::vector<std::atomic<int>> calls(1000);
  ParallelFor(calls.size(), 4, [&](size_t i) { ++calls[i]; });
  for (const auto& n : calls) EXPECT_EQ(n.load(), 1);
  EXPECT_THROW(ParallelFor(100, 4, [](size_t i) { if (i == 50) throw std::runtime_error("stop"); }),
               std::runtime_error);
}

}  // namespace
}  // namespace wavefront::bvh
