#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Rays through one mesh, apart from any render: what the benchmark compares with other ray casters (ray_caster.h).
// Bindings of its own (scheduler/ray_caster.cpp). Reads: rays. Writes: hits. Runs alone.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 64) in;
layout(binding = 0) uniform utextureBuffer bvhNodes;
layout(binding = 1) uniform utextureBuffer bvhWords;
layout(binding = 2) uniform textureBuffer triangleRecords;
layout(binding = 3) uniform utextureBuffer instanceRecords;
layout(binding = 4) uniform textureBuffer rays;  // origin, tMin; direction, tMax
layout(binding = 5, std430) buffer HitsBlock { uvec2 hits[]; };  // t, triangle record
layout(push_constant) uniform PushConstants { uint rayCount; };
#include "lib/traverse.glsl"

bool overflow = false;
void reportTraversalOverflow() { overflow = true; }
bool isTriangleOpaque(uint instance, uint slot) { return true; }

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= rayCount) return;
  vec4 o = texelFetch(rays, int(2u * i));
  vec4 d = texelFetch(rays, int(2u * i + 1u));
  Hit hit = noHit(d.w);
  bool found = traverseClosest(Ray(o.xyz, o.w, d.xyz, d.w), 1u, kNoHit, kNoHit, hit);
  hits[i] = uvec2(overflow ? 0x7fc00000u : floatBitsToUint(hit.t), found ? hit.triangle : kNoHit);
}
