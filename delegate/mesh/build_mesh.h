// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// From an authored mesh to the triangles that the core renders: checked, triangulated or subdivided, with
// normals, primvars and material slots. What Hydra leaves to a render delegate, once for both hosts.
#pragma once

#include <optional>

#include "delegate/mesh/mesh_input.h"
#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"

namespace delegate {

// Pure: no global state, so any number of threads may call it at once. Equal input gives equal output to the bit.
// Nothing is returned when nothing can be drawn (the sink was told why, except for a mesh made of holes only).
//
// Promises on the result: every index is in range; positions and primvar values are finite; faceIds has one entry
//   per triangle; materialSlots is empty if there is no subset; winding is right-handed; no triangle repeats a point.
// Broken parts are left out one by one, each kind with one diagnostic that names the path: faces with too few
//   points or with points that do not exist or are not finite, primvars of the wrong size, hole, crease, corner and
//   subset entries out of range.
// Normals: scheme "none": the authored ones, normalised, in any interpolation; without them none (flat shading).
//   catmullClark and loop: computed ones, authored ones are ignored as UsdGeomMesh demands: at refineLevel 0 smooth
//   normals of the cage (as Hydra draws it), else normals of the limit surface, split along edges that are still
//   sharp. bilinear: none, its surface is faceted.
// refineLevel > 0: points lie on the limit surface; vertex, varying, uniform and face-varying primvars are refined
//   by OpenSubdiv's rules. faceIds are those of the authored faces.
std::optional<wavefront::MeshData> BuildMesh(const MeshInput& input, const wavefront::DiagnosticSink& sink);

}  // namespace delegate
