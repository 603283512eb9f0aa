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
  if (b < frame.bucketCount) counters[kBucketBase + b * kBucketStride + kBucketCount] = 0u;
  if (b < 2u) {
    uint q = kQueueBase + b * kQueueStride;
    uint count = counters[q + kQueueFill];
    counters[q + kQueueCount] = count;
    counters[q + kQueueFill] = 0u;
    counters[q + kQueueArgs] = (count + 63u) / 64u;
    counters[q + kQueueArgs + 1u] = 1u;
    counters[q + kQueueArgs + 2u] = 1u;
    uint old = counters[q + kQueueItemsLo];
    counters[q + kQueueItemsLo] = old + count;
    if (old + count < old) counters[q + kQueueItemsHi] += 1u;
    counters[q + kQueuePeak] = max(counters[q + kQueuePeak], count);
  }
}
