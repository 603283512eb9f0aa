// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The one way by which radiance reaches a path's result. Whatever is to be told apart later (light path expressions,
// light groups, lobe AOVs) hangs here: every caller says what the path has been through and whose light it is.
#ifndef WAVEFRONT_LIB_CONTRIBUTE_GLSL
#define WAVEFRONT_LIB_CONTRIBUTE_GLSL

// Events of a path so far (chunk Cone, last word).
const uint kEventReflection = 1u;
const uint kEventTransmission = 2u;

const uint kNoLightGroup = 0u;  // emissive meshes and light samples, until they carry their light's group

// `radiance`: rgb gathered so far and alpha. `value`: throughput and MIS weight included.
vec4 contribute(vec4 radiance, vec3 value, uint events, uint lightGroup) {
  return vec4(radiance.rgb + value, radiance.a);
}
#endif
