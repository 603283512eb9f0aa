// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Uniform sampling of the solid angle of a rectangle: Urena, Fajardo, King, "An Area-Preserving Parametrization for
// Spherical Rectangles" (EGSR 2013). For rect lights whose transform keeps the edges perpendicular; others, and
// rectangles too small or too near for float, are sampled by area.
#ifndef WAVEFRONT_LIGHTS_RECT_GLSL
#define WAVEFRONT_LIGHTS_RECT_GLSL
#include "lib/lights/record.glsl"

// Below, rounding of the angles' sum shows (and sampling by area is as good); near 2 pi the point lies in the plane.
const float kMinRectSolidAngle = 5e-3;
const float kMaxRectSolidAngle = 6.283;

// acos of x where sin^2 is known precisely: Abramowitz and Stegun 4.4.46, 2e-8 off. GLSL's own acos may be off by 4096
// units in the last place.
float acosWithSin2(float x, float sin2) {
  float a = abs(x);
  float p = 1.5707963050 + a * (-0.2145988016 + a * (0.0889789874 + a * (-0.0501743046 + a * (0.0308918810 +
            a * (-0.0170881256 + a * (0.0066700901 - a * 0.0012624911))))));
  float r = sqrt(sin2 / (1.0 + a)) * p;
  return x < 0.0 ? 3.14159265359 - r : r;
}

struct SphericalRect {
  vec3 x, y, z;              // local frame, world space; z points away from the rectangle
  float x0, x1, y0, y1, z0;  // corners in it, as seen from the shaded point; z0 < 0
  float b0, b1, k;
  float solidAngle;          // 0: sample by area
};

SphericalRect sphericalRect(Light l, vec3 p) {
  SphericalRect r;
  vec3 c0 = lightColumn(l, 0), c1 = lightColumn(l, 1);
  float width = length(c0), height = length(c1);
  r.x = c0 / width;
  r.y = c1 / height;
  r.z = cross(r.x, r.y);
  vec3 d = lightPoint(l, vec3(-0.5, -0.5, 0.0)) - p;
  r.z0 = dot(d, r.z);
  if (r.z0 > 0.0) { r.z = -r.z; r.z0 = -r.z0; }
  r.x0 = dot(d, r.x); r.x1 = r.x0 + width;
  r.y0 = dot(d, r.y); r.y1 = r.y0 + height;
  // z components of the normals of the planes through the edges, and their squared rests.
  vec4 e = vec4(-r.y0, r.x1, r.y1, -r.x0);
  float zz = r.z0 * r.z0;
  vec4 inverseLength2 = 1.0 / (vec4(zz) + e * e);
  vec4 n = e * sqrt(inverseLength2);
  vec4 rest = zz * inverseLength2;
  vec4 c = -n * n.yzwx;
  vec4 sin2 = rest + rest.yzwx - rest * rest.yzwx;
  vec4 g = vec4(acosWithSin2(c.x, sin2.x), acosWithSin2(c.y, sin2.y), acosWithSin2(c.z, sin2.z), acosWithSin2(c.w, sin2.w));
  r.b0 = n.x;
  r.b1 = n.z;
  r.k = 6.28318530718 - g.z - g.w;
  r.solidAngle = (g.x - 3.14159265359 + g.y) + (g.z - 3.14159265359 + g.w);
  if (!(zz > 0.0) || !(r.solidAngle > kMinRectSolidAngle && r.solidAngle < kMaxRectSolidAngle)) r.solidAngle = 0.0;
  return r;
}

// From the shaded point to a point of the rectangle, in the local frame.
vec3 sampleSphericalRect(SphericalRect r, vec2 u) {
  float a = u.x * r.solidAngle + r.k - 3.14159265359;  // shifted by pi: sine and cosine are precise in [-pi, pi] only
  float s = -sin(a);
  float fu = (-cos(a) * r.b0 - r.b1) / (abs(s) > 1e-9 ? s : 1e-9);
  float cu = (fu > 0.0 ? 1.0 : -1.0) * inversesqrt(fu * fu + r.b0 * r.b0);
  cu = clamp(cu, -1.0, 1.0);
  float x = clamp(-(cu * r.z0) / sqrt(max(1e-12, 1.0 - cu * cu)), r.x0, r.x1);
  float d2 = x * x + r.z0 * r.z0;
  float h0 = r.y0 * inversesqrt(d2 + r.y0 * r.y0);
  float h1 = r.y1 * inversesqrt(d2 + r.y1 * r.y1);
  float h = h0 + u.y * (h1 - h0);
  float y = clamp(h * sqrt(d2 / max(1e-12, 1.0 - h * h)), r.y0, r.y1);
  return vec3(x, y, r.z0);
}
#endif
