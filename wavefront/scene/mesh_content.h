// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What a mesh on the device was made of, as sizes and hashes: an edit uploads what differs, and says what its tree needs.
#pragma once

#include <string>
#include <vector>

#include "wavefront/scene.h"

namespace wavefront {

// An array's size and hash; two that are equal are taken for the same.
struct ArrayContent {
  uint64_t bytes = 0, hash = 0;
  bool operator==(const ArrayContent&) const = default;
};

struct PrimvarContent {
  std::string name;
  Interpolation interpolation = Interpolation::Constant;
  uint32_t components = 1;
  ArrayContent values, indices;
};

struct MeshContent {
  ArrayContent positions, triangles, slots, faceIds;
  std::vector<PrimvarContent> primvars;
};

MeshContent ContentOf(const MeshData& mesh);

// All arrays but positions and slots have the same names and sizes: one's place in the streams serves the other.
bool SameSizes(const MeshContent& a, const MeshContent& b);

}  // namespace wavefront
