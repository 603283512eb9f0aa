#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// New path kernel: an image sample, its camera ray, the initial path state.
// Reads: bucket 0, the work position. Writes: the whole path state. Pushes to: extension rays. Runs after: scatter.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/features.glsl"
#include "lib/contribute.glsl"
#include "lib/sampler.glsl"
#include "lib/camera.glsl"
layout(local_size_x = 64) in;

void main() {
  uint path, work;
  if (!takeWork(path, work)) return;
  uint pixels = frame.width * frame.bandHeight;
  work += counters[kNewPathBasePixel];
  uint sampleIndex = counters[kNewPathBaseSample] + work / pixels;
  uint pixel = work % pixels;
  uint x = pixel % frame.width, y = pixel / frame.width + frame.bandY;
  uint seed = pixelSeed(x, y, frame.seed);

  vec2 jitter = sample2D(seed, sampleIndex, kPairPixel);
  vec2 lens = isSet(frame.lensRadius > 0.0) ? sample2D(seed, sampleIndex, kPairLens) : vec2(0.0);
  float time = mix(frame.shutterOpen, frame.shutterClose, sample1D(seed, sampleIndex, kPairTime));
  vec3 origin, direction;
  float tMin, tMax;
  cameraRay(vec2(x, y) + jitter, lens, origin, direction, tMin, tMax);

  storePathF(kChunkRayOrigin, path, vec4(origin, tMin));
  storePathF(kChunkRayDirection, path, vec4(direction, tMax));
  storePathWord(kChunkHit, path, 0u, 0xffffffffu);
  storePathWord(kChunkHit, path, 1u, kHitCamera);
  storePathF(kChunkThroughput, path, vec4(1.0, 1.0, 1.0, 0.0));
  storePathRgb(kChunkRadiance, path, vec3(0.0));
  storePath(kChunkIds, path, uvec4(pixel, sampleIndex, seed, kPhaseReady));
  if (kHasBodies) {
    storePath(kChunkMediaStack, path, uvec4(0u));
    storePath(kChunkMedium, path, uvec4(0u));
  }
  storePathF(kChunkCone, path, vec4(frame.pixelSpread, time, 0.0, frame.pixelWidth));
  setPathEvents(path, 0u);
  pushExtensionRay(path);
}
