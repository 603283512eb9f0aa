#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Turns bucket counts into offsets and indirect arguments, closes the queues that logic fills, and hands out new work.
// One workgroup.
// Reads: bucket counts of the parts of the pool. Writes: counts, offsets, arguments, statistics, the work position. Runs after: logic.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "shared/counters_layout.h"
#include "lib/queue.glsl"

const uint kThreads = 256u;
layout(local_size_x = 256) in;
shared uint partial[kThreads];

void add64(uint at, uint value) {
  uint old = counters[at];
  counters[at] = old + value;
  if (old + value < old) counters[at + 1u] += 1u;
}

void main() {
  uint thread = gl_LocalInvocationID.x;
  if (thread == 0u) {
    [[dont_unroll]] for (uint q = kQueueLightSample; q < kQueueKinds; ++q) closeQueue(q);
  }
  uint perThread = (frame.bucketCount + kThreads - 1u) / kThreads;
  uint first = thread * perThread;
  uint last = min(first + perThread, frame.bucketCount);
  uint sum = 0u;
  for (uint b = first; b < last; ++b) {
    for (uint part = 0u; part < kPoolParts; ++part) sum += counters[partCount(part, b)];
  }
  partial[thread] = sum;
  barrier();
  for (uint step = 1u; step < kThreads; step <<= 1) {
    uint add = thread >= step ? partial[thread - step] : 0u;
    barrier();
    partial[thread] += add;
    barrier();
  }
  uint offset = partial[thread] - sum;
  for (uint b = first; b < last; ++b) {
    uint at = kBucketBase + b * kBucketStride;
    uint count = 0u;
    for (uint part = 0u; part < kPoolParts; ++part) {
      uint inPart = counters[partCount(part, b)];
      counters[partCount(part, b)] = offset + count;  // where scatter begins
      count += inPart;
    }
    counters[at + kBucketCount] = count;
    counters[at + kBucketOffset] = offset;
    uint run = count;
    if (b == kBucketNewPath) {
      // Work is ordered sample-major: the next `run` (sample, pixel) pairs go to the idle paths.
      uint pixels = frame.width * frame.bandHeight;
      uint sampleIndex = counters[kWorkSample], pixel = counters[kWorkPixel], left = workLeft();
      run = min(count, left);
      counters[kNewPathBaseSample] = sampleIndex;
      counters[kNewPathBasePixel] = pixel;
      counters[kNewPathCount] = run;
      uint next = pixel + run;
      counters[kWorkSample] = sampleIndex + next / pixels;
      counters[kWorkPixel] = next % pixels;
      counters[kActivePaths] = frame.poolSize - count + run;
      counters[kIterations] += 1u;
      if (count == frame.poolSize && left == 0u && counters[kQueueBase + kQueueEscape * kQueueStride + kQueueCount] == 0u) {
        // All idle, nobody escaping any more, and no work left: the iterations already submitted behind this one cost
        // nothing. Queues and buckets are empty, so what still runs finds nothing to do.
        counters[kPoolArgs] = 0u;
        counters[kScanArgs] = 0u;
      }
      add64(kPathsDoneLo, run);
    }
    counters[at + kBucketArgs] = (run + 63u) / 64u;
    counters[at + kBucketArgs + 1u] = 1u;
    counters[at + kBucketArgs + 2u] = 1u;
    add64(at + kBucketItemsLo, run);
    counters[at + kBucketPeak] = max(counters[at + kBucketPeak], run);
    offset += count;
  }
}
