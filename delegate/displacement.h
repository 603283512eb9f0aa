// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Displacement between materials and meshes: kernels as SPIR-V, and how finely meshes are cut. Internal to delegate.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "delegate/mesh/implicit.h"
#include "delegate/mesh/mesh_input.h"
#include "materialgen/materialgen.h"
#include "materialgen/spirv_cache.h"
#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"

namespace delegate {

// SPIR-V of displacement kernels by key. Thread-safe.
class DisplacementKernels {
 public:
  // Null where it does not compile, which is told.
  std::shared_ptr<const std::vector<uint32_t>> Compile(const materialgen::KernelSource& source,
                                                       materialgen::SpirvCache& cache, const wavefront::DiagnosticSink& sink);
  uint64_t compiled() const { return compiled_; }  // not while compiling

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const std::vector<uint32_t>>> spirv_;
  uint64_t compiled_ = 0;
};

// A mesh of which points move by less than its faces are wide shows nothing of it. So displaced meshes are refined:
// subdivision surfaces by their own rule, polygons and implicit shapes by splitting every triangle in four at the
// middles of its edges (flat, as they are). How far:
//   1. the constant primvar "wavefront:displacementLevel" of the prim, where it has one;
//   2. else the lowest level, at least the prim's own refineLevel, that has `triangles` of them.
// Never beyond level 8, nor beyond `most` triangles.
struct DisplacementTarget {
  uint64_t triangles = 0;   // setting displacementTriangles; 0: no more than the refine level
  uint64_t most = 0;        // MeshInput::maxTriangles
};
constexpr int kMaxDisplacementLevel = 8;
inline constexpr const char* kDisplacementLevelPrimvar = "wavefront:displacementLevel";

struct DisplacementLevel {
  int level = 0;
  uint64_t triangles = 0;  // about; what the level makes
};
DisplacementLevel ChooseDisplacementLevel(const MeshInput& mesh, const DisplacementTarget& target);
// `triangles`: of the shape as it is built, before it is split.
DisplacementLevel ChooseDisplacementLevel(uint64_t triangles, const std::vector<PrimvarInput>& primvars,
                                          const DisplacementTarget& target);

}  // namespace delegate
