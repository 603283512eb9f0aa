#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Stands in for the surface kernel of a material that has none: a matte grey while it is being compiled (interactive
// renders only, and nothing of it stays in the film), magenta where it does not compile.
// Reads, writes and pushes what every surface kernel does (material/surface_tail.glsl). Runs after: scatter.
// pushWord1: 0 grey, 1 magenta.
#extension GL_GOOGLE_include_directive : require
#include "material/surface_head.glsl"

struct Closure {
  vec3 opacity;
  vec3 emission;
  Medium interior;
  vec3 albedo;
  Frame frame;
};
const bool kHasTransmission = false;
const bool kHasOpacity = false;
const bool kHasEmission = false;
const bool kHasSubsurface = false;
void closureMake(ShadingPoint sp, out Closure c) {
  c.opacity = vec3(1.0);
  c.emission = vec3(0.0);
  c.interior = clearMedium();
  c.albedo = pushWord1 != 0u ? vec3(1.0, 0.0, 1.0) : vec3(0.5);
  c.frame = frameFromNormal(dot(sp.normalWorld, sp.wo) < 0.0 ? -sp.normalWorld : sp.normalWorld);
}
vec4 closureEval(Closure c, vec3 wo, vec3 wi, inout vec3 below) {
  float k = max(toLocal(c.frame, wi).z, 0.0) * 0.31830988618;
  return vec4(c.albedo * k, k);
}
vec3 closureSample(Closure c, vec3 wo, float uLobe, vec2 u) {
  float r = sqrt(u.x), phi = 6.28318530718 * u.y;
  return toWorld(c.frame, vec3(r * cos(phi), r * sin(phi), sqrt(max(0.0, 1.0 - u.x))));
}
vec3 closureAlbedo(Closure c, vec3 wo) { return c.albedo; }
SubsurfaceLobe closureWalk(Closure c, float u, inout vec3 below) {
  return subsurfaceMake(c.albedo, vec3(0.0), vec3(0.0), 0.0);
}
#include "material/surface_tail.glsl"
