// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The stack of media that a path is inside of: up to four entries of 64 bits (chunks MediaA and MediaB). An entry is
// extinction r, g, b as halves and a 16-bit word (bit 0: used; upper byte: priority, reserved for nested dielectrics).
// Entries are filled from the front; the last used one is where the path is.
#ifndef WAVEFRONT_LIB_MEDIA_GLSL
#define WAVEFRONT_LIB_MEDIA_GLSL

vec3 unpackMedium(uvec2 e) { return vec3(unpackHalf2x16(e.x), unpackHalf2x16(e.y).x); }
uvec2 packMedium(vec3 extinction) {
  extinction = clamp(extinction, vec3(0.0), vec3(65000.0));
  return uvec2(packHalf2x16(extinction.xy), (packHalf2x16(vec2(extinction.z, 0.0)) & 0xffffu) | 0x10000u);
}
bool mediumUsed(uvec2 e) { return (e.y & 0x10000u) != 0u; }

vec3 mediumExtinction(uvec4 a, uvec4 b) {
  if (mediumUsed(b.zw)) return unpackMedium(b.zw);
  if (mediumUsed(b.xy)) return unpackMedium(b.xy);
  if (mediumUsed(a.zw)) return unpackMedium(a.zw);
  if (mediumUsed(a.xy)) return unpackMedium(a.xy);
  return vec3(0.0);
}
// False where the stack is full; the medium is then not entered.
bool mediumPush(inout uvec4 a, inout uvec4 b, vec3 extinction) {
  uvec2 e = packMedium(extinction);
  if (!mediumUsed(a.xy)) { a.xy = e; return true; }
  if (!mediumUsed(a.zw)) { a.zw = e; return true; }
  if (!mediumUsed(b.xy)) { b.xy = e; return true; }
  if (!mediumUsed(b.zw)) { b.zw = e; return true; }
  return false;
}
void mediumPop(inout uvec4 a, inout uvec4 b) {
  if (mediumUsed(b.zw)) b.zw = uvec2(0u);
  else if (mediumUsed(b.xy)) b.xy = uvec2(0u);
  else if (mediumUsed(a.zw)) a.zw = uvec2(0u);
  else a.xy = uvec2(0u);
}
#endif
