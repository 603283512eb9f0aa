// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Readers of instance and binding records.
#ifndef WAVEFRONT_LIB_RECORDS_GLSL
#define WAVEFRONT_LIB_RECORDS_GLSL
#include "lib/bindings.glsl"

vec4 instanceRow(uint instance, uint row) { return uintBitsToFloat(texelFetch(instanceRecords, int(instance * kInstanceTexels + row))); }
uvec4 instanceWord(uint instance, uint texel) { return texelFetch(instanceRecords, int(instance * kInstanceTexels + texel)); }

vec3 transformPoint(vec4 r0, vec4 r1, vec4 r2, vec3 p) { vec4 q = vec4(p, 1.0); return vec3(dot(r0, q), dot(r1, q), dot(r2, q)); }
vec3 transformVector(vec4 r0, vec4 r1, vec4 r2, vec3 v) { return vec3(dot(r0.xyz, v), dot(r1.xyz, v), dot(r2.xyz, v)); }
// Multiplies by the transpose: a normal goes to world space by the transpose of world-to-object.
vec3 transformNormal(vec4 r0, vec4 r1, vec4 r2, vec3 n) { return n.x * r0.xyz + n.y * r1.xyz + n.z * r2.xyz; }

// First texel of the binding record of a triangle (absolute record) of an instance.
uint hitBinding(uint instance, uint triangleRecord) {
  uint slot = floatBitsToUint(texelFetch(triangleRecords, int(triangleRecord * kTriangleTexels + 1u)).w);
  return texelFetch(indexStream, int(instanceWord(instance, 7u).y + slot)).x;
}
// Surface, opacity and emission bucket, and the parameter base.
uvec4 hitBuckets(uint instance, uint triangleRecord) { return texelFetch(bindingRecords, int(hitBinding(instance, triangleRecord))); }
#endif
