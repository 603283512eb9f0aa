// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Orthonormal frames; z is the normal.
#ifndef WAVEFRONT_LIB_FRAME_GLSL
#define WAVEFRONT_LIB_FRAME_GLSL
struct Frame { vec3 x, y, z; };

// Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
Frame frameFromNormal(vec3 n) {
  float s = n.z >= 0.0 ? 1.0 : -1.0;
  float a = -1.0 / (s + n.z);
  float b = n.x * n.y * a;
  return Frame(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}
// x as near to t as the normal allows; an arbitrary one where t is along n or not finite.
Frame frameFromNormalTangent(vec3 n, vec3 t) {
  vec3 x = t - n * dot(n, t);
  float l2 = dot(x, x);
  if (!(l2 > 1e-12)) return frameFromNormal(n);
  x *= inversesqrt(l2);
  return Frame(x, cross(n, x), n);
}
vec3 toLocal(Frame f, vec3 v) { return vec3(dot(f.x, v), dot(f.y, v), dot(f.z, v)); }
vec3 toWorld(Frame f, vec3 v) { return f.x * v.x + f.y * v.y + f.z * v.z; }
#endif
