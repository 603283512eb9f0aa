// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The only place that knows where BVH nodes, triangle and instance records live: uniform texel buffers (bindings
// bvhNodes, bvhWords, triangleRecords, instanceRecords), the fastest on lavapipe and free of its 128 MiB limit. A variant for
// another device replaces this file and nothing else. Record layouts: shared/scene_layout.h.
#ifndef WAVEFRONT_LIB_BVH_FETCH_GLSL
#define WAVEFRONT_LIB_BVH_FETCH_GLSL

// Node index of the tree over instances; mesh trees stand at the node base in their instance records.
// The including kernel may define WAVEFRONT_TLAS_ROOT (traversal_hooks.glsl does); tests leave it at 0.
#ifndef WAVEFRONT_TLAS_ROOT
#define WAVEFRONT_TLAS_ROOT 0u
#endif
uint tlasRoot() { return WAVEFRONT_TLAS_ROOT; }

uvec4 fetchBvhNode(uint texel) { return texelFetch(bvhNodes, int(texel)); }
// One child reference: a word of the same buffer.
uint fetchBvhChild(uint node, uint place) {
  return texelFetch(bvhWords, int((node * kBvhNodeTexels + 1u) * 4u + place)).x;
}
vec4 fetchTriangle(uint texel) { return texelFetch(triangleRecords, int(texel)); }
uvec4 fetchInstanceU(uint texel) { return texelFetch(instanceRecords, int(texel)); }
vec4 fetchInstanceF(uint texel) { return uintBitsToFloat(texelFetch(instanceRecords, int(texel))); }

#endif
