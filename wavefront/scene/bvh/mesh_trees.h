// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which way the trees of a commit's meshes are made, many side by side: built for good, built fast, refitted or kept.
//
// The rule: a tree is *final* if it was built with spatial splits for the mesh as it is. A render that is not interactive sees final
// trees alone. While the render is interactive, an edited mesh is refitted where its triangles join the same points, and
// built fast (without spatial splits) where they do not, or where the refitted tree has grown too dear (kMostGrowth). All of it
// depends on the series of edits and commits, never on time or threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/bvh/tree_cost.h"

namespace wavefront::bvh {

// Meshes, since the store was made.
struct TreeCounts {
  uint64_t built = 0, builtFast = 0, refitted = 0;
};

struct TreeJob {
  std::span<const Float3> positions;
  std::span<const UInt3> triangles;
  std::span<const uint16_t> slots;
  enum class Way : uint8_t { Build, BuildFast, Refit } way = Way::Build;  // in: what is asked for; out: what was done
  MeshBvh mesh;    // in, of a refit: as it is on the device; out: the new one
  TreeCost built;  // in, of a refit: the cost when it was built, if that is known; out: of the last build, if it is known
};

// Small meshes side by side, large ones one after the other, each on all threads.
void MakeTrees(std::span<TreeJob> jobs, unsigned threads, TreeCounts& counts);

}  // namespace wavefront::bvh
