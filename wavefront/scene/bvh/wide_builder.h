// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The builder behind both kinds of tree: boxes in, 4-wide quantised nodes and an order of the boxes out.
#pragma once

#include <cstdint>
#include <vector>

#include "wavefront/scene/bvh/bvh.h"

namespace wavefront::bvh {

// A box to be put in a tree. Lane 3 of lo carries the item's index, disguised as an ordinary float so that
// vector arithmetic on whole rows never meets a denormal; lane 3 of hi is 0.
struct alignas(16) BuildItem {
  float lo[4];
  float hi[4];
};
constexpr uint32_t kMaxItemIndex = (1u << 29) - 1;

BuildItem MakeItem(const Float3& lo, const Float3& hi, uint32_t index);
uint32_t ItemIndex(const BuildItem& item);

class TriangleCutter;

struct WideBuildSettings {
  uint32_t maxLeafItems = 1;
  uint32_t maxDepth = 1;      // nodes from the root to a leaf's parent; 4^maxDepth * maxLeafItems >= item count
  bool leafIsItemIndex = false;  // leaves name the item's index (needs maxLeafItems 1) instead of its place
  unsigned threads = 1;
  // Where it is given, planes may cut items, which then stand on both sides: at most `maxPieces` more items.
  const TriangleCutter* cutter = nullptr;
  uint32_t maxPieces = 0;
};

// Builds a tree over `items`, which it reorders: a leaf holds items [first, first + count) of the new order. Items that were
// cut stand there several times, at most once a leaf, with the boxes of their pieces.
// Boxes must be finite, within +-kMaxCoordinate, lo <= hi. Zero items give one node without children.
std::vector<BvhNode4> BuildWide(std::vector<BuildItem>& items, const WideBuildSettings& settings);

}  // namespace wavefront::bvh
