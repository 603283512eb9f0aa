// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Rays against the analytic light shapes in their unit space (shared/scene_layout.h), on the side that shines: planes
// towards -Z, round shapes outwards. The dark side is not there, as light shapes throw no shadow either: a camera
// inside of a sphere light, where stages like to put one, sees the scene. Distances below tMin do not count.
#ifndef WAVEFRONT_LIB_INTERSECT_LIGHT_SHAPE_GLSL
#define WAVEFRONT_LIB_INTERSECT_LIGHT_SHAPE_GLSL

// Roots of |q + t e|^2 = 1 in any dimension, given the dot products; x <= y, NaN if there is none. The discriminant
// comes from the closest point's distance, which does not cancel for distant origins: Haines et al., "Precision
// Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7.
vec2 unitRoots(float ee, float qe, float qq, float closestSquared) {
  float discriminant = ee * (1.0 - closestSquared);
  float s = -(qe + (qe < 0.0 ? -1.0 : 1.0) * sqrt(discriminant));  // NaN where the discriminant is negative
  float r0 = s / ee;
  float r1 = s != 0.0 ? (qq - 1.0) / s : r0;
  return discriminant >= 0.0 ? vec2(min(r0, r1), max(r0, r1)) : vec2(intBitsToFloat(0x7fc00000));
}

// True if there is a distance t >= tMin, or t > tMin where `beyond` is set, at which the line meets the shape.
bool intersectLightShape(uint kind, vec3 origin, vec3 direction, float tMin, bool beyond, out float t, out float u,
                         out float v) {
  u = 0.0;
  v = 0.0;
  // Plane shapes.
  precise float tPlane = -origin.z / direction.z;
  precise vec2 p = origin.xy + tPlane * direction.xy;
  bool isRect = kind == kKindRect;
  bool isPlane = isRect || kind == kKindDisk;
  bool insidePlane = isRect ? max(abs(p.x), abs(p.y)) <= 0.5 : dot(p, p) <= 1.0;
  // Round shapes: the cylinder is the sphere's equation without x, between two planes.
  bool isCylinder = kind == kKindCylinder;
  vec3 q = isCylinder ? vec3(0.0, origin.yz) : origin;
  vec3 e = isCylinder ? vec3(0.0, direction.yz) : direction;
  float ee = dot(e, e), qe = dot(q, e);
  vec3 closest = q - (qe / ee) * e;
  float tRound = unitRoots(ee, qe, dot(q, q), dot(closest, closest)).x;  // the second root is the inside's
  bool validRound = beyond ? tRound > tMin : tRound >= tMin;
  if (isCylinder) validRound = validRound && abs(origin.x + tRound * direction.x) <= 0.5;
  bool validPlane = insidePlane && direction.z > 0.0 && (beyond ? tPlane > tMin : tPlane >= tMin);
  t = isPlane ? tPlane : tRound;
  if (isPlane) {
    u = isRect ? p.x + 0.5 : p.x;
    v = isRect ? p.y + 0.5 : p.y;
  }
  return isPlane ? validPlane : validRound;
}

#endif
