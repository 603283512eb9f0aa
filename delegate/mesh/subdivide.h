// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Subdivision surfaces by OpenSubdiv's uniform refinement. Internal to delegate/mesh.
#pragma once

#include <optional>
#include <vector>

#include "delegate/mesh/mesh_check.h"
#include "delegate/mesh/primvars.h"
#include "wavefront/scene.h"

namespace delegate {

// Refines to topology.level (at least 1) or to the highest level below input.maxTriangles. Nothing is returned if not
// even level 1 fits or OpenSubdiv refuses the mesh: the report was told, and the caller draws the cage.
std::optional<wavefront::MeshData> Subdivide(const MeshInput& input, const CheckedTopology& topology,
                                             const std::vector<CheckedPrimvar>& primvars, const MeshReport& report);

}  // namespace delegate
