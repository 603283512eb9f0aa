#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// As cast_rays, but counts what each ray fetches of the tree and of the triangles, in bytes: what a benchmark holds against the
// device's bandwidth. The fetches stand here in place of lib/bvh_fetch.glsl's; traversal itself is the same code.
// Reads: rays. Writes: hits, with counts in place of hits. Runs alone.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/scene_layout.h"
layout(local_size_x = 64) in;
layout(binding = 0) uniform utextureBuffer bvhNodes;
layout(binding = 1) uniform utextureBuffer bvhWords;
layout(binding = 2) uniform textureBuffer triangleRecords;
layout(binding = 3) uniform utextureBuffer instanceRecords;
layout(binding = 4) uniform textureBuffer rays;  // origin, tMin; direction, tMax
layout(binding = 5, std430) buffer HitsBlock { uvec2 hits[]; };  // bytes of nodes, of triangle records
layout(push_constant) uniform PushConstants { uint rayCount; };

uint nodeBytes = 0u;
uint triangleBytes = 0u;
#define WAVEFRONT_LIB_BVH_FETCH_GLSL
uint tlasRoot() { return 0u; }
uvec4 fetchBvhNode(uint texel) {
  nodeBytes += 16u;
  return texelFetch(bvhNodes, int(texel));
}
uint fetchBvhChild(uint node, uint place) {
  nodeBytes += 4u;
  return texelFetch(bvhWords, int((node * kBvhNodeTexels + 1u) * 4u + place)).x;
}
vec4 fetchTriangle(uint texel) {
  triangleBytes += 16u;
  return texelFetch(triangleRecords, int(texel));
}
uvec4 fetchInstanceU(uint texel) { return texelFetch(instanceRecords, int(texel)); }
vec4 fetchInstanceF(uint texel) { return uintBitsToFloat(texelFetch(instanceRecords, int(texel))); }
#include "lib/traverse.glsl"

void reportTraversalOverflow() {}
bool isTriangleOpaque(uint instance, uint slot) { return true; }

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= rayCount) return;
  vec4 o = texelFetch(rays, int(2u * i));
  vec4 d = texelFetch(rays, int(2u * i + 1u));
  Hit hit = noHit(d.w);
  traverseClosest(Ray(o.xyz, o.w, d.xyz, d.w), 1u, kNoHit, kNoHit, hit);
  hits[i] = uvec2(nodeBytes, triangleBytes);
}
