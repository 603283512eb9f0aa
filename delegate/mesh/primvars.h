// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Authored primvars, checked against the topology, indices resolved. Internal to delegate/mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "delegate/mesh/mesh_check.h"

namespace delegate {

enum class AuthoredInterpolation { Constant, Uniform, Vertex, Varying, FaceVarying };

// Elements: Constant 1, Uniform one per authored face, Vertex and Varying one per authored point. FaceVarying: corner c
// of faceVertexIndices reads element indices[c], or element c if there are no indices. All values are finite.
struct CheckedPrimvar {
  std::string name;
  AuthoredInterpolation interpolation = AuthoredInterpolation::Constant;
  uint32_t components = 1;
  std::vector<float> values;
  std::vector<uint32_t> indices;  // FaceVarying only
  uint32_t Element(uint32_t corner) const { return indices.empty() ? corner : indices[corner]; }
};

// Broken primvars are reported and left out. Normals of subdivision meshes are left out, as UsdGeomMesh demands.
std::vector<CheckedPrimvar> CheckPrimvars(const MeshInput& input, const CheckedTopology& topology, const MeshReport& report);

}  // namespace delegate
