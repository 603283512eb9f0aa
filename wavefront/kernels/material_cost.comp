#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What each path's next material kernel costs, added to its pixel: the materialCost AOV. Runs only where that is asked for.
// Reads: keys, Ids, the buckets' measured cost. Writes: film. Runs after: scan_buckets.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/film.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path = gl_GlobalInvocationID.x;
  if (path >= frame.poolSize) return;
  uint key = queueItems[kItemsKeys * frame.poolSize + path];
  if (key == kNoBucket || key < kFirstMaterialBucket) return;
  filmAdd(loadPath(kChunkIds, path).x, frame.costChannel, uintBitsToFloat(counters[kBucketBase + key * kBucketStride + kBucketCost]));
}
