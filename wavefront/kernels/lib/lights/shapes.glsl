// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Sampling of the light shapes: a direction, its distance and its solid-angle pdf as seen from a point; and the same
// pdf for a direction that a ray found by itself (MIS). Both must agree: a test compares them by quadrature.
#ifndef WAVEFRONT_LIGHTS_SHAPES_GLSL
#define WAVEFRONT_LIGHTS_SHAPES_GLSL
#include "lib/features.glsl"
#include "lib/lights/record.glsl"
#include "lib/lights/emission.glsl"
#include "lib/lights/rect.glsl"
#include "lib/camera.glsl"

const float kPi = 3.14159265358979;

struct LightSample {
  vec3 direction;   // unit, from the shaded point to the light
  float distance;   // to the light; huge for distant and dome
  vec3 unitPoint;   // where on the unit shape
  float pdf;        // solid angle, without selection; 0: no sample
};

// Uniform direction in a cone about +z of which 1 - cos(half angle) is given (stable for tiny angles).
vec3 sampleCone(vec2 u, float oneMinusCos) {
  float h = u.x * oneMinusCos;      // 1 - cos theta
  float s = sqrt(max(0.0, h * (2.0 - h)));
  float phi = 6.28318530718 * u.y;
  return vec3(s * cos(phi), s * sin(phi), 1.0 - h);
}
float oneMinusCosFromSin2(float sin2) { return sin2 / (1.0 + sqrt(max(0.0, 1.0 - sin2))); }

// Spheres of uniform scale seen from outside: sin^2 of the half angle; 0 where that does not hold.
float sphereSin2(Light l, vec3 p) {
  if (!kHasSphereLights || l.type != kLightSphere || (l.flags & kLightFlagUniform) == 0u) return 0.0;
  vec3 d = lightPoint(l, vec3(0.0)) - p;
  vec3 c = lightColumn(l, 0);
  float s2 = dot(c, c) / dot(d, d);
  return s2 < 0.9999 ? s2 : 0.0;
}
// A point in the space of the unit shape.
vec3 unitSpacePoint(Light l, vec3 p) {
  vec3 c0 = lightColumn(l, 0), c1 = lightColumn(l, 1), c2 = lightColumn(l, 2);
  vec3 a = cross(c1, c2);
  vec3 d = p - lightPoint(l, vec3(0.0));
  return vec3(dot(a, d), dot(cross(c2, c0), d), dot(cross(c0, c1), d)) / dot(c0, a);
}
// Half angle of the cylinder's arc that faces a point at this distance from its axis; both in the unit shape's space, where
// what faces what is the same as in the world.
float cylinderArc(float distance) {
  float c = 1.0 / distance;
  return acosWithSin2(c, 1.0 - c * c);
}
// Area of the part of the unit shape that is sampled from p: what faces it. 0: p is inside.
float sampledUnitArea(Light l, vec3 p) {
  if (kHasRectLights && l.type == kLightRect) return 1.0;
  if (kHasDiskLights && l.type == kLightDisk) return kPi;
  if (!kHasSphereLights && !kHasCylinderLights) return 0.0;
  vec3 q = unitSpacePoint(l, p);
  bool sphere = kHasSphereLights && (!kHasCylinderLights || l.type == kLightSphere);
  float d = length(sphere ? q : vec3(0.0, q.yz));
  return d > 1.0 ? (sphere ? 6.28318530718 * ((d - 1.0) / d) : 2.0 * cylinderArc(d)) : 0.0;
}
vec3 unitNormal(uint type, vec3 unitPoint) {
  if (kHasSphereLights && type == kLightSphere) return unitPoint;
  if (kHasCylinderLights && type == kLightCylinder) return vec3(0.0, unitPoint.yz);
  return vec3(0.0, 0.0, -1.0);
}

// The point of the unit shape nearest to a (slightly rounded) hit point in its space.
vec3 lightShapePoint(uint kind, vec3 p) {
  if (kHasSphereLights && kind == kKindSphere) return normalize(p);
  if (kHasCylinderLights && kind == kKindCylinder) return vec3(p.x, normalize(p.yz));
  return vec3(p.xy, 0.0);
}

bool isSphericalRect(Light l) { return kHasRectLights && l.type == kLightRect && (l.flags & kLightFlagRectangular) != 0u; }

// Area pdf turned to solid angle for a point on the unit shape; 0 where its back is seen.
float shapePdf(Light l, vec3 p, vec3 unitPoint, vec3 wi, float distance) {
  vec3 area = lightAreaVector(l, unitNormal(l.type, unitPoint));
  float projected = -dot(area, wi) * sampledUnitArea(l, p);   // |stretch| * cos at the light * area
  return projected > 0.0 ? distance * distance / projected : 0.0;
}

LightSample sampleShape(Light l, vec3 p, vec2 u) {
  LightSample s;
  s.pdf = 0.0;
  float sin2 = sphereSin2(l, p);
  if (sin2 > 0.0) {
    vec3 toCentre = lightPoint(l, vec3(0.0)) - p;
    float d2 = dot(toCentre, toCentre);
    float d = sqrt(d2);
    vec3 z = toCentre / d;
    float k = oneMinusCosFromSin2(sin2);
    vec3 local = sampleCone(u, k);
    vec3 x = abs(z.x) > 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    x = normalize(x - z * dot(x, z));
    s.direction = normalize(x * local.x + cross(z, x) * local.y + z * local.z);
    // Distance to the sphere's near side along the direction.
    float r2 = sin2 * d2;
    float b = d * local.z;
    float sinT2 = max(0.0, 1.0 - local.z * local.z);
    s.distance = b - sqrt(max(0.0, r2 - d2 * sinT2));
    vec3 onSphere = s.direction * s.distance - toCentre;   // world, from the centre
    vec3 c0 = lightColumn(l, 0), c1 = lightColumn(l, 1), c2 = lightColumn(l, 2);
    s.unitPoint = vec3(dot(onSphere, c0), dot(onSphere, c1), dot(onSphere, c2)) / r2;
    s.pdf = 1.0 / (6.28318530718 * k);
    return s;
  }
  if (isSphericalRect(l)) {
    SphericalRect r = sphericalRect(l, p);
    if (r.solidAngle > 0.0) {
      vec3 q = sampleSphericalRect(r, u);
      s.distance = length(q);
      s.direction = (q.x * r.x + q.y * r.y + q.z * r.z) / s.distance;
      s.unitPoint = vec3((q.x - r.x0) / (r.x1 - r.x0) - 0.5, (q.y - r.y0) / (r.y1 - r.y0) - 0.5, 0.0);
      s.pdf = shapePdf(l, p, s.unitPoint, s.direction, s.distance) > 0.0 ? 1.0 / r.solidAngle : 0.0;
      return s;
    }
  }
  vec3 q = vec3(u.x - 0.5, u.y - 0.5, 0.0);
  if (kHasDiskLights && l.type == kLightDisk) {
    q = vec3(sampleDisk(u), 0.0);
  } else if (kHasSphereLights && l.type == kLightSphere) {
    // The cap that faces p.
    vec3 axis = unitSpacePoint(l, p);
    float far = length(axis);
    if (!(far > 1.0)) return s;
    axis /= far;
    vec3 x = abs(axis.z) > 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    x = normalize(x - axis * dot(x, axis));
    vec3 local = sampleCone(u, (far - 1.0) / far);
    q = x * local.x + cross(axis, x) * local.y + axis * local.z;
  } else if (kHasCylinderLights && l.type == kLightCylinder) {
    vec3 pUnit = unitSpacePoint(l, p);
    float far = length(pUnit.yz);
    if (!(far > 1.0)) return s;
    float phi = (2.0 * u.y - 1.0) * cylinderArc(far);
    vec2 axis = pUnit.yz / far;
    q = vec3(u.x - 0.5, cos(phi) * axis + sin(phi) * vec2(-axis.y, axis.x));
  }
  vec3 d = lightPoint(l, q) - p;
  float d2 = dot(d, d);
  if (!(d2 > 0.0)) return s;
  s.distance = sqrt(d2);
  s.direction = d / s.distance;
  s.unitPoint = q;
  s.pdf = shapePdf(l, p, q, s.direction, s.distance);
  return s;
}

// The pdf with which sampleShape would have found this hit.
float shapeHitPdf(Light l, vec3 p, vec3 wi, float distance, vec3 unitPoint) {
  float sin2 = sphereSin2(l, p);
  if (sin2 > 0.0) return dot(lightAreaVector(l, unitPoint), wi) < 0.0 ? 1.0 / (6.28318530718 * oneMinusCosFromSin2(sin2)) : 0.0;
  float pdf = shapePdf(l, p, unitPoint, wi, distance);
  if (isSphericalRect(l) && pdf > 0.0) {
    SphericalRect r = sphericalRect(l, p);
    if (r.solidAngle > 0.0) return 1.0 / r.solidAngle;
  }
  return pdf;
}
#endif
