#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Shadow ray cast: is the light sample seen? Surfaces that are not opaque send the path to their opacity kernel.
// One that is seen is added to what the path gathered, unless its emission is still to be found.
// Reads: ShadowOrigin, LightSample, ShadowHit, ShadowContribution, Radiance, Ids. Writes: ShadowHit, ShadowOrigin, Radiance, Ids.
// Runs after: the materials (which push).
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/contribute.glsl"
#include "lib/traversal_hooks.glsl"
#include "lib/traverse.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueShadowRay, path)) return;
  vec4 o = uintBitsToFloat(loadPath(kChunkShadowOrigin, path));
  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  uvec4 lastHit = loadPath(kChunkShadowHit, path);
  uint result = kShadowClear;
  Hit hit;
  if (frame.hasGeometry != 0u && light.w > 0.0) {
    result = traverseShadow(Ray(o.xyz, o.w, light.xyz, light.w), 4u, lastHit.x, lastHit.y, hit);
  }
  uint phase = kPhaseReady;
  if (result == kShadowNeedsOpacity) {
    storePath(kChunkShadowHit, path, uvec4(hit.instance, hit.triangle, floatBitsToUint(hit.u), floatBitsToUint(hit.v)));
    storePathF(kChunkShadowOrigin, path, vec4(o.xyz, hit.t));
    phase = kPhaseOpacity;
  } else if (result == kShadowClear) {
    uvec4 contribution = loadPath(kChunkShadowContribution, path);
    if (contribution.w != kNoLight) phase = kPhaseEmission;
    else addSeenLight(path, uintBitsToFloat(contribution.rgb));
  }
  storePathWord(kChunkIds, path, 3u, withPhase(loadPath(kChunkIds, path).w, phase));
}
