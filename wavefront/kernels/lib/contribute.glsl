// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The one way by which radiance reaches a path's result. Whatever is to be told apart later (light path expressions,
// light groups, lobe AOVs) hangs here: every caller says what the path has been through and whose light it is.
#ifndef WAVEFRONT_LIB_CONTRIBUTE_GLSL
#define WAVEFRONT_LIB_CONTRIBUTE_GLSL
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"

// Events of a path so far (chunk HitDistance, second word).
const uint kEventReflection = 1u;
const uint kEventTransmission = 2u;

// Nothing is told apart yet: where events and light would be read for contribute() alone, they are not.
const bool kTellsApart = false;

uint pathEvents(uint path) {
  uint events = 0u;
  if (kTellsApart) events = loadPathWord(kChunkHitDistance, path, 1u);
  return events;
}
void setPathEvents(uint path, uint events) {
  if (kTellsApart) storePathWord(kChunkHitDistance, path, 1u, events);
}

const uint kNoLightGroup = 0u;  // also of emissive meshes: nothing gives them a group yet

uint lightGroup(uint lightFlags) { return lightFlags >> kLightGroupShift; }
// Group of the light that a light sample chose.
uint lightItemGroup(uint item) {
  uvec2 chosen = texelFetch(lightItems, int(item)).xy;
  if (chosen.y != kNoLight) return kNoLightGroup;
  return lightGroup(floatBitsToUint(texelFetch(lightRecords, int(chosen.x * kLightTexels)).y));
}

// `radiance`: gathered so far. `value`: throughput and MIS weight included.
vec3 contribute(vec3 radiance, vec3 value, uint events, uint lightGroup) { return radiance + value; }

// What chunk Radiance gains from the light sample that was seen.
void addSeenLight(uint path, vec3 contribution) {
  uint item = 0u;
  if (kTellsApart) item = loadPathWord(kChunkCone, path, 2u);
  vec3 radiance = uintBitsToFloat(loadPath(kChunkRadiance, path)).rgb;
  radiance = contribute(radiance, contribution, pathEvents(path), kTellsApart ? lightItemGroup(item) : kNoLightGroup);
  storePathRgb(kChunkRadiance, path, radiance);
}
#endif
