#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Logic kernel: over all paths, everything but rays and materials (Laine et al. 2013, section 3.2).
// Reads: the whole path state, light table. Writes: Radiance, Throughput, LightSample, LightRadiance, Cone, Ids, film.
// Pushes to: the path's bucket (key and count; scan_buckets and scatter make the queue). Runs after: the ray casts.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/sampler.glsl"
#include "lib/film.glsl"
#include "lib/geometry.glsl"
#include "lib/lights/light_table.glsl"
#include "lib/media.glsl"

layout(local_size_x = 64) in;

// Radiance of the lights at infinity along a ray that left the scene; dome lights may be hidden from the camera.
vec3 missRadiance(vec3 direction, float bsdfPdf, float coneSpread, inout float alpha) {
  vec3 sum = vec3(0.0);
  bool camera = bsdfPdf == 0.0;
  [[dont_unroll]] for (uint i = 0u; i < frame.infiniteLightCount; ++i) {
    Light l = lightLoad(i);
    bool dome = l.type == kLightDome;
    if (camera && (!dome || (frame.flags & kFrameDomeVisible) == 0u || (l.flags & kLightFlagCameraVisible) == 0u)) continue;
    float pdf = dome ? domePdf(l, direction) : distantPdf(l, direction);
    if (!dome && pdf == 0.0) continue;
    float weight = camera ? 1.0 : powerHeuristic(bsdfPdf, pdf * lightItemProbability(l.item));
    sum += weight * lightRadiance(l, -direction, vec3(0.0), coneSpread * 0.15915494309);
    if (camera) alpha = 1.0;
  }
  return sum;
}

void endPath(uint path, uvec4 ids, vec3 radiance, float alpha) {
  filmAddSample(ids.x, radiance, alpha);
}

void main() {
  uint path = gl_GlobalInvocationID.x;
  if (path >= frame.poolSize) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uint phase = ids.w & kPhaseMask;
  uint key = kNoBucket;

  if (phase == kPhaseIdle) {
    key = kBucketNewPath;
  } else if (phase == kPhaseOpacity) {
    uvec4 hit = loadPath(kChunkShadowHit, path);
    uint slot = floatBitsToUint(texelFetch(triangleRecords, int(hit.y * kTriangleTexels + 1u)).w);
    uint binding = texelFetch(indexStream, int(instanceWord(hit.x, 7u).y + slot)).x;
    key = texelFetch(bindingRecords, int(binding)).y;
  } else if (phase == kPhaseEmission) {
    uvec4 item = lightItem(loadPath(kChunkShadowContribution, path).w);
    uint slot = floatBitsToUint(texelFetch(triangleRecords, int(item.y * kTriangleTexels + 1u)).w);
    uint binding = texelFetch(indexStream, int(instanceWord(item.x, 7u).y + slot)).x;
    key = texelFetch(bindingRecords, int(binding)).z;
  } else {
    vec4 radianceAlpha = uintBitsToFloat(loadPath(kChunkRadiance, path));
    vec3 radiance = radianceAlpha.rgb;
    float alpha = radianceAlpha.a;
    if ((ids.w & kFlagShadow) != 0u) {
      radiance += uintBitsToFloat(loadPath(kChunkShadowContribution, path)).rgb;
      ids.w &= ~kFlagShadow;
    }
    bool ended = (ids.w & kFlagEnd) != 0u;
    if (!ended) {
      uvec4 hit = loadPath(kChunkHit, path);
      vec4 throughputPdf = uintBitsToFloat(loadPath(kChunkThroughput, path));
      vec3 throughput = throughputPdf.rgb;
      float bsdfPdf = throughputPdf.a;
      vec4 o = uintBitsToFloat(loadPath(kChunkRayOrigin, path));
      vec4 d = uintBitsToFloat(loadPath(kChunkRayDirection, path));
      uvec4 extra = loadPath(kChunkHitDistance, path);
      vec4 cone = uintBitsToFloat(loadPath(kChunkCone, path));
      float t = uintBitsToFloat(extra.x);
      uint bounce = pathBounce(ids.w);

      if (hit.x == 0xffffffffu) {
        radiance += throughput * missRadiance(d.xyz, bsdfPdf, cone.x, alpha);
        ended = true;
      } else {
        // Extinction of the medium that the segment lies in.
        vec3 extinction = mediumExtinction(loadPath(kChunkMediaA, path), loadPath(kChunkMediaB, path));
        throughput *= exp(-extinction * max(0.0, t - max(0.0, o.w)));
        if (bounce == 0u) alpha = 1.0;
        uint kind = instanceWord(hit.x, 3u).z & kInstanceKindMask;
        if (kind != kKindMesh) {
          // An analytic light: emits towards the ray, scatters nothing.
          Light l = lightLoad(instanceWord(hit.x, 7u).x);
          vec3 local = transformPoint(instanceRow(hit.x, 0u), instanceRow(hit.x, 1u), instanceRow(hit.x, 2u), o.xyz + t * d.xyz);
          vec3 unitPoint = lightShapePoint(kind, local);
          if (dot(lightAreaVector(l, unitNormal(l.type, unitPoint)), d.xyz) < 0.0) {
            float weight = bsdfPdf == 0.0 ? 1.0 : powerHeuristic(bsdfPdf, shapeHitPdf(l, o.xyz, d.xyz, t, unitPoint) * lightItemProbability(l.item));
            float size = sqrt(length(lightAreaVector(l, unitNormal(l.type, unitPoint))));
            float width = uintBitsToFloat(extra.w) + cone.x * t;
            radiance += weight * throughput * lightRadiance(l, -d.xyz, unitPoint, width / max(size, 1e-20));
          }
          ended = true;
        } else {
          int texel = int(hit.y * kTriangleTexels);
          uint slot = floatBitsToUint(texelFetch(triangleRecords, texel + 1).w);
          uvec4 ids7 = instanceWord(hit.x, 7u);
          uint binding = texelFetch(indexStream, int(ids7.y + slot)).x;
          uvec4 buckets = texelFetch(bindingRecords, int(binding));
          key = buckets.x;
          // The last hit only shows emission (or lets the ray through): nothing to do where there is neither.
          if (key == kNoBucket) ended = true;  // no kernel for this material: the delegate has said so
          if (bounce >= frame.maxBounces && buckets.y == kNoBucket && buckets.z == kNoBucket && (ids.w & kFlagAovWritten) != 0u) {
            ended = true;
            key = kNoBucket;
          }

          // Russian roulette, on what the path can still carry.
          if (!ended && bounce >= frame.rouletteBounce && bounce < frame.maxBounces) {
            float survive = clamp(max(throughput.r, max(throughput.g, throughput.b)), 0.05, 1.0);
            // Passing through a surface comes here again: the number is keyed by passes too.
            float u = samplePass(ids.z ^ 0x2545f491u, ids.y, bounce, pathPasses(ids.w));
            if (u >= survive) { ended = true; key = kNoBucket; }
            else throughput /= survive;
          }
          // A light sample for the material kernel to weigh.
          vec3 lightRadianceSample = vec3(0.0);
          LightSample light;
          light.direction = vec3(0.0, 0.0, 1.0); light.distance = 0.0; light.pdf = 0.0;
          uint item = kNoLight;
          if (!ended && frame.lightItemCount != 0u && bounce < frame.maxBounces) {
            vec3 a = texelFetch(triangleRecords, texel).xyz, b = texelFetch(triangleRecords, texel + 1).xyz, c = texelFetch(triangleRecords, texel + 2).xyz;
            vec2 uv = uintBitsToFloat(hit.zw);
            vec3 p = transformPoint(instanceRow(hit.x, 4u), instanceRow(hit.x, 5u), instanceRow(hit.x, 6u), a + uv.x * (b - a) + uv.y * (c - a));
            item = pickLightItem(sample1D(ids.z, ids.y, bouncePair(bounce, kPairLightPick)));
            // The footprint of the lookup: a blurred texel or two of a dome costs nothing visible and much noise.
            light = sampleLightItem(item, p, sample2D(ids.z, ids.y, bouncePair(bounce, kPairLightPoint)), 0.0, lightRadianceSample);
          }
          storePathF(kChunkLightSample, path, vec4(light.direction, light.distance));
          storePathF(kChunkLightRadiance, path, vec4(lightRadianceSample, light.pdf));
          storePathF(kChunkCone, path, vec4(cone.xy, uintBitsToFloat(item), cone.w));
          storePathF(kChunkThroughput, path, vec4(throughput, bsdfPdf));
        }
      }
    }
    if (ended) {
      endPath(path, ids, radiance, alpha);
      ids.w = kPhaseIdle;
      key = kBucketNewPath;
    } else {
      storePathF(kChunkRadiance, path, vec4(radiance, alpha));
    }
    storePath(kChunkIds, path, ids);
  }
  queueItems[kItemsKeys * frame.poolSize + path] = key;
  if (key != kNoBucket) atomicAdd(counters[kBucketBase + key * kBucketStride + kBucketCount], 1u);
}
