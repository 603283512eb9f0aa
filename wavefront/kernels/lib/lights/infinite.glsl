// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Distant and dome lights. The dome's importance map: width, height, then height + 1 marginal CDF values, then per row
// width + 1 conditional CDF values, all floats in the light distribution stream from `distribution`.
#ifndef WAVEFRONT_LIGHTS_INFINITE_GLSL
#define WAVEFRONT_LIGHTS_INFINITE_GLSL
#include "lib/lights/record.glsl"
#include "lib/lights/distribution.glsl"
#include "lib/lights/emission.glsl"
#include "lib/lights/shapes.glsl"

float domePdf(Light l, vec3 wi) {
  if (!kHasTexturedLights || l.distribution == kNoStream) return 0.07957747154594767;  // 1 / 4 pi
  vec2 uv = domeUv(normalize(toLightSpace(l, wi)));
  uint width = uint(distributionAt(l.distribution)), height = uint(distributionAt(l.distribution + 1u));
  uint x = min(uint(uv.x * float(width)), width - 1u);
  uint y = min(uint(uv.y * float(height)), height - 1u);
  uint marginal = l.distribution + 2u;
  uint row = marginal + height + 1u + y * (width + 1u);
  float p = (distributionAt(marginal + y + 1u) - distributionAt(marginal + y)) * (distributionAt(row + x + 1u) - distributionAt(row + x));
  float sinTheta = sin((1.0 - uv.y) * kPi);
  return sinTheta > 0.0 ? p * float(width * height) / (2.0 * kPi * kPi * sinTheta) : 0.0;
}

LightSample sampleDome(Light l, vec2 u) {
  LightSample s;
  s.distance = 1e30;
  s.unitPoint = vec3(0.0);
  vec3 d;
  if (!kHasTexturedLights || l.distribution == kNoStream) {
    float z = 1.0 - 2.0 * u.x;
    float r = sqrt(max(0.0, 1.0 - z * z));
    d = vec3(r * cos(6.28318530718 * u.y), z, r * sin(6.28318530718 * u.y));
  } else {
    uint width = uint(distributionAt(l.distribution)), height = uint(distributionAt(l.distribution + 1u));
    uint marginal = l.distribution + 2u;
    uint y = searchCdf(marginal, height, u.y);
    float y0 = distributionAt(marginal + y), y1 = distributionAt(marginal + y + 1u);
    uint row = marginal + height + 1u + y * (width + 1u);
    uint x = searchCdf(row, width, u.x);
    float x0 = distributionAt(row + x), x1 = distributionAt(row + x + 1u);
    vec2 uv = vec2((float(x) + (x1 > x0 ? (u.x - x0) / (x1 - x0) : 0.5)) / float(width),
                   (float(y) + (y1 > y0 ? (u.y - y0) / (y1 - y0) : 0.5)) / float(height));
    d = domeDirection(uv);
  }
  // Light space to world: rows w hold a dome's rotation only, whose transpose goes back.
  s.direction = normalize(d.x * l.w0.xyz + d.y * l.w1.xyz + d.z * l.w2.xyz);
  s.pdf = domePdf(l, s.direction);
  return s;
}

// Distant light: uniform in a cone about the direction it comes from (+Z of light space, taken to the world as a vector).
vec3 distantAxis(Light l) { return normalize(lightColumn(l, 2)); }
float distantPdf(Light l, vec3 wi) {
  // 1 - cos from the chord: stable for the sun's half degree.
  vec3 c = wi - distantAxis(l);
  float k = l.solidAngle * 0.15915494309;
  return 0.5 * dot(c, c) <= k * 1.0001 + 4e-7 * sqrt(k) ? 1.0 / l.solidAngle : 0.0;  // directions are rounded, too
}
LightSample sampleDistant(Light l, vec2 u) {
  LightSample s;
  vec3 z = distantAxis(l);
  vec3 x = abs(z.x) > 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
  x = normalize(x - z * dot(x, z));
  vec3 local = sampleCone(u, l.solidAngle * 0.15915494309);
  s.direction = normalize(x * local.x + cross(z, x) * local.y + z * local.z);
  s.distance = 1e30;
  s.unitPoint = vec3(0.0);
  s.pdf = 1.0 / l.solidAngle;
  return s;
}
#endif
