// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Where a ray starts that leaves a surface: so far in front of it that rounding cannot put it behind, and no farther.
//
// The hit point is computed from the barycentrics in object space and taken to the world (R p + r); the next ray goes
// back to object space (W o + w) and is tested there. With eps = 2^-24, m the largest |coordinate| of the triangle's
// vertices per axis, L its extent per axis, all |.| taken element by element, the errors off the surface are:
//   interpolation                         6 eps m        object space (three products, two sums, weights' sum)
//   the test of this or a like neighbour  8 eps L        object space (see traverse.glsl)
//   next ray to object space, W rounded   5 eps (|W| |p| + |w|)    object space
//   R p + r, R rounded                    5 eps (|R| m + |r|)      world
//   rounding of the origin itself           eps |p|                world
// Together E = eps ( |R| (11 m + 8 L + 5 (|W| |p| + |w|)) + 5 |r| + |p| ), a first-order bound with its factors
// rounded up, per world axis. It scales with the scene: 1e-4 units need no more care than 1e5. The origin moves by
// dot(E, |n|) along the geometric normal (Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., 6.8.6)
// and at least one float further on each axis, by stepping its bits as in Waechter and Binder, "A Fast and Robust
// Method for Avoiding Self-Intersection", Ray Tracing Gems (2019), chapter 6; their fixed distances (256 floats, 1/65536)
// would leak in small scenes and know nothing of transforms.
// The triangle itself is excluded by name as well (skipInstance, skipTriangle of traverse.glsl).
#ifndef WAVEFRONT_LIB_RAY_OFFSET_GLSL
#define WAVEFRONT_LIB_RAY_OFFSET_GLSL
#include "shared/scene_layout.h"
#include "lib/ray.glsl"
#include "lib/bvh_fetch.glsl"

// The bound E at pWorld on a triangle of the instance with vertices v0, v1, v2 in object space.
vec3 surfacePointError(uint instance, vec3 v0, vec3 v1, vec3 v2, vec3 pWorld) {
  const float eps = 5.9604644775390625e-8;
  uint texel = instance * kInstanceTexels;
  vec3 m = max(abs(v0), max(abs(v1), abs(v2)));
  vec3 extent = max(v0, max(v1, v2)) - min(v0, min(v1, v2));
  vec4 p = vec4(abs(pWorld), 1.0);
  vec3 back = vec3(dot(abs(fetchInstanceF(texel)), p), dot(abs(fetchInstanceF(texel + 1u)), p),
                   dot(abs(fetchInstanceF(texel + 2u)), p));
  // The test's error has no axis of its own: the largest extent counts everywhere.
  vec3 object = 11.0 * m + 8.0 * max(extent.x, max(extent.y, extent.z)) + 5.0 * back;
  vec4 scaled = vec4(object, 5.0);
  vec3 world = vec3(dot(abs(fetchInstanceF(texel + 4u)), scaled), dot(abs(fetchInstanceF(texel + 5u)), scaled),
                    dot(abs(fetchInstanceF(texel + 6u)), scaled));
  return eps * (world + p.xyz);
}

// The next float from x in the direction of `towards` (unchanged where that is 0).
float stepFloat(float x, float towards) {
  int bits = floatBitsToInt(x);
  bool away = (towards > 0.0) == (x >= 0.0);
  float next = x == 0.0 ? (towards > 0.0 ? 1.17549435e-38 : -1.17549435e-38) : intBitsToFloat(bits + (away ? 1 : -1));
  return towards == 0.0 ? x : next;
}

// A start for a ray from pWorld in `direction`, on the side of the geometric normal (unit, either sign) that the
// direction points to: reflection stays in front, transmission starts behind.
vec3 offsetRayOrigin(vec3 pWorld, vec3 error, vec3 normalGeometric, vec3 direction) {
  vec3 n = dot(normalGeometric, direction) < 0.0 ? -normalGeometric : normalGeometric;
  vec3 p = pWorld + dot(error, abs(n)) * n;
  return vec3(stepFloat(p.x, n.x), stepFloat(p.y, n.y), stepFloat(p.z, n.z));
}

// A shadow ray from one surface point to a point on another surface (an emissive triangle); t = 1 is the target, moved
// off its surface towards the start. A target that is no surface in the BVH's eyes (analytic light) has error 0.
Ray spawnRayTo(vec3 from, vec3 fromError, vec3 fromNormal, vec3 to, vec3 toError, vec3 toNormal) {
  vec3 start = offsetRayOrigin(from, fromError, fromNormal, to - from);
  vec3 end = any(greaterThan(toError, vec3(0.0))) ? offsetRayOrigin(to, toError, toNormal, from - to) : to;
  return Ray(start, 0.0, end - start, 1.0);
}

#endif
