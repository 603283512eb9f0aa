#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Logic kernel: over all paths. Finds what the extension ray met, Russian roulette, extinction inside media, ends paths,
// and sends each path on (Laine et al. 2013, section 3.2).
// In the paper it samples lights, adds those that were seen and the emission of what was hit, too. Those are light_sample,
// shadow_ray and escape here: software Vulkan runs every branch for every path, so what only some paths need is worth a
// queue of its own, and nothing is to be read for them here.
// Paths that scatter inside of a body, or are on a random walk below a surface, go to queues of their own.
// Reads: Ids, Hit, HitDistance, Throughput, RayOrigin, Medium, Walk; Radiance where the path ends; what waits for
// its opacity or emission kernel: ShadowOrigin, ShadowContribution, Cone.
// Writes: Ids, Throughput, film.
// Pushes to: light samples, escapes, medium scatters, walks and their exits, and the path's bucket (key and count;
// scan_buckets and scatter make the queue).
// Runs after: the ray casts.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/sampler.glsl"
#include "lib/film.glsl"
#include "lib/records.glsl"
#include "lib/media.glsl"

layout(local_size_x = 64) in;

void main() {
  uint path = gl_GlobalInvocationID.x;
  if (path >= frame.poolSize) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uint phase = ids.w & kPhaseMask;
  uint key = kNoBucket;

  if (phase == kPhaseIdle) {
    key = kBucketNewPath;
  } else if (phase == kPhaseReady) {
    bool ended = (ids.w & kFlagEnd) != 0u;
    bool escaped = false, behindLight = false;
    uint queue = kNoQueue;  // beside the light sample's
    bool wantsLight = false;
    vec3 throughput = vec3(0.0);
    if (!ended) {
      uvec4 hit = loadPath(kChunkHit, path);
      throughput = uintBitsToFloat(loadPath(kChunkThroughput, path).rgb);
      uint bounce = pathBounce(ids.w);
      bool missed = hit.x == 0xffffffffu, walks = kHasScatteringMedia && (ids.w & kFlagSubsurface) != 0u;
      // Inside of a body that scatters a ray ends after a free flight: a miss is a scattering event.
      uvec4 medium = uvec4(0u);
      if (kHasBodies) medium = loadPath(kChunkMedium, path);
      bool scatters = missed && mediumScatters(medium);
      escaped = missed && !scatters;
      if (!escaped) {
        if (kHasBodies) {
          float t = uintBitsToFloat(loadPathWord(kChunkHitDistance, path, 0u));
          float from = max(0.0, uintBitsToFloat(loadPathWord(kChunkRayOrigin, path, 3u)));
          throughput *= mediumWeight(medium, throughput, max(0.0, t - from), scatters);
        }
        if (bounce == 0u) ids.w |= kFlagCovered;
      }
      if (!missed && !walks) {
        escaped = kHasLightShapes && (instanceWord(hit.x, 3u).z & kInstanceKindMask) != kKindMesh;  // an analytic light scatters nothing
        behindLight = escaped && bounce != 0u;
      }
      bool last = bounce >= frame.maxBounces;
      // A walk leaves through the body that it entered; whatever else it meets is passed.
      bool exits = false;
      if (kHasScatteringMedia) {
        if (walks && !missed) exits = hit.x == loadPath(kChunkWalk, path).z;
      }
      if (exits) queue = kQueueSubsurfaceExit;
      else if (walks) queue = kQueueSubsurfaceWalk;
      else if (scatters) queue = kQueueMediumScatter;
      else if (escaped) queue = kQueueEscape;
      if (queue == kQueueMediumScatter && last) ended = true;
      bool onSurface = queue == kNoQueue;
      if (onSurface) {
        uvec4 buckets = hitBuckets(hit.x, hit.y);
        key = buckets.x;
        // The last hit only shows emission (or lets the ray through): nothing to do where there is neither.
        if (last && buckets.y == kNoBucket && buckets.z == kNoBucket && (ids.w & kFlagAovWritten) != 0u) ended = true;
        if (key == kNoBucket) ended = true;  // no kernel for this material: the delegate has said so
        // Russian roulette, by the root of what the path can still carry: paths that survive gain less weight, for few more
        // segments (measured: resources/BENCH.md, noise). Passing through a surface comes here again: the number is keyed
        // by passes, too.
        if (!last && bounce >= frame.rouletteBounce) {
          float survive = clamp(sqrt(max(throughput.r, max(throughput.g, throughput.b))), 0.05, 1.0);
          if (samplePass(ids.z ^ 0x2545f491u, ids.y, bounce, pathPasses(ids.w)) >= survive) ended = true;
          throughput /= survive;
        }
      }
      wantsLight = (onSurface || exits) && !last && frame.lightItemCount != 0u;
    }
    if (ended) {
      filmAddSample(ids.x, uintBitsToFloat(loadPath(kChunkRadiance, path)).rgb, pathAlpha(ids.w));
      ids.w = kPhaseIdle;
      key = kBucketNewPath;
    } else {
      storePathRgb(kChunkThroughput, path, throughput);
      if (wantsLight) pushQueue(kQueueLightSample, path);
      // The escape kernel ends the path before new_path takes its place; or sends the ray on behind a light, which only
      // the camera sees as a body: the path then stands in no bucket. Nor do the paths of the other queues.
      if (queue == kQueueEscape) pushQueue(kQueueEscape, path);
      if (kHasScatteringMedia) {
        if (queue == kQueueMediumScatter) pushQueue(kQueueMediumScatter, path);
        if (queue == kQueueSubsurfaceWalk) pushQueue(kQueueSubsurfaceWalk, path);
        if (queue == kQueueSubsurfaceExit) pushQueue(kQueueSubsurfaceExit, path);
      }
      if (escaped && !behindLight) key = kBucketNewPath;
    }
  } else if (phase == kPhaseHeld || phase == kPhaseOpacity) {
    bool held = phase == kPhaseHeld;
    uint instance = held ? loadPathWord(kChunkHit, path, 0u) : loadPathWord(kChunkShadowOrigin, path, 3u) & ~kShadowPassed;
    uint triangle = held ? loadPathWord(kChunkHit, path, 1u) : loadPathWord(kChunkShadowContribution, path, 3u);
    uvec4 buckets = hitBuckets(instance, triangle);
    key = held ? buckets.x : buckets.y;
    if (held) ids.w = withPhase(ids.w, kPhaseReady);
  } else {
    uvec4 item = texelFetch(lightItems, int(loadPathWord(kChunkCone, path, 2u)));
    key = hitBuckets(item.x, item.y).z;
  }
  // A bucket without a kernel holds its paths: they wait here, whatever iteration it comes in, and the picture cannot
  // tell, because nothing about a path depends on when it is worked on.
  if (key != kNoBucket && counters[kBucketBase + key * kBucketStride + kBucketHold] != 0u) {
    if (phase == kPhaseReady || phase == kPhaseHeld) ids.w = withPhase(ids.w, kPhaseHeld);
    key = kNoBucket;
  }
  if (phase == kPhaseReady || phase == kPhaseHeld) storePathWord(kChunkIds, path, 3u, ids.w);
  sendToBucket(path, key);
}
