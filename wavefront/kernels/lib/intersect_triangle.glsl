// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Watertight ray-triangle test: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
//
// Why no second look in double precision where an edge function is 0, as the paper has it: rounding is monotone, so
// the sign of fl(fl(ab) - fl(cd)) is right or it is 0, never wrong; and 0 counts as inside for the triangles on both
// sides of an edge. So a rounded 0 can only add a hit, never lose one. What it could add at a distance - a far, tiny
// triangle whose corners round to one line through the ray has two zeros - is refused by asking that the ray meets the
// bounding box of the three corners, which needs no arithmetic and is always true for a real hit.
// `precise` keeps the compiler from fusing the products (which would break the argument) and makes t, u, v one
// function of ray and triangle in every kernel.
#ifndef WAVEFRONT_LIB_INTERSECT_TRIANGLE_GLSL
#define WAVEFRONT_LIB_INTERSECT_TRIANGLE_GLSL

// What the test needs of a ray, computed once per ray and object space.
struct TriangleTestRay {
  vec3 origin;
  vec3 shear;   // Sx, Sy, Sz of the paper
  bool xIsMain; // the largest component of the direction (z if neither)
  bool yIsMain;
};

// Cyclic permutation that brings the main axis to z.
vec3 permuteToMainAxis(bool xIsMain, bool yIsMain, vec3 p) {
  return xIsMain ? p.yzx : (yIsMain ? p.zxy : p);
}

TriangleTestRay prepareTriangleTest(vec3 origin, vec3 direction) {
  TriangleTestRay r;
  vec3 a = abs(direction);
  r.origin = origin;
  r.xIsMain = a.x > a.y && a.x > a.z;
  r.yIsMain = !r.xIsMain && a.y > a.z;
  vec3 d = permuteToMainAxis(r.xIsMain, r.yIsMain, direction);
  precise float rcp = 1.0 / d.z;
  precise float sx = d.x * rcp;
  precise float sy = d.y * rcp;
  r.shear = vec3(sx, sy, rcp);
  return r;
}

// True if the ray's line meets the triangle, from either side, edges and vertices included; then t, u, v are set.
// False for triangles without area and for anything with a NaN.
bool intersectTriangle(TriangleTestRay ray, vec3 v0, vec3 v1, vec3 v2, out float t, out float u, out float v) {
  precise vec3 a = permuteToMainAxis(ray.xIsMain, ray.yIsMain, v0 - ray.origin);
  precise vec3 b = permuteToMainAxis(ray.xIsMain, ray.yIsMain, v1 - ray.origin);
  precise vec3 c = permuteToMainAxis(ray.xIsMain, ray.yIsMain, v2 - ray.origin);
  precise vec2 ap = a.xy - ray.shear.xy * a.z;
  precise vec2 bp = b.xy - ray.shear.xy * b.z;
  precise vec2 cp = c.xy - ray.shear.xy * c.z;
  precise float e0 = cp.x * bp.y - cp.y * bp.x;
  precise float e1 = ap.x * cp.y - ap.y * cp.x;
  precise float e2 = bp.x * ap.y - bp.y * ap.x;
  // Comparisons: minima and maxima of floats cost three instructions each on lavapipe, which asks them for NaNs.
  bool inside = (e0 >= 0.0 && e1 >= 0.0 && e2 >= 0.0) || (e0 <= 0.0 && e1 <= 0.0 && e2 <= 0.0);
  inside = inside && (ap.x <= 0.0 || bp.x <= 0.0 || cp.x <= 0.0) && (ap.x >= 0.0 || bp.x >= 0.0 || cp.x >= 0.0) &&
           (ap.y <= 0.0 || bp.y <= 0.0 || cp.y <= 0.0) && (ap.y >= 0.0 || bp.y >= 0.0 || cp.y >= 0.0);
  precise float det = e0 + e1 + e2;
  precise float rcpDet = 1.0 / det;
  // Weights first, so that products of coordinates stay small for large and for tiny triangles.
  precise float w0 = e0 * rcpDet;
  precise float w1 = e1 * rcpDet;
  precise float w2 = e2 * rcpDet;
  precise float depth = w0 * a.z + w1 * b.z + w2 * c.z;
  precise float distance = depth * ray.shear.z;
  t = distance;
  u = w1;
  v = w2;
  return inside && abs(det) > 0.0;
}

#endif
