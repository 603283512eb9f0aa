#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Shadow ray cast: is the light sample seen? Surfaces that are not opaque send the path to their opacity kernel.
// One that is seen is added to what the path gathered, unless its emission is still to be found.
// Reads: ShadowOrigin, LightSample, ShadowHit, ShadowContribution, Radiance, Ids, Cone.
// Writes: ShadowHit, ShadowOrigin, ShadowContribution, Radiance, Ids.
// Runs after: the materials (which push).
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/features.glsl"
#include "lib/contribute.glsl"
#include "lib/traversal_hooks.glsl"
#include "lib/traverse.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueShadowRay, path)) return;
  vec4 o = uintBitsToFloat(loadPath(kChunkShadowOrigin, path));
  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  uvec4 contribution = loadPath(kChunkShadowContribution, path);
  uint flags = loadPathWord(kChunkIds, path, 3u);
  uint last = floatBitsToUint(o.w);  // the instance to be skipped
  float from = 0.0;
  if (shadowPassed(last)) {
    last &= ~kShadowPassed;
    from = uintBitsToFloat(loadPathWord(kChunkShadowHit, path, 2u));
  }
  uint result = kShadowClear;
  Hit hit;
  if (frame.hasGeometry != 0u && light.w > 0.0) {
    result = traverseShadow(Ray(o.xyz, from, light.xyz, light.w), 4u, last, contribution.w, hit);
  }
  uint phase = kPhaseReady;
  if (result == kShadowNeedsOpacity) {
    storePathWord(kChunkShadowOrigin, path, 3u, hit.instance | kShadowPassed);
    storePathWord(kChunkShadowContribution, path, 3u, hit.triangle);
    storePathRgb(kChunkShadowHit, path, vec3(hit.u, hit.v, hit.t));
    phase = kPhaseOpacity;
  } else if (result == kShadowClear) {
    bool triangle = false;
    if (kHasEmissiveMeshes) triangle = texelFetch(lightItems, int(loadPathWord(kChunkCone, path, 2u))).y != kNoLight;
    if (triangle) phase = kPhaseEmission;
    else addSeenLight(path, uintBitsToFloat(contribution.rgb));
  }
  storePathWord(kChunkIds, path, 3u, withPhase(flags, phase));
}
