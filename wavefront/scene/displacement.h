// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What displacement does to a mesh besides evaluating a material's kernel (scheduler/displacer.h): in which direction
// points move, how far where corners disagree, and the normals afterwards. Pure functions in double precision over the
// triangles in their order: equal input gives equal output to the bit.
//
// Rules. A point moves by the mean of what its corners ask for, one corner per triangle that meets there; corners of
// triangles whose material does not displace ask for nothing. So points shared by GeomSubsets, by both sides of a seam in
// texture coordinates and by creased faces stay one point: no gap opens. The direction "along the normal" is the
// same for all corners of a point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "wavefront/scene.h"

namespace wavefront {

// One unit vector per triangle corner as the mesh is shaded before it moves: its normals, or the mean normal of the
// authored face where it has none.
std::vector<Float3> CornerNormals(const MeshData& mesh);
// One unit vector per point: the mean of its corners' normals weighted by their angles; `mesh`'s own where it has one
// normal per point.
std::vector<Float3> PointNormals(const MeshData& mesh, std::span<const Float3> cornerNormals);

// Moves the points. `offsets`: by corner (3 * triangle + corner), for the triangles that `moves` names. A point keeps its
// place where an offset is not finite or leads beyond bvh::kMaxCoordinate. Returns how many kept it for that reason.
uint64_t MovePoints(MeshData& mesh, std::span<const Float3> offsets, std::span<const uint8_t> moves);

// Replaces "normals" by those of the moved triangles, smooth across corners whose normals before (`cornerNormals`) agree
// within a degree: what was smooth or flat stays so, and an edge that was sharp stays sharp.
void RenewNormals(MeshData& mesh, std::span<const Float3> cornerNormals);

}  // namespace wavefront
