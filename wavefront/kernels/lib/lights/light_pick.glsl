// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which light item is sampled at a point, and how probable that was. Items 0 to infiniteLightCount - 1 are lights at
// infinity. Where there is a light tree, one entry of the distribution behind them stands for all others.
#ifndef WAVEFRONT_LIGHTS_LIGHT_PICK_GLSL
#define WAVEFRONT_LIGHTS_LIGHT_PICK_GLSL
#include "lib/features.glsl"
#include "lib/lights/distribution.glsl"
#include "lib/lights/light_tree.glsl"

uvec4 lightItem(uint item) { return texelFetch(lightItems, int(item)); }

// The item that u, uniform in [0, 1), picks at p. A probability of 0 says that no light reaches p.
uint pickLightItem(vec3 p, float u, out float probability) {
  bool tree = kHasLightTree && frame.lightTree != 0u;
  uint item = searchCdf(0u, tree ? frame.infiniteLightCount + 1u : frame.lightItemCount, u);
  if (tree && item == frame.infiniteLightCount) {
    float before = distributionAt(item);
    float inTree;
    uint picked = lightTreeWalk(p, false, 0u, clamp((u - before) / (1.0 - before), 0.0, 0.99999994), inTree);
    probability = (1.0 - before) * inTree;
    return picked == kNoLight ? item : picked;
  }
  probability = uintBitsToFloat(lightItem(item).z);
  return item;
}

// The probability of a light at infinity is the same everywhere (and a kernel that asks for it alone walks no tree).
float infiniteLightProbability(uint item) { return uintBitsToFloat(lightItem(item).z); }

// Of that same choice at p.
float lightItemProbability(uint item, vec3 p) {
  uint z = lightItem(item).z;
  if (!kHasLightTree || frame.lightTree == 0u || item < frame.infiniteLightCount) return uintBitsToFloat(z);
  float inTree;
  lightTreeWalk(p, true, z, 0.0, inTree);
  return (1.0 - distributionAt(frame.infiniteLightCount)) * inTree;
}
#endif
