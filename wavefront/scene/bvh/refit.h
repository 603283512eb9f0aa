// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Refits: the boxes of a tree that stands, made anew for items that moved. Which item stands in which leaf stays, so a
// refit costs a fraction of a build, and rays pay for what the items' order has lost (tree_cost.h).
//
// Promises: the boxes are as exact as a build's, and a function of tree and items alone, never of the thread count. All
// functions may be called from any thread, concurrently.
#pragma once

#include "wavefront/scene/bvh/bvh.h"

namespace wavefront::bvh {

// Moves `mesh`, as it was built or refitted for the same `triangles`, to these positions. Of a triangle that spatial splits
// have put in several leaves, each holds all of it from now on.
// False: other triangles than before can be hit (see MeshBvh), so that the mesh must be built; it is unusable then.
bool RefitMeshBvh(std::span<const Float3> positions, std::span<const UInt3> triangles, std::span<const uint16_t> slots,
                  MeshBvh& mesh, unsigned threads = 0);

// Moves a tree over instances to these bounds. False: it holds others than those that are usable now; it is unusable then.
bool RefitInstanceBvh(std::span<const Bounds3> worldBounds, InstanceBvh& tree, unsigned threads = 0);

}  // namespace wavefront::bvh
