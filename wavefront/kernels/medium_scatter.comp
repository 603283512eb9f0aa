#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Medium scatter kernel: a ray inside of a body ended after a free flight. Samples the phase function for the next
// direction and a light with MIS. The next free flight bounds the next ray. No bounce is counted: maxBounces counts surfaces.
// Shadow rays end at the body's boundary as they do at every surface that refracts: light from outside is found by paths
// that leave.
// Reads: Ids, RayOrigin, RayDirection, HitDistance, Throughput, Medium, Cone, Walk. Writes: those of the next segment.
// Pushes to: extension rays, shadow rays. Runs after: scan_buckets.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/medium_walk.glsl"
#include "lib/lights/light_table.glsl"
#include "lib/shadow_cast.glsl"

layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueMediumScatter, path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  vec3 throughput = uintBitsToFloat(loadPath(kChunkThroughput, path)).rgb;
  uvec4 medium = loadPath(kChunkMedium, path);
  uvec4 cone = loadPath(kChunkCone, path);
  float spread = uintBitsToFloat(cone.x);
  float t = uintBitsToFloat(loadPathWord(kChunkHitDistance, path, 0u));
  uint before = loadPath(kChunkWalk, path).x, bounce = pathBounce(ids.w);
  vec2 flight = sample2D(ids.z, ids.y, mediumPair(bounce, before + 1u, kMediumFlight));
  vec3 direction;
  vec3 p = mediumPoint(path, direction);
  uint event = mediumEvent(path, ids, throughput, before, flight.y);
  if (event == 0u) return;

  float g = mediumAnisotropy(medium);
  vec3 wi = phaseSample(g, direction, sample2D(ids.z, ids.y, mediumPair(bounce, event, kMediumDirection)));
  float pdf = phaseEval(g, dot(direction, wi));

  uint lightPair = mediumPair(bounce, event, kMediumLightPoint);
  if (frame.lightItemCount != 0u) {
    float probability;
    uint item = pickLightItem(p, sample1D(ids.z, ids.y, mediumPair(bounce, event, kMediumLightPick)), probability);
    vec3 radiance;
    LightSample light = sampleLightItem(item, probability, p, sample2D(ids.z, ids.y, lightPair), 0.0, radiance);
    uvec4 record = lightItem(item);
    uint flags = record.y != kNoLight ? kLightFlagShadows : floatBitsToUint(lightTexel(record.x, 0u)).y;
    float towards = phaseEval(g, dot(direction, light.direction));
    vec4 value = vec4(towards * mediumTransmittance(medium, light.distance), towards);
    castShadowRay(path, p, p, uvec2(0xffffffffu), throughput,
                  vec4(light.direction, castsShadow(flags) ? light.distance : -light.distance), vec4(radiance, light.pdf), item, value);
    cone.z = item;
  }
  ids.w |= kFlagMediumLight;

  storePathF(kChunkRayOrigin, path, vec4(p, 0.0));
  storePathF(kChunkRayDirection, path, vec4(wi, mediumFlight(medium, throughput, flight.x)));
  storePathF(kChunkThroughput, path, vec4(throughput, pdf));
  storePath(kChunkCone, path, uvec4(floatBitsToUint(min(spread + 0.125 * inversesqrt(pdf), 0.25)), cone.yz, floatBitsToUint(uintBitsToFloat(cone.w) + spread * t)));
  storePath(kChunkWalk, path, uvec4(event, lightPair, 0u, 0u));
  storePath(kChunkIds, path, ids);
  pushExtensionRay(path);
}
