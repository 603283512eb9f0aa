// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pushing path indices to the queues. A path stands in a queue at most once per iteration, so capacity = pool size.
#ifndef WAVEFRONT_LIB_QUEUE_GLSL
#define WAVEFRONT_LIB_QUEUE_GLSL
#extension GL_KHR_shader_subgroup_ballot : require
#include "lib/bindings.glsl"
#include "shared/counters_layout.h"

#define WAVEFRONT_QUEUE(Name, index, doc) const uint kQueue##Name = index;
#include "shared/queues.def"
#undef WAVEFRONT_QUEUE
const uint kQueueKinds = 0u
#define WAVEFRONT_QUEUE(Name, index, doc) + 1u
#include "shared/queues.def"
#undef WAVEFRONT_QUEUE
    ;

// What was pushed becomes what is worked on: arguments, statistics, and an empty fill count. One invocation per queue.
void closeQueue(uint queue) {
  uint q = kQueueBase + queue * kQueueStride;
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
// Pairs of sample and pixel not handed out yet, at most 2^30 - 1 of them.
uint workLeft() {
  uint pixels = frame.width * frame.bandHeight, first = counters[kWorkSample], end = counters[kWorkEndSample];
  if (first >= end) return 0u;
  return end - first > 0x3fffffffu / pixels ? 0x3fffffffu : (end - first) * pixels - counters[kWorkPixel];
}
// The part of the pool that a path stands in, and the counter of a bucket's paths in it.
uint poolPart(uint path) { return path / ((frame.poolSize + kPoolParts - 1u) / kPoolParts); }
uint partCount(uint part, uint bucket) {
  uint stride = (frame.bucketCount + kPartLine - 1u) / kPartLine * kPartLine;
  return (kBucketBase + kBucketStride * frame.bucketCount + kPartLine - 1u) / kPartLine * kPartLine + part * stride + bucket;
}
void reportError(uint flag) { atomicOr(counters[kErrorFlags], flag); }

const uint kNoQueue = 0xffffffffu;
// In the megakernel a path's queues are bits of its invocation's own.
#ifdef WAVEFRONT_MEGAKERNEL
#include "megakernel/queue.glsl"
#else
// `queue` is the same for all that call it together: the whole subgroup makes one addition, because each is an exchange
// between the cores that push to that queue.
void pushQueue(uint queue, uint path) {
  uvec4 pushing = subgroupBallot(true);
  uint first = 0u;
  if (subgroupElect()) first = atomicAdd(counters[kQueueBase + queue * kQueueStride + kQueueFill], subgroupBallotBitCount(pushing));
  uint slot = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(pushing);
  queueItems[(kItemsQueues + queue) * frame.poolSize + slot] = path;
}
// The path's bucket in this iteration, kNoBucket: none. Once a path and iteration.
void sendToBucket(uint path, uint key) {
  queueItems[kItemsKeys * frame.poolSize + path] = key;
  if (key != kNoBucket) atomicAdd(counters[partCount(poolPart(path), key)], 1u);
}
// The path of this invocation in a kernel over a queue; false past its end.
bool queuePath(uint queue, out uint path) {
  if (gl_GlobalInvocationID.x >= counters[kQueueBase + queue * kQueueStride + kQueueCount]) { path = 0u; return false; }
  path = queueItems[(kItemsQueues + queue) * frame.poolSize + gl_GlobalInvocationID.x];
  return true;
}
// The path of this invocation in a material kernel; false past the bucket's end.
bool bucketPath(out uint path) {
  uint bucket = kBucketBase + pushBucket * kBucketStride;
  if (gl_GlobalInvocationID.x >= counters[bucket + kBucketCount]) { path = 0u; return false; }
  path = queueItems[kItemsSorted * frame.poolSize + counters[bucket + kBucketOffset] + gl_GlobalInvocationID.x];
  return true;
}
// An idle path and the work that it gets, counted from the first that is handed out in this iteration; false: nothing left.
bool takeWork(out uint path, out uint work) {
  work = gl_GlobalInvocationID.x;
  if (work >= counters[kNewPathCount]) { path = 0u; return false; }
  path = queueItems[kItemsSorted * frame.poolSize + counters[kBucketBase + kBucketNewPath * kBucketStride + kBucketOffset] + work];
  return true;
}
#endif
void pushExtensionRay(uint path) { pushQueue(kQueueExtensionRay, path); }
void pushShadowRay(uint path) { pushQueue(kQueueShadowRay, path); }
#endif
