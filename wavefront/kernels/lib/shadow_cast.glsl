// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The light sample, weighed by whoever scatters: casts a shadow ray if it is worth one.
#ifndef WAVEFRONT_LIB_SHADOW_CAST_GLSL
#define WAVEFRONT_LIB_SHADOW_CAST_GLSL
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/mis.glsl"

// `at`: the point that the light was sampled from; `from`: where the ray starts, off the surface; `skip`: the surface
// that it starts on: instance and triangle record. `value`: what scatters towards the light, and its pdf.
void castShadowRay(uint path, vec3 at, vec3 from, uvec2 skip, vec3 throughput, vec4 light, vec4 lightRadiance,
                   uint item, vec4 value) {
  if (!(lightRadiance.a > 0.0)) return;
  bool shadowless = light.w < 0.0;
  float weight = shadowless ? 1.0 : powerHeuristic(lightRadiance.a, value.a);
  vec3 contribution = throughput * value.rgb * lightRadiance.rgb * (weight / lightRadiance.a);
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;
  bool triangle = texelFetch(lightItems, int(item)).y != kNoLight;
  // An emissive triangle ends the shadow ray just before it; analytic lights never block. The ray is aimed from where it
  // starts: along the old direction it would meet a triangle close to the surface's plane too early.
  if (triangle && !shadowless) {
    vec3 toLight = at + light.xyz * light.w - from;
    float distance = length(toLight);
    if (distance > 0.0) light.xyz = toLight / distance;
    light.w = distance * (1.0 - 1e-4);
    storePathF(kChunkLightSample, path, light);
  }
  storePath(kChunkShadowOrigin, path, uvec4(floatBitsToUint(from), skip.x));
  storePath(kChunkShadowContribution, path, uvec4(floatBitsToUint(contribution), skip.y));
  pushShadowRay(path);
}
#endif
