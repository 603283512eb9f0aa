// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace delegate {
namespace {

// Beyond this a squared distance does not fit a float, and intersection breaks down.
constexpr float kMaxCoordinate = 1e18f;
// Three corners of each triangle are numbered with 32 bits, and n corners make fewer than n triangles.
constexpr uint64_t kMaxCorners = std::numeric_limits<uint32_t>::max() / 3;
constexpr int kMaxRefineLevel = 8;

bool IsUsable(const wavefront::Float3& p) {
  // Written so that NaN fails.
  return std::fabs(p.x) <= kMaxCoordinate && std::fabs(p.y) <= kMaxCoordinate && std::fabs(p.z) <= kMaxCoordinate;
}

std::string Faces(const Tally& tally) {
  return std::to_string(tally.count) + (tally.count == 1 ? " face" : " faces") + " (first: face " + std::to_string(tally.first) + ")";
}

Scheme ReadScheme(const std::string& token, const MeshReport& report) {
  if (token.empty() || token == "catmullClark") return Scheme::CatmullClark;
  if (token == "loop") return Scheme::Loop;
  if (token == "bilinear") return Scheme::Bilinear;
  if (token != "none")
    report.Warn("mesh-bad-token", "The subdivision scheme \"" + token + "\" is unknown; the mesh is drawn as polygons.");
  return Scheme::None;
}

bool ReadLeftHanded(const std::string& token, const MeshReport& report) {
  if (token == "leftHanded") return true;
  if (!token.empty() && token != "rightHanded")
    report.Warn("mesh-bad-token", "The orientation \"" + token + "\" is unknown; right-handed is taken.");
  return false;
}

int ReadLevel(int level, const MeshReport& report) {
  const int clamped = std::clamp(level, 0, kMaxRefineLevel);
  if (clamped != level)
    report.Warn("mesh-bad-refine-level",
                "The refinement level " + std::to_string(level) + " is not in 0..8; " + std::to_string(clamped) + " is taken.");
  return clamped;
}

void FindBadPoints(const MeshInput& input, CheckedTopology& checked) {
  for (size_t i = 0; i < input.points.size(); ++i) {
    if (IsUsable(input.points[i])) continue;
    if (checked.badPoint.empty()) checked.badPoint.resize(input.points.size(), 0);
    checked.badPoint[i] = 1;
  }
}

struct FaceTallies {
  Tally negative, tooFew, pastEnd, badIndex, badPoint, degenerate;
  bool Any() const { return negative.count + tooFew.count + pastEnd.count + badIndex.count + badPoint.count + degenerate.count > 0; }
};

// Whether the face has at least three distinct points (what it takes to span an area).
bool HasThreeDistinct(const int32_t* indices, uint32_t count) {
  const int32_t first = indices[0];
  int32_t second = first;
  for (uint32_t k = 1; k < count; ++k) {
    if (indices[k] == first || indices[k] == second) continue;
    if (second != first) return true;
    second = indices[k];
  }
  return false;
}

void CollectFaces(const MeshInput& input, CheckedTopology& checked, FaceTallies& bad) {
  const auto& counts = input.topology.faceVertexCounts;
  const auto& indices = input.topology.faceVertexIndices;
  const int64_t pointCount = static_cast<int64_t>(input.points.size());
  uint64_t offset = 0;
  checked.faces.reserve(counts.size());
  for (size_t f = 0; f < counts.size(); ++f) {
    const int64_t face = static_cast<int64_t>(f);
    if (counts[f] < 0) {
      bad.negative.Add(face);
      continue;
    }
    const uint32_t count = static_cast<uint32_t>(counts[f]);
    const uint64_t begin = offset;
    offset += count;
    if (offset > indices.size()) {
      bad.pastEnd.Add(face);
      continue;
    }
    if (count < 3) {
      bad.tooFew.Add(face);
      continue;
    }
    const int32_t* corner = indices.data() + begin;
    bool inRange = true, finite = true;
    for (uint32_t k = 0; k < count && inRange; ++k) {
      inRange = corner[k] >= 0 && corner[k] < pointCount;
      if (inRange && !checked.badPoint.empty() && checked.badPoint[corner[k]]) finite = false;
    }
    if (!inRange) bad.badIndex.Add(face);
    else if (!finite) bad.badPoint.Add(face);
    else if (!HasThreeDistinct(corner, count)) bad.degenerate.Add(face);
    else {
      checked.faces.push_back({static_cast<uint32_t>(f), static_cast<uint32_t>(begin), count});
      checked.maxFaceSize = std::max(checked.maxFaceSize, count);
    }
  }
  checked.cornerCount = static_cast<uint32_t>(std::min<uint64_t>(offset, indices.size()));
}

void ReportFaces(const MeshInput& input, const FaceTallies& bad, const CheckedTopology& checked, const MeshReport& report) {
  const char* code = "mesh-bad-topology";
  const auto tell = [&](const Tally& tally, const char* what) {
    if (tally.count) report.Warn(code, Faces(tally) + " " + what + "; left out.");
  };
  tell(bad.negative, "with a negative faceVertexCounts");
  tell(bad.tooFew, "with fewer than 3 points");
  tell(bad.pastEnd, "reaching past the end of faceVertexIndices");
  tell(bad.badIndex, "naming points that do not exist");
  tell(bad.degenerate, "with fewer than 3 different points");
  if (bad.badPoint.count)
    report.Warn("mesh-bad-points", Faces(bad.badPoint) + " with points that are not finite or beyond 1e18; left out.");
  const size_t indexCount = input.topology.faceVertexIndices.size();
  if (checked.cornerCount < indexCount)
    report.Warn(code, "faceVertexCounts sum to " + std::to_string(checked.cornerCount) + " but there are " +
                          std::to_string(indexCount) + " faceVertexIndices; the rest is ignored.");
}

void MarkHoles(const MeshInput& input, CheckedTopology& checked, const MeshReport& report) {
  const auto& holes = input.topology.holeIndices;
  if (holes.empty()) return;
  const size_t faceCount = input.topology.faceVertexCounts.size();
  std::vector<uint8_t> authored(faceCount, 0);
  Tally bad;
  for (size_t i = 0; i < holes.size(); ++i) {
    if (holes[i] < 0 || static_cast<size_t>(holes[i]) >= faceCount) bad.Add(static_cast<int64_t>(i));
    else authored[holes[i]] = 1;
  }
  if (bad.count)
    report.Warn("mesh-bad-topology", std::to_string(bad.count) + " holeIndices (first: entry " + std::to_string(bad.first) +
                                         ") name faces that do not exist; ignored.");
  checked.isHole.resize(checked.faces.size());
  for (size_t i = 0; i < checked.faces.size(); ++i) checked.isHole[i] = authored[checked.faces[i].id];
}

void AssignSlots(const MeshInput& input, CheckedTopology& checked, const MeshReport& report) {
  const auto& subsets = input.topology.subsets;
  if (subsets.empty()) return;
  const size_t faceCount = input.topology.faceVertexCounts.size();
  const size_t maxSubsets = std::numeric_limits<uint16_t>::max() - 1;
  if (subsets.size() > maxSubsets)
    report.Warn("mesh-bad-subset", "There are " + std::to_string(subsets.size()) + " subsets; those after " +
                                       std::to_string(maxSubsets) + " are ignored.");
  checked.slots.assign(faceCount, 0);
  for (size_t s = 0; s < std::min(subsets.size(), maxSubsets); ++s) {
    const uint16_t slot = static_cast<uint16_t>(s + 1);
    Tally outside, taken;
    for (const int32_t face : subsets[s].indices) {
      if (face < 0 || static_cast<size_t>(face) >= faceCount) outside.Add(face);
      else if (checked.slots[face] != 0 && checked.slots[face] != slot) taken.Add(face);
      else checked.slots[face] = slot;
    }
    if (outside.count)
      report.Warn("mesh-bad-subset", "Subset " + subsets[s].path + " names " + Faces(outside) +
                                         " that the mesh does not have; ignored.");
    if (taken.count)
      report.Warn("mesh-bad-subset", "Subset " + subsets[s].path + " names " + Faces(taken) +
                                         " of an earlier subset; the earlier one keeps them.");
  }
}

}  // namespace

void MeshReport::Tell(wavefront::Severity severity, const char* code, std::string message) const {
  if (sink_) sink_({severity, code, path_, std::move(message)});
}

std::optional<CheckedTopology> CheckTopology(const MeshInput& input, const MeshReport& report) {
  const MeshTopology& topology = input.topology;
  if (input.points.empty() || topology.faceVertexCounts.empty() || topology.faceVertexIndices.empty()) {
    report.Warn("mesh-empty", std::string("The mesh has no ") + (input.points.empty() ? "points" : "faces") + "; nothing is drawn.");
    return std::nullopt;
  }
  if (topology.faceVertexIndices.size() > kMaxCorners || input.points.size() > kMaxCorners) {
    report.Warn("mesh-too-large", "The mesh has more than " + std::to_string(kMaxCorners) + " face corners or points; nothing is drawn.");
    return std::nullopt;
  }
  CheckedTopology checked;
  checked.scheme = ReadScheme(topology.scheme, report);
  checked.leftHanded = ReadLeftHanded(topology.orientation, report);
  checked.level = ReadLevel(input.displacementLevel.value_or(input.refineLevel), report);
  FindBadPoints(input, checked);
  FaceTallies bad;
  CollectFaces(input, checked, bad);
  if (bad.Any() || checked.cornerCount < topology.faceVertexIndices.size()) ReportFaces(input, bad, checked, report);
  if (checked.faces.empty()) {
    report.Warn("mesh-empty", "None of the mesh's faces can be drawn.");
    return std::nullopt;
  }
  MarkHoles(input, checked, report);
  AssignSlots(input, checked, report);
  return checked;
}

}  // namespace delegate
