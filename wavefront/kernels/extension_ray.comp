#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Extension ray cast: the nearest hit of each ray in the queue.
// Reads: RayOrigin, RayDirection, Hit. Writes: Hit, HitDistance. Runs after: new_path and the materials.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/traversal_hooks.glsl"
#include "lib/traverse.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueExtensionRay, path)) return;
  vec4 o = uintBitsToFloat(loadPath(kChunkRayOrigin, path));
  vec4 d = uintBitsToFloat(loadPath(kChunkRayDirection, path));
  uvec2 last = uvec2(loadPathWord(kChunkHit, path, 0u), loadPathWord(kChunkHit, path, 1u));
  Hit hit;
  hit.t = d.w; hit.instance = 0xffffffffu; hit.triangle = 0u; hit.u = 0.0; hit.v = 0.0;
  if (frame.hasGeometry != 0u) traverseClosest(Ray(o.xyz, o.w, d.xyz, d.w), (last.y & kHitCamera) != 0u ? 1u : 2u, last.x, last.y & ~kHitCamera, hit);
  storePath(kChunkHit, path, uvec4(hit.instance, hit.triangle, floatBitsToUint(hit.u), floatBitsToUint(hit.v)));
  storePathWord(kChunkHitDistance, path, 0u, floatBitsToUint(hit.t));
}
