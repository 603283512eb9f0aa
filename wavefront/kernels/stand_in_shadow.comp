#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Stands in for the opacity and the emission kernel of a material that has none: an opaque surface that does not shine,
// so the light sample is lost.
// Reads: Ids. Writes: Ids. Runs after: scatter.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!bucketPath(path)) return;
  storePathWord(kChunkIds, path, 3u, withPhase(loadPath(kChunkIds, path).w, kPhaseReady));
}
