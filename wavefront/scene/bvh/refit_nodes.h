// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The way from the leaves of a tree to its root that both kinds of refit take.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/node_boxes.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront::bvh {

// leafBox(first, count): the box of a leaf's items, called once a leaf, from several threads.
template <typename LeafBox>
class NodeRefit {
 public:
  NodeRefit(std::span<BvhNode4> nodes, const LeafBox& leafBox) : nodes_(nodes), leafBox_(leafBox) {}

  // Boxes of all nodes, children first; returns the box of the whole tree.
  Box4 Run(unsigned threads) {
    // The top of the tree, until what hangs below it is enough for all threads.
    std::vector<uint32_t> top, below{0};
    for (size_t level = 0; threads > 1 && below.size() < kSubtrees && level < kTopLevels; ++level) {
      std::vector<uint32_t> next;
      for (const uint32_t index : below) {
        top.push_back(index);
        const BvhNode4& node = nodes_[index];
        for (uint32_t c = 0; c < node.childCount; ++c) {
          if ((node.children[c] & layout::kBvhLeafBit) == 0) next.push_back(node.children[c]);
        }
      }
      below = std::move(next);
    }
    std::vector<Box4> boxes(below.size());
    ParallelFor(below.size(), threads, [&](size_t i) {
      boxes[i] = Node(below[i], [this](uint32_t child) { return Subtree(child); });
    });
    std::unordered_map<uint32_t, Box4> known;
    for (size_t i = 0; i < below.size(); ++i) known[below[i]] = boxes[i];
    // A level's nodes stand behind those of the level above.
    for (size_t i = top.size(); i-- > 0;) known[top[i]] = Node(top[i], [&](uint32_t child) { return known[child]; });
    return known[0];
  }

 private:
  static constexpr size_t kSubtrees = 128, kTopLevels = 6;

  Box4 Subtree(uint32_t index) {
    return Node(index, [this](uint32_t child) { return Subtree(child); });
  }

  // One node, whose inner children are asked for their boxes.
  template <typename Inner>
  Box4 Node(uint32_t index, const Inner& inner) {
    BvhNode4& node = nodes_[index];
    std::array<Box4, 4> boxes;
    Box4 whole;
    for (uint32_t c = 0; c < node.childCount; ++c) {
      const uint32_t reference = node.children[c];
      boxes[c] = (reference & layout::kBvhLeafBit) == 0
                     ? inner(reference)
                     : leafBox_(reference & layout::kBvhLeafFirstMask, (reference >> layout::kBvhLeafCountShift & 7u) + 1);
      whole.Extend(boxes[c]);
    }
    QuantiseBoxes(node, {boxes.data(), node.childCount});
    return whole;
  }

  std::span<BvhNode4> nodes_;
  const LeafBox& leafBox_;
};

}  // namespace wavefront::bvh
