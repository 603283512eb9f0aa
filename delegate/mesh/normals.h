// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Normals of the polygon cage. Internal to delegate/mesh.
#pragma once

#include <span>
#include <vector>

#include "delegate/mesh/mesh_check.h"
#include "delegate/mesh/mesh_math.h"
#include "wavefront/types.h"

namespace delegate {

// Outward unit normal of a face; zero if it has no area. `scratch` is overwritten.
Vec3 FaceNormal(const MeshInput& input, const CheckedTopology& topology, const CheckedFace& face, std::vector<Vec3>& scratch);

// One outward unit normal per point: the normals of its faces weighted by their angle there (Thuermer and Wuethrich
// 1998), which does not depend on how faces were cut. Points without a face, or whose faces cancel out, get +Z or the
// normal of their first face.
std::vector<float> SmoothNormals(const MeshInput& input, const CheckedTopology& topology);

}  // namespace delegate
