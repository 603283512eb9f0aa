// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/displacement.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace delegate {
namespace {

std::optional<int> AuthoredLevel(const std::vector<PrimvarInput>& primvars) {
  for (const PrimvarInput& primvar : primvars) {
    if (primvar.name != kDisplacementLevelPrimvar || primvar.components != 1 || primvar.values.empty()) continue;
    const float level = primvar.values[0];
    if (std::isfinite(level)) return static_cast<int>(std::clamp(level, 0.0f, float(kMaxDisplacementLevel)));
  }
  return std::nullopt;
}

// `count(level)`: triangles at a level.
template <typename Count>
DisplacementLevel Choose(int lowest, const std::vector<PrimvarInput>& primvars, const DisplacementTarget& target,
                         const Count& count) {
  lowest = std::clamp(lowest, 0, kMaxDisplacementLevel);
  int level = lowest;
  if (const auto authored = AuthoredLevel(primvars)) {
    level = *authored;
  } else {
    while (level < kMaxDisplacementLevel && count(level) < target.triangles) ++level;
  }
  while (level > 0 && count(level) > target.most) --level;
  return {level, count(level)};
}

}  // namespace

std::shared_ptr<const std::vector<uint32_t>> DisplacementKernels::Compile(const materialgen::KernelSource& source,
                                                                          materialgen::SpirvCache& cache,
                                                                          const wavefront::DiagnosticSink& sink) {
  std::lock_guard lock(mutex_);
  const auto [known, isNew] = spirv_.try_emplace(source.key);
  if (!isNew) return known->second;
  std::string error;
  std::vector<uint32_t> spirv;
  if (auto kept = cache.Load(source.displacement)) {
    spirv = std::move(*kept);
  } else {
    spirv = materialgen::CompileGlsl(source.displacement, source.key + ".displacement", &error);
    if (!spirv.empty()) cache.Store(source.displacement, spirv);
  }
  if (spirv.empty()) {
    sink({wavefront::Severity::Error, "material-kernel-failed", source.key + ".displacement",
          "A generated displacement kernel does not compile; its materials do not displace. " + error});
  } else {
    ++compiled_;
    known->second = std::make_shared<const std::vector<uint32_t>>(std::move(spirv));
  }
  return known->second;
}

DisplacementLevel ChooseDisplacementLevel(const MeshInput& mesh, const DisplacementTarget& target) {
  // Only an estimate: BuildMesh leaves broken faces out.
  uint64_t faces = 0, corners = 0;
  for (const int32_t count : mesh.topology.faceVertexCounts) {
    if (count < 3) continue;
    ++faces;
    corners += static_cast<uint64_t>(count);
  }
  const uint64_t polygons = corners - 2 * faces;
  const bool isSurface = mesh.topology.scheme != "none", isLoop = mesh.topology.scheme == "loop";
  return Choose(isSurface ? mesh.refineLevel : 0, mesh.primvars, target, [&](int level) {
    const uint64_t perStep = uint64_t{1} << (2 * level);
    return !isSurface || isLoop || level == 0 ? polygons * perStep : corners * perStep / 2;
  });
}

DisplacementLevel ChooseDisplacementLevel(uint64_t triangles, const std::vector<PrimvarInput>& primvars,
                                          const DisplacementTarget& target) {
  return Choose(0, primvars, target, [&](int level) { return triangles << (2 * level); });
}

}  // namespace delegate
