// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/bvh/mesh_trees.h"

#include <algorithm>

#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/refit.h"

namespace wavefront::bvh {
namespace {

// From this size on a mesh is worth all threads at once.
constexpr size_t kLargeMeshTriangles = 1u << 16;

void MakeTree(TreeJob& job, unsigned threads) {
  if (job.way == TreeJob::Way::Refit) {
    if (!(job.built.visits > 0)) job.built = CostOf(job.mesh, threads);
    if (RefitMeshBvh(job.positions, job.triangles, job.slots, job.mesh, threads) &&
        Growth(job.built, CostOf(job.mesh, threads)) <= kMostGrowth) {
      return;
    }
    job.way = TreeJob::Way::BuildFast;
  }
  job.built = {};
  job.mesh = BuildMeshBvh(job.positions, job.triangles, job.slots, {threads, job.way == TreeJob::Way::Build});
}

}  // namespace

void MakeTrees(std::span<TreeJob> jobs, unsigned threads, TreeCounts& counts) {
  std::vector<TreeJob*> small, large;
  for (TreeJob& job : jobs) (job.triangles.size() < kLargeMeshTriangles ? small : large).push_back(&job);
  for (TreeJob* job : large) MakeTree(*job, threads);
  // The largest first, so that no thread ends late with one of them.
  std::stable_sort(small.begin(), small.end(), [](const TreeJob* a, const TreeJob* b) { return a->triangles.size() > b->triangles.size(); });
  ParallelFor(small.size(), threads, [&](size_t i) { MakeTree(*small[i], 1); });
  for (const TreeJob& job : jobs) {
    counts.built += job.way == TreeJob::Way::Build;
    counts.builtFast += job.way == TreeJob::Way::BuildFast;
    counts.refitted += job.way == TreeJob::Way::Refit;
  }
}

}  // namespace wavefront::bvh
