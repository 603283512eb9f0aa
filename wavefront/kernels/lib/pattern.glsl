// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What generated materials call besides the readers of geometry.glsl and textures.glsl: pattern nodes that are ours,
// frames of closures, and the weighting of lobes. After lib/frame_values.glsl or what stands for it.
#ifndef WAVEFRONT_LIB_PATTERN_GLSL
#define WAVEFRONT_LIB_PATTERN_GLSL
#include "lib/frame.glsl"
#include "lib/geometry.glsl"
#include "lib/shading_point.glsl"
#include "lib/textures.glsl"

// The shading normal on the same side of wo as the geometry: lobes take the sign of wo.z for inside and outside, and a
// mapped normal may bend past the horizon.
vec3 patternNormal(ShadingPoint sp, vec3 n) {
  float side = sp.frontFacing ? 1.0 : -1.0;
  float l2 = dot(n, n);
  n = l2 > 0.0 ? n * inversesqrt(l2) : sp.normalWorld;
  float cosine = side * dot(n, sp.wo);
  return cosine < 0.01 ? normalize(n + sp.wo * (side * (0.01 - cosine))) : n;
}
Frame patternFrame(ShadingPoint sp, vec3 n) { return frameFromNormal(patternNormal(sp, n)); }
Frame patternFrameTangent(ShadingPoint sp, vec3 n, vec3 t) { return frameFromNormalTangent(patternNormal(sp, n), t); }

// Texture coordinates of the hit, and how they run over the triangle; all that textures and normal maps ask of one
// primvar, fetched once (compile time on lavapipe is made of fetch sites).
struct PatternUv {
  vec2 uv;
  vec2 along1, along2;  // change along the edges p1 - p0 and p2 - p0
  float footprint;      // width of the ray cone, in units of uv
};
PatternUv patternUv(ShadingPoint sp, uint slot, vec2 fallback) {
  uvec4 descriptor = primvarDescriptor(sp, slot);
  uint components = descriptor.z >> 8;
  uvec3 e = primvarElements(sp, descriptor);
  vec2 uv0 = primvarElement2(e.x, components), uv1 = primvarElement2(e.y, components), uv2 = primvarElement2(e.z, components);
  vec3 w = barycentricWeights(sp.barycentric);
  bool exists = descriptor.x != kNoStream;
  PatternUv result = PatternUv(exists ? w.x * uv0 + w.y * uv1 + w.z * uv2 : fallback, uv1 - uv0, uv2 - uv0, 0.0);
  float uvArea = abs(result.along1.x * result.along2.y - result.along1.y * result.along2.x);
  float area = length(cross(gEdge1World, gEdge2World));
  result.footprint = area > 0.0 ? sp.footprint * sqrt(uvArea / area) : 0.0;
  return result;
}

// dP/du orthogonal to the shading normal, dP/dv across it: x and y of the frame are unit; an arbitrary frame where the
// coordinates are degenerate.
Frame patternUvFrame(ShadingPoint sp, PatternUv u) {
  Frame frame = frameFromNormal(sp.normalWorld);
  float det = u.along1.x * u.along2.y - u.along1.y * u.along2.x;
  if (abs(det) > 1e-20) {
    vec3 t = (gEdge1World * u.along2.y - gEdge2World * u.along1.y) / det;
    vec3 b = (gEdge2World * u.along1.x - gEdge1World * u.along2.x) / det;
    t -= sp.normalWorld * dot(t, sp.normalWorld);
    if (dot(t, t) > 1e-30) {
      frame.x = normalize(t);
      vec3 across = cross(sp.normalWorld, frame.x);
      frame.y = dot(across, b) < 0.0 ? -across : across;
    }
  }
  return frame;
}

vec3 patternWorldPosition(ShadingPoint sp) { return sp.positionWorld + sceneOrigin(); }

// Derivatives over the surface: values at the hit are compared with those a step further along an edge (1 or 2) of the
// triangle. A step is as wide as the ray cone, but at least a thousandth of the edge, so that rounding does not show.
float patternStep(ShadingPoint sp, uint edge) {
  float whole = length(edge == 1u ? gEdge1World : gEdge2World);
  return whole > 0.0 ? clamp(sp.footprint / whole, 1e-3, 0.25) : 1e-3;
}
vec2 patternUvMoved(ShadingPoint sp, PatternUv u, uint edge) {
  return u.uv + patternStep(sp, edge) * (edge == 1u ? u.along1 : u.along2);
}
vec3 patternWorldMoved(ShadingPoint sp, uint edge) {
  return patternWorldPosition(sp) + patternStep(sp, edge) * (edge == 1u ? gEdge1World : gEdge2World);
}
vec3 patternObjectMoved(ShadingPoint sp, uint edge) {
  return sp.positionObject + patternStep(sp, edge) * ((edge == 1u ? gCorner1 : gCorner2) - gCorner0);
}
ShadingPoint patternMoved(ShadingPoint sp, uint edge) {
  float amount = patternStep(sp, edge);
  sp.barycentric += edge == 1u ? vec2(amount, 0.0) : vec2(0.0, amount);
  return sp;
}
float patternObjectFootprint(ShadingPoint sp) {
  float world = length(gEdge1World);
  return world > 0.0 ? sp.footprint * length(gCorner1 - gCorner0) / world : 0.0;
}

// MaterialX heighttonormal: the normal of the surface (u, v, scale / 16 * height), encoded from 0 to 1. Heights and
// texture coordinates at the hit and at two steps from it.
vec3 patternHeightToNormal(float h, float h1, float h2, vec2 uv, vec2 uv1, vec2 uv2, float scale) {
  vec2 along1 = uv1 - uv, along2 = uv2 - uv;
  vec2 rise = vec2(h1 - h, h2 - h) * (scale * (1.0 / 16.0));
  vec3 n = cross(vec3(along1, rise.x), vec3(along2, rise.y));
  float l2 = dot(n, n);
  if (l2 <= 1e-30) n = vec3(0.0, 0.0, 1.0);
  return normalize(n.z < 0.0 ? -n : n) * 0.5 + 0.5;
}

// 0 below the edge and 1 above it, over a width of one footprint on either side.
float patternSoftStep(float edge, float value, float footprint) {
  float width = max(footprint, 1e-6);
  return smoothstep(edge - width, edge + width, value);
}

// A normal in tangent space, components from -1 to 1.
vec3 patternNormalMap(vec3 value, vec2 scale, vec3 n, vec3 t, vec3 b) {
  vec3 result = t * (value.x * scale.x) + b * (value.y * scale.y) + n * value.z;
  float l2 = dot(result, result);
  return l2 > 1e-12 ? result * inversesqrt(l2) : n;
}

// Images by their filter: linear, closest or cubic.
vec4 patternImage(uint wrapU, uint wrapV, uint textureId, vec2 uv, float footprint, vec4 outside, vec4 fallback) {
  return textureExists(textureId) ? textureRead(textureId, uv, footprint, wrapU, wrapV, outside) : fallback;
}

vec4 patternImageClosest(uint wrapU, uint wrapV, uint textureId, vec2 uv, float footprint, vec4 outside, vec4 fallback) {
  return textureExists(textureId) ? textureReadClosest(textureId, uv, footprint, wrapU, wrapV, outside) : fallback;
}
vec4 patternImageCubic(uint wrapU, uint wrapV, uint textureId, vec2 uv, float footprint, vec4 outside, vec4 fallback) {
  return textureExists(textureId) ? textureReadCubic(textureId, uv, footprint, wrapU, wrapV, outside) : fallback;
}

// A set of UDIM tiles, which end at their borders.
vec4 patternTiles(uint setId, vec2 uv, float footprint, vec4 fallback) {
  uint textureId = textureTile(setId, uv);
  return patternImage(kWrapClamp, kWrapClamp, textureId, uv, footprint, fallback, fallback);
}
vec4 patternTilesClosest(uint setId, vec2 uv, float footprint, vec4 fallback) {
  uint textureId = textureTile(setId, uv);
  return patternImageClosest(kWrapClamp, kWrapClamp, textureId, uv, footprint, fallback, fallback);
}
vec4 patternTilesCubic(uint setId, vec2 uv, float footprint, vec4 fallback) {
  uint textureId = textureTile(setId, uv);
  return patternImageCubic(kWrapClamp, kWrapClamp, textureId, uv, footprint, fallback, fallback);
}

float patternMaximumAbs(float v) { return abs(v); }
float patternMaximumAbs(vec2 v) { return max(abs(v.x), abs(v.y)); }
float patternMaximumAbs(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }
float patternMaximumAbs(vec4 v) { return max(patternMaximumAbs(v.xy), patternMaximumAbs(v.zw)); }

// MaterialX rotate2d; degrees.
vec2 patternRotate2d(vec2 v, float amount) {
  float angle = radians(amount);
  float s = sin(angle), c = cos(angle);
  return vec2(c * v.x + s * v.y, c * v.y - s * v.x);
}

// MaterialX roughness_anisotropy: GGX alpha along and across the tangent.
vec2 patternRoughnessAnisotropy(float roughness, float anisotropy) {
  float alpha = clamp(roughness * roughness, 1e-6, 1.0);
  float aspect = sqrt(1.0 - clamp(anisotropy, 0.0, 0.98));
  return vec2(min(alpha / aspect, 1.0), alpha * aspect);
}
vec2 patternIsotropicAlpha(float roughness) { return vec2(clamp(roughness * roughness, 1e-6, 1.0)); }

// Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", equations 4 to 9.
vec3 patternArtisticIor(vec3 reflectivity, vec3 edge) {
  vec3 r = clamp(reflectivity, 0.0, 0.99);
  vec3 root = sqrt(r);
  return mix((1.0 + root) / (1.0 - root), (1.0 - r) / (1.0 + r), edge);
}
vec3 patternArtisticExtinction(vec3 reflectivity, vec3 edge) {
  vec3 r = clamp(reflectivity, 0.0, 0.99);
  vec3 n = patternArtisticIor(reflectivity, edge);
  vec3 above = n + 1.0, below = n - 1.0;
  return sqrt(max((above * above * r - below * below) / (1.0 - r), 0.0));
}

// 0 at normal incidence, 1 at grazing.
float patternSchlick(vec3 n, float exponent, float unused, vec3 wo) {
  return pow(clamp(1.0 - abs(dot(n, wo)), 0.0, 1.0), exponent);
}
// MaterialX conical_edf: 1 within the inner angle, falling to 0 at the outer one; full angles, degrees.
float patternCone(vec3 n, float inner, float outer, vec3 wo) {
  float cosine = abs(dot(n, wo));
  float from = cos(radians(0.5 * max(inner, outer))), to = cos(radians(0.5 * min(inner, outer)));
  return from < to ? smoothstep(from, to, cosine) : float(cosine >= to);
}

// MaterialX measured_edf: the profile (delegate/photometric_profile.h) towards wo; 1 where there is none. Horizontal 0 is
// the tangent. Both sides emit alike, as they do without a profile.
float patternLightProfile(vec3 n, vec3 tangent, uint textureId, vec3 wo) {
  if (!textureExists(textureId)) return 1.0;
  vec3 w = toLocal(frameFromNormalTangent(dot(n, wo) < 0.0 ? -n : n, tangent), wo);
  // Texel centres stand at whole degrees around the normal and half degrees from it.
  vec2 texel = degrees(vec2(atan(w.y, w.x), 2.0 * acos(clamp(w.z, -1.0, 1.0)))) + 0.5;
  return textureRead(textureId, texel / vec2(360.0, 181.0), 0.0, kWrapRepeat, kWrapClamp, vec4(0.0)).r;
}

// What is negative, or no number, counts as 0.
float patternPositive(float x) { return x > 0.0 ? x : 0.0; }
vec3 patternPositive(vec3 x) { return mix(vec3(0.0), x, greaterThan(x, vec3(0.0))); }

// How likely a lobe is sampled, before normalising: by what it reflects, and a little by its weight, so that a lobe
// that reflects nothing towards this wo on average can still be sampled where it does.
float closureImportance(vec3 weight, vec3 albedo) {
  float reflected = dot(max(albedo, vec3(0.0)), vec3(0.2126, 0.7152, 0.0722));
  float possible = max(max(weight.x, weight.y), weight.z);
  return possible > 0.0 ? reflected + 0.02 * possible : 0.0;
}
#endif
