// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Choosing a light item and sampling it. Items: one per analytic light, one per emissive triangle.
#ifndef WAVEFRONT_LIGHTS_LIGHT_TABLE_GLSL
#define WAVEFRONT_LIGHTS_LIGHT_TABLE_GLSL
#include "lib/features.glsl"
#include "lib/lights/shapes.glsl"
#include "lib/lights/infinite.glsl"
#include "lib/records.glsl"
#include "lib/lights/light_pick.glsl"
#include "lib/mis.glsl"

// Square to triangle without folding (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
vec2 sampleTriangle(vec2 u) {
  if (u.y > u.x) { u.x *= 0.5; u.y -= u.x; } else { u.y *= 0.5; u.x -= u.y; }
  return vec2(1.0 - u.x - u.y, u.y);
}

// World corners of an emissive triangle: one corner and two edges.
void lightTriangle(uvec4 item, out vec3 p0, out vec3 e1, out vec3 e2) {
  vec4 w0 = instanceRow(item.x, 4u), w1 = instanceRow(item.x, 5u), w2 = instanceRow(item.x, 6u);
  int texel = int(item.y * kTriangleTexels);
  vec3 a = texelFetch(triangleRecords, texel).xyz, b = texelFetch(triangleRecords, texel + 1).xyz, c = texelFetch(triangleRecords, texel + 2).xyz;
  p0 = transformPoint(w0, w1, w2, a);
  e1 = transformVector(w0, w1, w2, b - a);
  e2 = transformVector(w0, w1, w2, c - a);
}
// Samples an item that was picked with this probability, as seen from p. `radiance` is 1 for emissive triangles: the emission kernel finds it later.
LightSample sampleLightItem(uint item, float probability, vec3 p, vec2 u, float footprint, out vec3 radiance) {
  uvec4 it = lightItem(item);
  LightSample s;
  radiance = vec3(1.0);
  if (kHasEmissiveMeshes && it.y != kNoLight) {
    vec3 p0, e1, e2;
    lightTriangle(it, p0, e1, e2);
    vec2 b = sampleTriangle(u);
    vec3 d = p0 + b.x * e1 + b.y * e2 - p;
    float d2 = dot(d, d);
    s.distance = sqrt(d2);
    s.direction = d2 > 0.0 ? d / s.distance : vec3(0.0, 0.0, 1.0);
    s.unitPoint = vec3(b, 0.0);
    s.pdf = d2 > 0.0 ? trianglePdf(e1, e2, s.direction, s.distance) : 0.0;
  } else {
    Light l = lightLoad(it.x);
    s.pdf = 0.0;
    if (kHasDomeLights && l.type == kLightDome) s = sampleDome(l, u);
    else if (kHasDistantLights && l.type == kLightDistant) s = sampleDistant(l, u);
    else if (kHasLightShapes) s = sampleShape(l, p, u);
    radiance = lightRadiance(l, -s.direction, s.unitPoint, footprint);
  }
  s.pdf *= probability;
  return s;
}
#endif
