// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Radiance that a light sends along a direction: UsdLux shaping and textures.
#ifndef WAVEFRONT_LIGHTS_EMISSION_GLSL
#define WAVEFRONT_LIGHTS_EMISSION_GLSL
#include "lib/features.glsl"
#include "lib/lights/record.glsl"
#include "lib/textures.glsl"

// UsdLuxShapingAPI; `emission`: unit direction away from the light, world space. The axis is -Z.
// Cone: L *= 1 - smoothstep(lerp(cutoff, 0, softness), cutoff, angle). Focus: L *= lerp(focusTint, 1, cos^focus); behind
// the light the specification is silent: the cosine is clamped at 0 there, so the tint remains.
vec3 lightShaping(Light l, vec3 emission) {
  vec3 e = normalize(toLightSpace(l, emission));
  float cosine = clamp(-e.z, -1.0, 1.0);
  float angle = acos(cosine);
  float inside = l.coneStart < l.coneCutoff ? 1.0 - smoothstep(l.coneStart, l.coneCutoff, angle) : (angle <= l.coneCutoff ? 1.0 : 0.0);
  vec3 shaped = vec3(inside);
  if (l.focus > 0.0) shaped *= mix(l.focusTint, vec3(1.0), pow(max(cosine, 0.0), l.focus));
  return shaped;
}

// Latlong coordinates of a direction in the dome's space; pole +Y, u = .25 at +X, .5 at +Z (OpenEXR's convention).
vec2 domeUv(vec3 d) {
  return vec2(fract((atan(d.z, d.x) + 1.57079632679) * 0.15915494309), 1.0 - acos(clamp(d.y, -1.0, 1.0)) * 0.31830988618);
}
vec3 domeDirection(vec2 uv) {
  float phi = uv.x * 6.28318530718 - 1.57079632679;
  float theta = (1.0 - uv.y) * 3.14159265359;
  float s = sin(theta);
  return vec3(s * cos(phi), cos(theta), s * sin(phi));
}

// `emission`: unit, world, away from the light. `unitPoint`: where on the unit shape (area lights).
// `footprint`: of the lookup in uv units.
vec3 lightRadiance(Light l, vec3 emission, vec3 unitPoint, float footprint) {
  vec3 radiance = l.radiance;
  vec2 uv = vec2(0.5 - unitPoint.x, 0.5 + unitPoint.y);  // UsdLux: upright and unmirrored when looked at from the front
  uint wrapU = 1u;
  if (kHasDomeLights && l.type == kLightDome) { uv = domeUv(normalize(toLightSpace(l, -emission))); wrapU = 0u; }
  if (kHasTexturedLights && l.textureId != 0xffffffffu) radiance *= textureRead(l.textureId, uv, footprint, wrapU, 1u, vec4(0.0)).rgb;
  if (kHasShapedLights && l.type != kLightDome && l.type != kLightDistant) radiance *= lightShaping(l, emission);
  return radiance;
}
#endif
