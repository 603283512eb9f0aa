// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What a tree costs rays, and whether a refit has made it dearer than it is worth.
#pragma once

#include "wavefront/scene/bvh/bvh.h"

namespace wavefront::bvh {

// A visit of a node that parts a leaf, in triangle tests. Measured in time it is about 1.1; more asks more of nodes that
// cost memory (resources/TRAVERSAL.md).
constexpr double kNodeCost = 1.6;

// The surface area heuristic over the boxes as they are quantised: a visit of a node counts as kNodeCost triangle tests.
// A function of the tree alone, never of the thread count.
struct TreeCost {
  double visits = 0;  // what nodes and items count, weighted by the half areas of their boxes
  double items = 0;   // half area of all items' own boxes
  double root = 0;    // half area of the whole tree's box
};
TreeCost CostOf(const MeshBvh& mesh, unsigned threads = 0);
TreeCost CostOf(const InstanceBvh& tree, std::span<const Bounds3> worldBounds, unsigned threads = 0);

// How much dearer a tree of the same items is after a refit, for a ray that meets the root or for the area of the items,
// whichever has grown more. A vertex that is dragged far away makes the root large, and all of the tree look cheap beside it; items
// that grow together with the nodes around them make those look cheap.
double Growth(const TreeCost& before, const TreeCost& after);

// Beyond this growth a tree is built anew (resources/TRAVERSAL.md has what was measured).
constexpr double kMostGrowth = 1.5;

}  // namespace wavefront::bvh
