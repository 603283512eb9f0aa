#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Zeroes the bucket counts for the next iteration and turns the ray queues' fill into arguments. One invocation per bucket.
// Reads and writes: counters. Runs after: the material kernels, before the ray casts.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/queue.glsl"
layout(local_size_x = 64) in;

void main() {
  uint b = gl_GlobalInvocationID.x;
  if (b < frame.bucketCount) {
    for (uint part = 0u; part < kPoolParts; ++part) counters[partCount(part, b)] = 0u;
  }
  if (b == 0u) closeQueue(kQueueExtensionRay);
  if (b == 1u) closeQueue(kQueueShadowRay);
}
