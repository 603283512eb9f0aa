// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Piecewise constant distributions in the light distribution stream.
#ifndef WAVEFRONT_LIGHTS_DISTRIBUTION_GLSL
#define WAVEFRONT_LIGHTS_DISTRIBUTION_GLSL
#include "lib/bindings.glsl"

float distributionAt(uint i) { return texelFetch(lightDistribution, int(i)).x; }

// Largest i in [0, count) with cdf[base + i] <= u, for a CDF of count + 1 values from 0 to 1.
uint searchCdf(uint base, uint count, float u) {
  uint lo = 0u, n = count;
  [[dont_unroll]] while (n > 1u) {
    uint h = n >> 1;
    if (distributionAt(base + lo + h) <= u) { lo += h; n -= h; } else { n = h; }
  }
  return lo;
}
#endif
