// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Rays and what they hit.
#ifndef WAVEFRONT_LIB_RAY_GLSL
#define WAVEFRONT_LIB_RAY_GLSL

// Points origin + t * direction with tMin <= t <= tMax; the direction need not have length 1, t counts in its
// lengths in every space. tMin >= 0. A ray with a NaN, an infinity in origin or direction, or no direction hits
// nothing.
struct Ray {
  vec3 origin;
  float tMin;
  vec3 direction;
  float tMax;  // may be infinite
};

const uint kNoHit = 0xffffffffu;

// instance: index of the instance record, kNoHit if nothing was hit (t is then the ray's tMax).
// triangle: absolute index of the triangle record; 0 on light shapes.
// u, v: weights of the second and third vertex (p = (1 - u - v) v0 + u v1 + v v2); on a rect its own coordinates
// in [0, 1]^2; on a disk x and y in [-1, 1]; 0 on spheres and cylinders.
struct Hit {
  float t;
  uint instance;
  uint triangle;
  float u;
  float v;
};

Hit noHit(float tMax) { return Hit(tMax, kNoHit, 0u, 0.0, 0.0); }

#endif
