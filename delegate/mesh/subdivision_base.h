// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The cage as OpenSubdiv wants it: checked tags, face-varying channels, and the refiner. Internal to delegate/mesh.
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "delegate/mesh/mesh_check.h"
#include "delegate/mesh/primvars.h"

namespace delegate {

// Faces with unused points left out, points repeated in a row merged and, for the loop scheme, cut into triangles.
struct SubdivisionCage {
  std::vector<int> counts;
  std::vector<int> vertices;           // per corner, into points
  std::vector<uint32_t> corners;       // per corner, the authored corner
  std::vector<uint32_t> faces;         // per face, into CheckedTopology::faces
  std::vector<uint32_t> points;        // per vertex, the authored point
  std::vector<int> vertexOfPoint;      // per authored point; -1: unused
};

// One face-varying topology; primvars with the same one share it.
struct FaceVaryingChannel {
  std::vector<int> indices;            // per corner of the cage
  int valueCount = 0;
};

struct FaceVaryingChannels {
  std::vector<FaceVaryingChannel> channels;
  std::vector<int> channelOf;                    // per primvar; -1: not face-varying
  std::vector<std::vector<float>> baseValues;    // per primvar; empty: not face-varying
};

SubdivisionCage MakeCage(const MeshInput& input, const CheckedTopology& topology, const MeshReport& report);

// Primvars with indices keep their topology. Others are welded first: corners at a point with equal values are one.
FaceVaryingChannels MakeChannels(const SubdivisionCage& cage, const std::vector<CheckedPrimvar>& primvars);

// Null if OpenSubdiv cannot represent the mesh; the report was told.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> MakeRefiner(const MeshInput& input, const CheckedTopology& topology,
                                                              const SubdivisionCage& cage,
                                                              const FaceVaryingChannels& channels, const MeshReport& report);

}  // namespace delegate
