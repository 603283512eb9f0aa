#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Subsurface walk kernel: a step of a random walk below a surface. The ray ended after a free flight and scatters, or it
// met another body than the one that it entered, which is passed. No light samples: the surface would block them.
// Reads: Ids, RayOrigin, RayDirection, Hit, HitDistance, Throughput, Medium, Walk. Writes: those of the next segment.
// Pushes to: extension rays. Runs after: scan_buckets.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/medium_walk.glsl"

layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueSubsurfaceWalk, path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  vec3 throughput = uintBitsToFloat(loadPath(kChunkThroughput, path)).rgb;
  uvec4 medium = loadPath(kChunkMedium, path);
  uvec4 hit = loadPath(kChunkHit, path);
  uint t = loadPathWord(kChunkHitDistance, path, 0u);
  uint before = loadPathWord(kChunkWalk, path, 0u), bounce = pathBounce(ids.w);
  vec2 flight = sample2D(ids.z, ids.y, mediumPair(bounce, kMediumWalkEvents + before + 1u, kMediumFlight));
  vec3 direction;
  vec3 p = mediumPoint(path, direction);
  uint event = mediumEvent(path, ids, throughput, before, flight.y);
  if (event == 0u) return;

  bool passes = hit.x != 0xffffffffu;
  storePathWord(kChunkWalk, path, 0u, event);
  storePathF(kChunkThroughput, path, vec4(throughput, 1.0));
  if (passes) {
    // The same flight, from behind that body.
    storePathWord(kChunkRayOrigin, path, 3u, t);
  } else {
    vec3 wi = phaseSample(mediumAnisotropy(medium), direction, sample2D(ids.z, ids.y, mediumPair(bounce, kMediumWalkEvents + event, kMediumDirection)));
    storePathF(kChunkRayOrigin, path, vec4(p, 0.0));
    storePathF(kChunkRayDirection, path, vec4(wi, mediumFlight(medium, throughput, flight.x)));
  }
  pushExtensionRay(path);
}
