#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Between two dispatches of the megakernel: takes stock of the one before, hands out work for the one after, and puts
// both to sleep when nothing is left. One invocation. The megakernel takes work by an atomic counter that may run past
// what there is.
// Reads and writes: counters. Runs after: the megakernel, before its next dispatch.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/queue.glsl"
layout(local_size_x = 1) in;

void main() {
  uint pixels = frame.width * frame.bandHeight;
  uint started = min(counters[kMegaNextWork], counters[kNewPathCount]);
  if (started != 0u) {
    uint next = counters[kNewPathBasePixel] + started;
    counters[kWorkSample] = counters[kNewPathBaseSample] + next / pixels;
    counters[kWorkPixel] = next % pixels;
  }
  uint old = counters[kPathsDoneLo];
  counters[kPathsDoneLo] = old + started;
  if (old + started < old) counters[kPathsDoneHi] += 1u;
#define WAVEFRONT_QUEUE(Name, index, doc) closeQueue(kQueue##Name);
#include "shared/queues.def"
#undef WAVEFRONT_QUEUE
  uint left = workLeft();
  counters[kNewPathBaseSample] = counters[kWorkSample];
  counters[kNewPathBasePixel] = counters[kWorkPixel];
  counters[kNewPathCount] = left;
  counters[kMegaNextWork] = 0u;
  if (counters[kPoolArgs] != 0u) counters[kIterations] += 1u;
  if (left == 0u && counters[kActivePaths] == 0u) {
    counters[kPoolArgs] = 0u;
    counters[kScanArgs] = 0u;
  }
}
