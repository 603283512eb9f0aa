#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// AOV resolve: turns the film's sums into values. pushBucket: first channel; pushWord1: components; pushWord2: 1 for a
// Mean AOV, 2 for the sum itself (sampleCount), 0 for a FirstSample AOV.
// Reads: film. Writes: resolved. Runs when a host maps an AOV.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
layout(local_size_x = 64) in;

void main() {
  uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= frame.width * frame.bandHeight) return;
  for (uint c = 0u; c < pushWord1; ++c) {
    uint bits;
    if (pushWord2 == 0u) {
      bits = filmFirst[pixel * frame.firstChannels + pushBucket + c];
    } else {
      // The same float operations as ResolveFilm on the host: int64 to float, times a power of two, divided by the count.
      float sum = float(int64_t(filmSums[pixel * frame.sumChannels + pushBucket + c])) * (1.0 / kFilmScale);
      float count = float(int64_t(filmSums[pixel * frame.sumChannels + frame.countChannel])) * (1.0 / kFilmScale);
      bits = floatBitsToUint(pushWord2 == 2u ? sum : (count > 0.0 ? sum / count : 0.0));
    }
    resolved[pixel * pushWord1 + c] = bits;
  }
}
