#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Puts each path's index into its bucket's part of the sorted index array.
// Reads: keys, each part's offsets. Writes: sorted indices. Runs after: scan_buckets.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/queue.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path = gl_GlobalInvocationID.x;
  if (path >= frame.poolSize) return;
  uint key = queueItems[kItemsKeys * frame.poolSize + path];
  if (key == kNoBucket) return;
  uint slot = atomicAdd(counters[partCount(poolPart(path), key)], 1u);
  queueItems[kItemsSorted * frame.poolSize + slot] = path;
}
