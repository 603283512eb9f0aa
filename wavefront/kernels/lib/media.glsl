// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Homogeneous media inside of bodies. A path keeps two chunks:
//  - MediaStack: the bodies that it is inside of, up to four entries of 32 bits, filled from the front in the order in
//    which they were entered: first texel of the material's parameter block + 1 (27 bits; 0: unused), priority (5 bits).
//    The path is in the one of highest priority; among equals, in the one entered last (Schmidt and Budge, "Simple Nested
//    Dielectrics in Ray Traced Images", 2002, section 2). A body is left by its entry, so bodies that overlap (a liquid
//    that reaches into its glass) may be left in any order.
//  - Medium: the coefficients of the one it is in now. They are taken where the path enters; those of a body that it
//    comes back to stand in the first two texels of that material's parameter block.
// Rays in a body that scatters reach no farther than a free flight sampled when they start (tMax): a miss is a
// scattering event. The channel that a flight is sampled in is chosen by throughput, and weights are the balance
// heuristic over channels (Veach 1997), so that no channel can blow up; as the choice follows the throughput, a segment
// may be cut in two (a surface passed by opacity) without a new sample.
#ifndef WAVEFRONT_LIB_MEDIA_GLSL
#define WAVEFRONT_LIB_MEDIA_GLSL
#include "lib/bindings.glsl"
#include "lib/features.glsl"

struct Medium {
  vec3 absorption;   // 1 / scene unit
  vec3 scattering;
  float anisotropy;  // mean cosine of Henyey and Greenstein's phase function
};
Medium clearMedium() { return Medium(vec3(0.0), vec3(0.0), 0.0); }

// ---- Chunk Medium: x y z: absorption | scattering << 16 of r, g, b; w: anisotropy (12 bits) | scatters << 12 -----------

// Six bits of exponent and ten of mantissa: 2e-10 to 8e9, to 0.05 %. No number counts as 0, infinity as the most there is.
vec3 finiteCoefficients(vec3 v) { return mix(vec3(0.0), min(v, vec3(4e9)), greaterThan(v, vec3(0.0))); }
uvec3 packCoefficients(vec3 v) {
  v = finiteCoefficients(v);
  return uvec3(max(ivec3((floatBitsToUint(v) + 0x1000u) >> 13) - (95 << 10), ivec3(0)));
}
vec3 unpackCoefficients(uvec3 bits) {
  return mix(uintBitsToFloat((bits + (95u << 10)) << 13), vec3(0.0), equal(bits, uvec3(0u)));
}
// As a path can walk it: mean free paths below `shortest` would get lost in rounding, so denser media that scatter get that
// density. The share that each event absorbs stays, so that this is what the medium tends to.
Medium walkableMedium(Medium m, float shortest) {
  vec3 absorption = finiteCoefficients(m.absorption), scattering = finiteCoefficients(m.scattering);
  vec3 scale = mix(vec3(1.0), 1.0 / max(shortest * (absorption + scattering), vec3(1.0)), greaterThan(scattering, vec3(0.0)));
  return Medium(absorption * scale, scattering * scale, m.anisotropy);
}
const uint kMediumScatters = 0x1000u;

uvec4 packMedium(Medium m) {
  uvec3 scattering = packCoefficients(m.scattering);
  float anisotropy = isnan(m.anisotropy) ? 0.0 : clamp(m.anisotropy, -0.999, 0.999);
  uint g = uint(anisotropy * 2047.0 + 2048.5);
  bool scatters = (scattering.x | scattering.y | scattering.z) != 0u;
  return uvec4(packCoefficients(m.absorption) | scattering << 16, g | (scatters ? kMediumScatters : 0u));
}
bool mediumScatters(uvec4 medium) { return kHasScatteringMedia && (medium.w & kMediumScatters) != 0u; }
float mediumAnisotropy(uvec4 medium) { return (float(medium.w & 0xfffu) - 2048.0) * (1.0 / 2047.0); }
vec3 mediumScattering(uvec4 medium) { return unpackCoefficients(medium.xyz >> 16); }
vec3 mediumExtinction(uvec4 medium) { return unpackCoefficients(medium.xyz & 0xffffu) + mediumScattering(medium); }

// What a segment of that length leaves of the throughput: the path scatters at its end, or meets a surface there.
vec3 mediumWeight(uvec4 medium, vec3 throughput, float distance, bool scatters) {
  vec3 scattering = mediumScattering(medium);
  vec3 extinction = unpackCoefficients(medium.xyz & 0xffffu) + scattering;
  vec3 transmittance = exp(-extinction * distance);
  vec3 chance = throughput / max(throughput.r + throughput.g + throughput.b, 1e-30);
  float density = dot(chance, scatters ? extinction * transmittance : transmittance);
  vec3 value = scatters ? scattering * transmittance : transmittance;
  return mediumScatters(medium) ? value / max(density, 1e-30) : transmittance;
}
// A free flight for a path of that throughput; `u` chooses the channel and is stretched.
float mediumFlight(uvec4 medium, vec3 throughput, float u) {
  vec3 extinction = mediumExtinction(medium);
  float x = u * (throughput.r + throughput.g + throughput.b);
  vec2 upTo = vec2(throughput.r, throughput.r + throughput.g);
  bool isRed = x < upTo.x, isGreen = x < upTo.y;
  float share = isRed ? throughput.r : (isGreen ? throughput.g : throughput.b);
  float sigma = isRed ? extinction.r : (isGreen ? extinction.g : extinction.b);
  float v = clamp((isRed ? x : (isGreen ? x - upTo.x : x - upTo.y)) / max(share, 1e-30), 0.0, 0.9999999);
  return sigma > 0.0 ? min(-log(1.0 - v) / sigma, 3e38) : 3e38;
}
// What is left of light on its way through the medium. Lights at infinity are seen from open bodies that only absorb
// without loss, and not from open bodies that scatter: extension rays do the same.
vec3 mediumTransmittance(uvec4 medium, float distance) {
  vec3 transmittance = exp(-mediumExtinction(medium) * min(distance, 1e30));
  return distance < 1e29 || mediumScatters(medium) ? transmittance : vec3(1.0);
}

// ---- Chunk MediaStack -------------------------------------------------------------------------------------------------

uint mediumEntry(uint parameterBase, uint priority) { return ((parameterBase + 1u) & 0x7ffffffu) | min(priority, 31u) << 27; }
uint mediumPriority(uint entry) { return entry >> 27; }

// The entry that the path is in, entries equal to `except` not counted (0: all count); 0: in none.
uint mediumTop(uvec4 stack, uint except) {
  uvec4 e = mix(stack, uvec4(0u), equal(stack, uvec4(except)));
  uint top = e.x;
  if (e.y != 0u && mediumPriority(e.y) >= mediumPriority(top)) top = e.y;
  if (e.z != 0u && mediumPriority(e.z) >= mediumPriority(top)) top = e.z;
  if (e.w != 0u && mediumPriority(e.w) >= mediumPriority(top)) top = e.w;
  return top;
}
// False where the stack is full; the body is then not entered.
bool mediumEnter(inout uvec4 stack, uint entry) {
  if (stack.x == 0u) stack.x = entry;
  else if (stack.y == 0u) stack.y = entry;
  else if (stack.z == 0u) stack.z = entry;
  else if (stack.w == 0u) stack.w = entry;
  else return false;
  return true;
}
// Leaves the body of that entry that was entered last. One that was never entered (the camera stands inside) is none to leave.
void mediumLeave(inout uvec4 stack, uint entry) {
  if (stack.w == entry) { stack.w = 0u; }
  else if (stack.z == entry) { stack.zw = uvec2(stack.w, 0u); }
  else if (stack.y == entry) { stack.yzw = uvec3(stack.zw, 0u); }
  else if (stack.x == entry) { stack = uvec4(stack.yzw, 0u); }
}

// ---- Parameter blocks: texel 0: absorption, anisotropy; texel 1: scattering, index of refraction -----------------------

Medium mediumAt(uint parameterBase) {
  vec4 a = texelFetch(materialParameters, int(parameterBase)), s = texelFetch(materialParameters, int(parameterBase + 1u));
  return Medium(a.rgb, s.rgb, a.w);
}
uvec4 mediumOf(uint entry) {
  if (entry == 0u) return uvec4(0u);
  return packMedium(mediumAt((entry & 0x7ffffffu) - 1u));
}
float mediumIor(uint entry) {
  return entry == 0u ? 1.0 : texelFetch(materialParameters, int(entry & 0x7ffffffu)).w;  // base + 1 is texel 1
}
#endif
