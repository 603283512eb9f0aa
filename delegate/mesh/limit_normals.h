// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Normals of a subdivision surface at the vertices of its last refined level. Internal to delegate/mesh.
#pragma once

#include <opensubdiv/far/topologyLevel.h>

#include <cstdint>
#include <vector>

namespace delegate {

struct LimitNormals {
  std::vector<float> values;      // 3 per vertex of the level, then those of sectors between sharp edges
  std::vector<uint32_t> corners;  // element per face corner (face * cornersPerFace + corner); empty: that of its vertex
};

// `level` has full topology; `positions`, `tangent1` and `tangent2` are the limit's, 3 floats per vertex. Where inner
// edges are still sharp at this level the surface has one normal per sector between them, the angle-weighted mean of
// its faces; everywhere else the normal is the cross product of the limit tangents.
LimitNormals ComputeLimitNormals(const OpenSubdiv::Far::TopologyLevel& level, uint32_t cornersPerFace,
                                 const std::vector<float>& positions, const std::vector<float>& tangent1,
                                 const std::vector<float>& tangent2, bool leftHanded);

}  // namespace delegate
