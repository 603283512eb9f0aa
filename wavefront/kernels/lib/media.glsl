// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The stack of media that a path is inside of: up to four entries of 64 bits (chunks MediaA and MediaB), filled from the
// front in the order in which they were entered. The path is in the one of highest priority; among equals, in the one
// entered last (Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", 2002, section 2). A body is left by
// its id, so bodies that overlap (a liquid that reaches into its glass) may be left in any order.
//
// Entry: extinction r, g, b as halves without their sign (15 bits each), id (14 bits; 0: unused), priority (5 bits):
//   x = r | g << 15 | (id & 3) << 30      y = b | (id >> 2) << 15 | priority << 27
#ifndef WAVEFRONT_LIB_MEDIA_GLSL
#define WAVEFRONT_LIB_MEDIA_GLSL

struct Medium {
  vec3 extinction;  // 1 / scene unit
  uint id;          // of the material: bodies of one material are alike
  uint priority;    // 0..31
};
const uint kMediumIds = 16383u;

uvec2 packMedium(Medium m) {
  m.extinction = clamp(m.extinction, vec3(0.0), vec3(65000.0));
  uint rg = packHalf2x16(m.extinction.xy), b = packHalf2x16(vec2(m.extinction.z, 0.0));
  uint id = 1u + m.id % kMediumIds;
  return uvec2((rg & 0x7fffu) | ((rg >> 16) & 0x7fffu) << 15 | (id & 3u) << 30,
               (b & 0x7fffu) | (id >> 2) << 15 | min(m.priority, 31u) << 27);
}
vec3 unpackExtinction(uvec2 e) {
  return vec3(unpackHalf2x16((e.x & 0x7fffu) | ((e.x >> 15) & 0x7fffu) << 16), unpackHalf2x16(e.y & 0x7fffu).x);
}
uint mediumId(uvec2 e) { return (e.x >> 30) | ((e.y >> 15) & 0xfffu) << 2; }  // as packed; 0: unused
uint mediumPriority(uvec2 e) { return e.y >> 27; }

vec3 mediumExtinction(uvec4 a, uvec4 b) {
  uvec2 inside = a.xy;
  if (mediumId(a.zw) != 0u && mediumPriority(a.zw) >= mediumPriority(inside)) inside = a.zw;
  if (mediumId(b.xy) != 0u && mediumPriority(b.xy) >= mediumPriority(inside)) inside = b.xy;
  if (mediumId(b.zw) != 0u && mediumPriority(b.zw) >= mediumPriority(inside)) inside = b.zw;
  return unpackExtinction(inside);  // an unused entry is zero
}

// False where the stack is full; the medium is then not entered.
bool mediumEnter(inout uvec4 a, inout uvec4 b, Medium m) {
  uvec2 e = packMedium(m);
  if (mediumId(a.xy) == 0u) a.xy = e;
  else if (mediumId(a.zw) == 0u) a.zw = e;
  else if (mediumId(b.xy) == 0u) b.xy = e;
  else if (mediumId(b.zw) == 0u) b.zw = e;
  else return false;
  return true;
}
// Leaves the body of that id that was entered last. One that was never entered (the camera stands inside) is none to leave.
void mediumLeave(inout uvec4 a, inout uvec4 b, uint id) {
  id = 1u + id % kMediumIds;
  if (mediumId(b.zw) == id) { b.zw = uvec2(0u); }
  else if (mediumId(b.xy) == id) { b = uvec4(b.zw, 0u, 0u); }
  else if (mediumId(a.zw) == id) { a.zw = b.xy; b = uvec4(b.zw, 0u, 0u); }
  else if (mediumId(a.xy) == id) { a = uvec4(a.zw, b.xy); b = uvec4(b.zw, 0u, 0u); }
}
#endif
