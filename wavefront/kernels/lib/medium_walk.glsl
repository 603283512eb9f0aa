// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What events inside of bodies share: where they are, Russian roulette, and the ray that goes on.
#ifndef WAVEFRONT_LIB_MEDIUM_WALK_GLSL
#define WAVEFRONT_LIB_MEDIUM_WALK_GLSL
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/sampler.glsl"
#include "lib/media.glsl"
#include "lib/phase.glsl"

// Paths survive event 16 and later by their throughput, and after 128 by at most 0.98: 1e-8 of them see the last event.
const uint kMediumEvents = 1024u;
const uint kMediumRouletteEvent = 16u;
const uint kMediumLongWalk = 128u;

// The number of this event, from 1; 0: the path is over (and says so in its flags).
uint mediumEvent(uint path, inout uvec4 ids, inout vec3 throughput, uint before, float u) {
  float largest = max(throughput.r, max(throughput.g, throughput.b));
  uint event = before + 1u;
  if (event >= kMediumRouletteEvent) {
    float survive = clamp(largest, 0.05, event >= kMediumLongWalk ? 0.98 : 1.0);
    if (u >= survive) largest = 0.0;
    throughput /= survive;
  }
  if (largest > 0.0 && event >= kMediumEvents) reportError(kErrorMediumSteps);
  if (largest > 0.0 && event < kMediumEvents) return event;
  ids.w |= kFlagEnd;
  storePath(kChunkIds, path, ids);
  return 0u;
}
// Where the extension ray ended.
vec3 mediumPoint(uint path, out vec3 direction) {
  direction = uintBitsToFloat(loadPath(kChunkRayDirection, path)).xyz;
  return uintBitsToFloat(loadPath(kChunkRayOrigin, path)).xyz + uintBitsToFloat(loadPathWord(kChunkHitDistance, path, 0u)) * direction;
}
#endif
