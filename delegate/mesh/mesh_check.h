// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// First step of BuildMesh: what of an authored mesh can be used. Internal to delegate/mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "delegate/mesh/mesh_input.h"
#include "wavefront/base/diagnostics.h"

namespace delegate {

// Tells the sink about one prim.
class MeshReport {
 public:
  MeshReport(const std::string& path, const wavefront::DiagnosticSink& sink) : path_(path), sink_(sink) {}
  void Warn(const char* code, std::string message) const { Tell(wavefront::Severity::Warning, code, std::move(message)); }
  void Info(const char* code, std::string message) const { Tell(wavefront::Severity::Info, code, std::move(message)); }

 private:
  void Tell(wavefront::Severity severity, const char* code, std::string message) const;
  const std::string& path_;
  const wavefront::DiagnosticSink& sink_;
};

// How often something was wrong and where first, so that a million bad faces make one diagnostic.
struct Tally {
  uint64_t count = 0;
  int64_t first = -1;
  void Add(int64_t where) {
    if (count++ == 0) first = where;
  }
};

enum class Scheme { None, CatmullClark, Loop, Bilinear };

// A face that can be drawn. Its corners are begin .. begin + count - 1 of faceVertexIndices.
struct CheckedFace {
  uint32_t id = 0;  // authored face
  uint32_t begin = 0;
  uint32_t count = 0;
};

struct CheckedTopology {
  Scheme scheme = Scheme::CatmullClark;
  bool leftHanded = false;
  int level = 0;                        // 0..8
  std::vector<CheckedFace> faces;       // holes included
  std::vector<uint8_t> isHole;          // per entry of faces; empty: no holes
  std::vector<uint16_t> slots;          // per authored face; empty: no subsets
  std::vector<uint8_t> badPoint;        // per point; empty: all are finite. No face uses a bad one
  uint32_t cornerCount = 0;             // corners that the authored counts span within faceVertexIndices
  uint32_t maxFaceSize = 0;
};

// Nothing if no face is left; the report says why.
std::optional<CheckedTopology> CheckTopology(const MeshInput& input, const MeshReport& report);

}  // namespace delegate
