#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Light sample kernel: for each path on a surface, a light item and a point on it as seen from there; the material kernel
// weighs it before the shadow ray is cast.
// Reads: Ids, Hit. Writes: LightSample, LightRadiance, Cone (the item). Runs after: scan_buckets.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/sampler.glsl"
#include "lib/lights/light_table.glsl"

layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueLightSample, path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uvec4 hit = loadPath(kChunkHit, path);
  uint bounce = pathBounce(ids.w);

  int texel = int(hit.y * kTriangleTexels);
  vec3 a = texelFetch(triangleRecords, texel).xyz, b = texelFetch(triangleRecords, texel + 1).xyz, c = texelFetch(triangleRecords, texel + 2).xyz;
  vec2 uv = uintBitsToFloat(hit.zw);
  vec3 p = transformPoint(instanceRow(hit.x, 4u), instanceRow(hit.x, 5u), instanceRow(hit.x, 6u), a + uv.x * (b - a) + uv.y * (c - a));

  float probability;
  uint item = pickLightItem(p, sample1D(ids.z, ids.y, bouncePair(bounce, kPairLightPick)), probability);
  vec3 radiance;
  // Finest texture level: the many points of many paths filter by themselves.
  LightSample light = sampleLightItem(item, probability, p, sample2D(ids.z, ids.y, bouncePair(bounce, kPairLightPoint)), 0.0, radiance);
  // A negative distance says that nothing blocks this light.
  uvec4 record = lightItem(item);
  uint flags = record.y != kNoLight ? kLightFlagShadows : floatBitsToUint(lightTexel(record.x, 0u)).y;
  storePathF(kChunkLightSample, path, vec4(light.direction, castsShadow(flags) ? light.distance : -light.distance));
  storePathF(kChunkLightRadiance, path, vec4(radiance, light.pdf));
  storePathWord(kChunkCone, path, 2u, item);
}
