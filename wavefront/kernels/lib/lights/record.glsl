// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A light record as read from the light table, and what all light types share: the map from unit shape to world.
#ifndef WAVEFRONT_LIGHTS_RECORD_GLSL
#define WAVEFRONT_LIGHTS_RECORD_GLSL
#include "lib/bindings.glsl"

struct Light {
  uint type, flags, textureId, item;
  vec4 r0, r1, r2;           // unit shape to world, size included
  vec4 w0, w1, w2;           // world to light space (no size): shaping and dome lookups
  vec3 radiance;
  float solidAngle;          // distant
  float coneCutoff, coneStart, focus, halfAngle;
  vec3 focusTint;
  uint distribution;         // dome: first float of its importance map; kNoStream: none
};

vec4 lightTexel(uint index, uint texel) { return texelFetch(lightRecords, int(index * kLightTexels + texel)); }

Light lightLoad(uint index) {
  Light l;
  uvec4 head = floatBitsToUint(lightTexel(index, 0u));
  l.type = head.x; l.flags = head.y; l.textureId = head.z; l.item = head.w;
  l.r0 = lightTexel(index, 1u); l.r1 = lightTexel(index, 2u); l.r2 = lightTexel(index, 3u);
  l.w0 = lightTexel(index, 4u); l.w1 = lightTexel(index, 5u); l.w2 = lightTexel(index, 6u);
  vec4 t7 = lightTexel(index, 7u), t8 = lightTexel(index, 8u), t9 = lightTexel(index, 9u);
  l.radiance = t7.rgb; l.solidAngle = t7.w;
  l.coneCutoff = t8.x; l.coneStart = t8.y; l.focus = t8.z; l.halfAngle = t8.w;
  l.focusTint = t9.rgb; l.distribution = floatBitsToUint(t9.w);
  return l;
}

// A light that throws no shadow is found by light samples only: bounce rays, which things do block, must not count it.
bool castsShadow(uint lightFlags) { return (frame.flags & kFrameShadows) != 0u && (lightFlags & kLightFlagShadows) != 0u; }

vec3 lightColumn(Light l, int c) { return vec3(l.r0[c], l.r1[c], l.r2[c]); }
vec3 lightPoint(Light l, vec3 p) { vec4 q = vec4(p, 1.0); return vec3(dot(l.r0, q), dot(l.r1, q), dot(l.r2, q)); }
vec3 toLightSpace(Light l, vec3 v) { return vec3(dot(l.w0.xyz, v), dot(l.w1.xyz, v), dot(l.w2.xyz, v)); }

// Cofactor of the unit-to-world map times a unit-shape normal: its length is the area stretch at that point, its
// direction the world normal (outward also for mirrored transforms).
vec3 lightAreaVector(Light l, vec3 n) {
  vec3 c0 = lightColumn(l, 0), c1 = lightColumn(l, 1), c2 = lightColumn(l, 2);
  vec3 a = n.x * cross(c1, c2) + n.y * cross(c2, c0) + n.z * cross(c0, c1);
  return (l.flags & kLightFlagMirrored) != 0u ? -a : a;
}
#endif
