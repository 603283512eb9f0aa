// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The queue contract of lib/queue.glsl in the megakernel: what an invocation's path stands in is a word and a number of
// its own, and the stage that works on a queue asks for them. Statistics are added up and leave with the state.
#ifndef WAVEFRONT_MEGAKERNEL_QUEUE_GLSL
#define WAVEFRONT_MEGAKERNEL_QUEUE_GLSL

uint megaQueues = 0u;          // a bit per row of queues.def
uint megaBucket = kNoBucket;
uint megaItems[kQueueKinds];
uint megaLoops = 0u;           // iterations of loops so far but those of rays, see megakernel/tail.glsl

void pushQueue(uint queue, uint path) {
  megaQueues |= 1u << queue;
  ++megaItems[queue];
}

void sendToBucket(uint path, uint key) { megaBucket = key; }

bool queuePath(uint queue, out uint path) {
  path = gl_GlobalInvocationID.x;
  return (megaQueues & (1u << queue)) != 0u;
}
// The material stages are only called for their bucket.
bool bucketPath(out uint path) {
  path = gl_GlobalInvocationID.x;
  return true;
}
// Path regeneration: an idle path takes the next work at once.
bool takeWork(out uint path, out uint work) {
  path = gl_GlobalInvocationID.x;
  work = 0u;
  if (megaBucket != kBucketNewPath) return false;
  work = atomicAdd(counters[kMegaNextWork], 1u);
  return work < counters[kNewPathCount];
}
// Stands in the condition of every loop of a material; true.
bool countLoop() {
  ++megaLoops;
  return true;
}
#endif
