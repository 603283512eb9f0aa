// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The medium below a surface of subsurface_bsdf: what a random walk needs so that the colour comes out.
#ifndef WAVEFRONT_LIB_SUBSURFACE_GLSL
#define WAVEFRONT_LIB_SUBSURFACE_GLSL
#include "lib/media.glsl"

// `radius` is the mean free path, and `color` what a thick body sends back of diffuse light. The single-scattering albedo
// for that: van de Hulst's similarity relation for a half space whose boundary bends nothing, inverted (Kulla and Conty
// 2017, "Revisiting Physically Based Shading at Imageworks"; OpenPBR 1.1, section "Subsurface").
// Shorter paths than `shortest` would get lost in rounding.
Medium subsurfaceMedium(vec3 color, vec3 radius, float anisotropy, float shortest) {
  vec3 s = 4.09712 + 4.20863 * color - sqrt(9.59217 + 41.6808 * color + 17.7126 * color * color);
  vec3 s2 = s * s;
  vec3 albedo = clamp((1.0 - s2) / (1.0 - anisotropy * s2), 0.0, 1.0);
  vec3 extinction = 1.0 / max(radius, vec3(max(shortest, 1e-9)));
  return Medium((1.0 - albedo) * extinction, albedo * extinction, anisotropy);
}
#endif
