// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Triangles to build trees over, and a walk that checks the shape of one.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront::bvh {

struct Soup {
  std::vector<Float3> positions;
  std::vector<UInt3> triangles;

  void Add(Float3 a, Float3 b, Float3 c) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
};

inline Soup RandomSoup(uint32_t count, float size, uint32_t seed, float scale = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  Soup soup;
  for (uint32_t i = 0; i < count; ++i) {
    const Float3 c{unit(random), unit(random), unit(random)};
    const auto corner = [&] {
      return Float3{(c.x + size * unit(random)) * scale, (c.y + size * unit(random)) * scale,
                    (c.z + size * unit(random)) * scale};
    };
    const Float3 p0 = corner(), p1 = corner(), p2 = corner();
    soup.Add(p0, p1, p2);
  }
  return soup;
}

struct Box {
  double lo[3] = {1e300, 1e300, 1e300}, hi[3] = {-1e300, -1e300, -1e300};
  void Extend(const Box& b) {
    for (int i = 0; i < 3; ++i) lo[i] = std::min(lo[i], b.lo[i]), hi[i] = std::max(hi[i], b.hi[i]);
  }
  bool Holds(const Box& b) const {
    for (int i = 0; i < 3; ++i) {
      if (b.lo[i] < lo[i] || b.hi[i] > hi[i]) return false;
    }
    return true;
  }
};

inline Box ChildBox(const BvhNode4& node, uint32_t child) {
  const uint8_t* const lows[3] = {node.loX, node.loY, node.loZ};
  const uint8_t* const highs[3] = {node.hiX, node.hiY, node.hiZ};
  Box box;
  for (int i = 0; i < 3; ++i) {
    const double step = std::ldexp(1.0, node.exponents[i] - 127);
    box.lo[i] = node.origin[i] + lows[i][child] * step;
    box.hi[i] = node.origin[i] + highs[i][child] * step;
  }
  return box;
}

// Walks a tree, checks its shape, and counts how often each item stands in a leaf.
struct Walk {
  const std::vector<BvhNode4>& nodes;
  uint32_t maxLeafItems;
  std::function<Box(uint32_t)> itemBox;
  std::vector<uint32_t> itemUses;
  std::vector<uint32_t> nodeUses;
  uint32_t depth = 0;

  // Box of everything below the node.
  Box Node(uint32_t index, uint32_t level) {
    Box all;
    if (index >= nodes.size()) {
      ADD_FAILURE() << "node " << index << " of " << nodes.size();
      return all;
    }
    ++nodeUses[index];
    depth = std::max(depth, level);
    const BvhNode4& node = nodes[index];
    EXPECT_LE(node.childCount, 4);
    for (uint32_t c = node.childCount; c < 4; ++c) EXPECT_EQ(node.children[c], layout::kBvhEmpty);
    for (uint32_t c = 0; c < node.childCount; ++c) {
      const uint32_t reference = node.children[c];
      Box inside;
      if (reference & layout::kBvhLeafBit) {
        const uint32_t first = reference & layout::kBvhLeafFirstMask;
        const uint32_t count = (reference >> layout::kBvhLeafCountShift & 15u) + 1;
        EXPECT_LE(count, maxLeafItems);
        for (uint32_t i = first; i < first + count; ++i) {
          if (i >= itemUses.size()) {
            ADD_FAILURE() << "item " << i << " of " << itemUses.size();
            return all;
          }
          ++itemUses[i];
          inside.Extend(itemBox(i));
        }
      } else {
        inside = Node(reference, level + 1);
      }
      if (!ChildBox(node, c).Holds(inside)) ADD_FAILURE() << "box of child " << c << " of node " << index;
      all.Extend(inside);
    }
    return all;
  }
};

inline Box TriangleBox(const TriangleRecord& t) {
  Box box;
  for (const Float3& v : {t.v0, t.v1, t.v2}) box.Extend({{v.x, v.y, v.z}, {v.x, v.y, v.z}});
  return box;
}

// Long triangles through a crowd of small ones.
inline Soup BeamsThroughClutter(uint32_t small, uint32_t beams, float scale = 1) {
  Soup soup = RandomSoup(small, 0.01f, 21, scale);
  const Soup ends = RandomSoup(beams, 1, 22, scale);
  soup.positions.insert(soup.positions.end(), ends.positions.begin(), ends.positions.end());
  for (UInt3 t : ends.triangles) soup.triangles.push_back({t.x + 3 * small, t.y + 3 * small, t.z + 3 * small});
  return soup;
}

template <typename T>
bool SameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
inline bool SameBytes(const MeshBvh& a, const MeshBvh& b) {
  return SameBytes(a.nodes, b.nodes) && SameBytes(a.triangles, b.triangles);
}

}  // namespace wavefront::bvh
