// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pushing path indices to the ray queues. A path stands in a queue at most once per iteration, so capacity = pool size.
#ifndef WAVEFRONT_LIB_QUEUE_GLSL
#define WAVEFRONT_LIB_QUEUE_GLSL
#include "lib/bindings.glsl"
#include "shared/counters_layout.h"

#define WAVEFRONT_QUEUE(Name, index, doc) const uint kQueue##Name = index;
#include "shared/queues.def"
#undef WAVEFRONT_QUEUE

void pushExtensionRay(uint path) {
  uint slot = atomicAdd(counters[kQueueBase + kQueueExtensionRay * kQueueStride + kQueueFill], 1u);
  queueItems[kItemsExtension * frame.poolSize + slot] = path;
}
void pushShadowRay(uint path) {
  uint slot = atomicAdd(counters[kQueueBase + kQueueShadowRay * kQueueStride + kQueueFill], 1u);
  queueItems[kItemsShadow * frame.poolSize + slot] = path;
}
void reportError(uint flag) { atomicOr(counters[kErrorFlags], flag); }

// The path of this invocation in a material kernel; false past the bucket's end.
bool bucketPath(out uint path) {
  uint bucket = kBucketBase + pushBucket * kBucketStride;
  if (gl_GlobalInvocationID.x >= counters[bucket + kBucketCount]) { path = 0u; return false; }
  path = queueItems[kItemsSorted * frame.poolSize + counters[bucket + kBucketOffset] + gl_GlobalInvocationID.x];
  return true;
}
#endif
