// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The same surface with finer triangles, or of one piece: for displacement.
#pragma once

#include "wavefront/scene.h"

namespace delegate {

// Every triangle becomes four, `levels` times, at the middles of its edges. The surface and what is on it stay as they
// were: positions and primvars are interpolated linearly, normals get their length back. Triangles that shared an edge
// share its new point, and corners that shared a face-varying element share the new one.
void SplitTriangles(wavefront::MeshData& mesh, int levels);

// Points at the same place become one, so that displacement does not take them apart; what they carried each becomes
// face-varying.
void WeldPoints(wavefront::MeshData& mesh);

}  // namespace delegate
