// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The one way by which radiance reaches a path's result. Whatever is to be told apart later (light path expressions,
// light groups, lobe AOVs) hangs here: every caller says what the path has been through and whose light it is.
#ifndef WAVEFRONT_LIB_CONTRIBUTE_GLSL
#define WAVEFRONT_LIB_CONTRIBUTE_GLSL
#include "lib/bindings.glsl"

// Events of a path so far (chunk Cone, last word).
const uint kEventReflection = 1u;
const uint kEventTransmission = 2u;

const uint kNoLightGroup = 0u;  // also of emissive meshes: nothing gives them a group yet

uint lightGroup(uint lightFlags) { return lightFlags >> kLightGroupShift; }
// Group of the light that a light sample chose.
uint lightItemGroup(uint item) {
  uvec2 chosen = texelFetch(lightItems, int(item)).xy;
  if (chosen.y != kNoLight) return kNoLightGroup;
  return lightGroup(floatBitsToUint(texelFetch(lightRecords, int(chosen.x * kLightTexels)).y));
}

// `radiance`: rgb gathered so far and alpha. `value`: throughput and MIS weight included.
vec4 contribute(vec4 radiance, vec3 value, uint events, uint lightGroup) {
  return vec4(radiance.rgb + value, radiance.a);
}
#endif
