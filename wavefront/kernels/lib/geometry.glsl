// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// From a hit record to a ShadingPoint, and the readers of primvars and parameters that materials call.
#ifndef WAVEFRONT_LIB_GEOMETRY_GLSL
#define WAVEFRONT_LIB_GEOMETRY_GLSL
#include "lib/bindings.glsl"
#include "lib/frame.glsl"
#include "lib/shading_point.glsl"
#include "lib/records.glsl"

vec3 barycentricWeights(vec2 b) { return vec3(1.0 - b.x - b.y, b.x, b.y); }

// First float of the primvar element of each corner. Flat interpolations give the same element three times.
// x y z: element offsets; all elements are `components` floats from valueBase. Zero where there is no primvar.
uvec3 primvarElements(ShadingPoint sp, uvec4 descriptor) {
  uint interpolation = descriptor.z & 0xffu;
  uint components = descriptor.z >> 8;
  uvec4 mesh = texelFetch(meshRecords, int(sp.mesh));
  bool exists = descriptor.x != kNoStream;
  bool vertex = interpolation == kInterpVertex;
  bool uniformRate = interpolation == kInterpUniform;
  bool perCorner = vertex || interpolation == kInterpFaceVarying;
  uint stream = vertex ? mesh.x : (uniformRate ? mesh.y : descriptor.y);
  bool indexed = exists && stream != kNoStream && (perCorner || uniformRate);
  uvec3 at = perCorner ? 3u * sp.triangle + uvec3(0u, 1u, 2u) : uvec3(sp.triangle);
  ivec3 index = indexed ? ivec3(stream + at) : ivec3(0);
  uvec3 fetched = uvec3(texelFetch(indexStream, index.x).x, texelFetch(indexStream, index.y).x, texelFetch(indexStream, index.z).x);
  uvec3 element = indexed ? fetched : at;
  if (!perCorner && !uniformRate) element = uvec3(interpolation == kInterpInstance ? instanceWord(sp.instance, 7u).z : 0u);
  return exists ? descriptor.x + element * components : uvec3(0u);
}

uvec4 primvarDescriptor(ShadingPoint sp, uint slot) {
  return texelFetch(bindingRecords, int(sp.binding + kBindingHeaderTexels + slot));
}
bool primvarExists(ShadingPoint sp, uint slot) { return primvarDescriptor(sp, slot).x != kNoStream; }

// The readers fetch in any case, and choose afterwards: on software devices both sides of a branch are run anyway, and
// compiling takes longer with every branch and loop around a fetch (16 primvars: 3.4 s of CPU time, now 0.15).
float primvarFloat(ShadingPoint sp, uint slot, float fallback) {
  uvec4 descriptor = primvarDescriptor(sp, slot);
  uvec3 e = primvarElements(sp, descriptor);
  vec3 w = barycentricWeights(sp.barycentric);
  float value = w.x * texelFetch(primvarStream, int(e.x)).x + w.y * texelFetch(primvarStream, int(e.y)).x +
                w.z * texelFetch(primvarStream, int(e.z)).x;
  return descriptor.x == kNoStream ? fallback : value;
}
vec2 primvarElement2(uint at, uint components) {
  int second = components >= 2u ? 1 : 0;  // a float primvar read as a vector repeats
  return vec2(texelFetch(primvarStream, int(at)).x, texelFetch(primvarStream, int(at) + second).x);
}
vec2 primvarVec2(ShadingPoint sp, uint slot, vec2 fallback) {
  uvec4 descriptor = primvarDescriptor(sp, slot);
  uint components = descriptor.z >> 8;
  uvec3 e = primvarElements(sp, descriptor);
  vec3 w = barycentricWeights(sp.barycentric);
  vec2 value = w.x * primvarElement2(e.x, components) + w.y * primvarElement2(e.y, components) + w.z * primvarElement2(e.z, components);
  return descriptor.x == kNoStream ? fallback : value;
}
vec3 primvarElement3(uint at, uint components) {
  int last = components >= 3u ? 2 : 0;
  return vec3(primvarElement2(at, components), texelFetch(primvarStream, int(at) + last).x);
}
vec3 primvarVec3(ShadingPoint sp, uint slot, vec3 fallback) {
  uvec4 descriptor = primvarDescriptor(sp, slot);
  uint components = descriptor.z >> 8;
  uvec3 e = primvarElements(sp, descriptor);
  vec3 w = barycentricWeights(sp.barycentric);
  vec3 value = w.x * primvarElement3(e.x, components) + w.y * primvarElement3(e.y, components) + w.z * primvarElement3(e.z, components);
  if (components == 2u) value.z = 0.0;
  return descriptor.x == kNoStream ? fallback : value;
}
vec4 primvarVec4(ShadingPoint sp, uint slot, vec4 fallback) {
  uvec4 descriptor = primvarDescriptor(sp, slot);
  bool exists = descriptor.x != kNoStream, hasAlpha = exists && (descriptor.z >> 8) >= 4u;
  vec3 rgb = primvarVec3(sp, slot, fallback.xyz);
  ivec3 e = hasAlpha ? ivec3(primvarElements(sp, descriptor)) + 3 : ivec3(0);
  vec3 w = barycentricWeights(sp.barycentric);
  float alpha = w.x * texelFetch(primvarStream, e.x).x + w.y * texelFetch(primvarStream, e.y).x + w.z * texelFetch(primvarStream, e.z).x;
  return vec4(rgb, exists ? (hasAlpha ? alpha : 1.0) : fallback.w);
}

// Positions and texture coordinates of the triangle, for derivatives.
void primvarCorners(ShadingPoint sp, uint slot, out vec2 uv[3]) {
  uvec4 descriptor = primvarDescriptor(sp, slot);
  uv[0] = uv[1] = uv[2] = vec2(0.0);
  if (descriptor.x == kNoStream) return;
  uvec3 e = primvarElements(sp, descriptor);
  uint step = (descriptor.z >> 8) >= 2u ? 1u : 0u;
  uv[0] = vec2(texelFetch(primvarStream, int(e.x)).x, texelFetch(primvarStream, int(e.x + step)).x);
  uv[1] = vec2(texelFetch(primvarStream, int(e.y)).x, texelFetch(primvarStream, int(e.y + step)).x);
  uv[2] = vec2(texelFetch(primvarStream, int(e.z)).x, texelFetch(primvarStream, int(e.z + step)).x);
}

// The edges of the hit triangle in world space; kept in globals by shadingPointMake, so that they are fetched once.
vec3 gEdge1World, gEdge2World;
// Its corners in object space, for the bound of ray_offset.glsl.
vec3 gCorner0, gCorner1, gCorner2;

float primvarUvFootprint(ShadingPoint sp, uint slot) {
  vec2 uv[3];
  primvarCorners(sp, slot, uv);
  vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
  float uvArea = abs(a.x * b.y - a.y * b.x);
  float area = length(cross(gEdge1World, gEdge2World));
  return area > 0.0 ? sp.footprint * sqrt(uvArea / area) : 0.0;
}
void primvarTangents(ShadingPoint sp, uint slot, out vec3 tangentWorld, out vec3 bitangentWorld) {
  vec2 uv[3];
  primvarCorners(sp, slot, uv);
  vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
  float det = a.x * b.y - a.y * b.x;
  if (abs(det) > 1e-20) {
    vec3 t = (gEdge1World * b.y - gEdge2World * a.y) / det;
    vec3 bt = (gEdge2World * a.x - gEdge1World * b.x) / det;
    t -= sp.normalWorld * dot(t, sp.normalWorld);
    if (dot(t, t) > 1e-30) {
      tangentWorld = normalize(t);
      vec3 across = cross(sp.normalWorld, tangentWorld);
      bitangentWorld = dot(across, bt) < 0.0 ? -across : across;
      return;
    }
  }
  Frame f = frameFromNormal(sp.normalWorld);
  tangentWorld = f.x;
  bitangentWorld = f.y;
}

vec4 materialParameter(ShadingPoint sp, uint texel) { return texelFetch(materialParameters, int(sp.parameterBase + texel)); }

vec3 objectToWorldPoint(ShadingPoint sp, vec3 p) { return transformPoint(instanceRow(sp.instance, 4u), instanceRow(sp.instance, 5u), instanceRow(sp.instance, 6u), p); }
vec3 objectToWorldVector(ShadingPoint sp, vec3 v) { return transformVector(instanceRow(sp.instance, 4u), instanceRow(sp.instance, 5u), instanceRow(sp.instance, 6u), v); }
vec3 objectToWorldNormal(ShadingPoint sp, vec3 n) { return normalize(transformNormal(instanceRow(sp.instance, 0u), instanceRow(sp.instance, 1u), instanceRow(sp.instance, 2u), n)); }
vec3 worldToObjectPoint(ShadingPoint sp, vec3 p) { return transformPoint(instanceRow(sp.instance, 0u), instanceRow(sp.instance, 1u), instanceRow(sp.instance, 2u), p); }
vec3 worldToObjectVector(ShadingPoint sp, vec3 v) { return transformVector(instanceRow(sp.instance, 0u), instanceRow(sp.instance, 1u), instanceRow(sp.instance, 2u), v); }
vec3 worldToObjectNormal(ShadingPoint sp, vec3 n) { return normalize(transformNormal(instanceRow(sp.instance, 4u), instanceRow(sp.instance, 5u), instanceRow(sp.instance, 6u), n)); }

// Builds the shading point of a triangle hit. `triangleRecord` is absolute (leaf order). `coneWidth`: at the hit.
ShadingPoint shadingPointMake(uint instance, uint triangleRecord, vec2 barycentric, vec3 wo, float coneWidth, float time) {
  ShadingPoint sp;
  int texel = int(triangleRecord * kTriangleTexels);
  vec4 t0 = texelFetch(triangleRecords, texel);
  vec4 t1 = texelFetch(triangleRecords, texel + 1);
  vec4 t2 = texelFetch(triangleRecords, texel + 2);
  vec4 w0 = instanceRow(instance, 4u), w1 = instanceRow(instance, 5u), w2 = instanceRow(instance, 6u);
  vec4 o0 = instanceRow(instance, 0u), o1 = instanceRow(instance, 1u), o2 = instanceRow(instance, 2u);
  uvec4 ids = instanceWord(instance, 7u);

  sp.instance = instance;
  sp.triangle = floatBitsToUint(t0.w);
  sp.barycentric = barycentric;
  sp.mesh = ids.x * kMeshTexels;
  sp.wo = wo;
  sp.time = time;
  sp.exteriorIor = 1.0;
  sp.binding = texelFetch(indexStream, int(ids.y + floatBitsToUint(t1.w))).x;  // hitBinding, with what is here
  sp.parameterBase = texelFetch(bindingRecords, int(sp.binding)).w;

  gCorner0 = t0.xyz; gCorner1 = t1.xyz; gCorner2 = t2.xyz;
  vec3 e1 = t1.xyz - t0.xyz, e2 = t2.xyz - t0.xyz;
  sp.positionObject = t0.xyz + barycentric.x * e1 + barycentric.y * e2;
  sp.positionWorld = transformPoint(w0, w1, w2, sp.positionObject);
  gEdge1World = transformVector(w0, w1, w2, e1);
  gEdge2World = transformVector(w0, w1, w2, e2);
  vec3 ng = transformNormal(o0, o1, o2, cross(e1, e2));
  float ngLength = length(ng);
  sp.normalGeometric = ngLength > 0.0 ? ng / ngLength : wo;
  sp.normalWorld = sp.normalGeometric;
  sp.frontFacing = dot(sp.normalGeometric, wo) >= 0.0;

  uvec4 normals = texelFetch(meshRecords, int(sp.mesh + 1u));
  if (normals.x != kNoStream) {
    uvec3 e = primvarElements(sp, normals);
    vec3 w = barycentricWeights(barycentric);
    vec3 n = w.x * primvarElement3(e.x, 3u) + w.y * primvarElement3(e.y, 3u) + w.z * primvarElement3(e.z, 3u);
    n = transformNormal(o0, o1, o2, n);
    float l2 = dot(n, n);
    // Normals against the winding (smoothed over a fold, or simply wrong in the file) would leave no direction on which
    // both normals agree, and a black surface: the winding says where outside is.
    if (l2 > 0.0) sp.normalWorld = n * (dot(n, sp.normalGeometric) < 0.0 ? -inversesqrt(l2) : inversesqrt(l2));
  }
  float cosine = max(abs(dot(sp.normalGeometric, wo)), 0.1);  // a grazing footprint is long; do not blur without bound
  sp.footprint = coneWidth / sqrt(cosine);
  return sp;
}
#endif
