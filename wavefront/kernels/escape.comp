#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Escape kernel: paths whose extension ray left the scene or met an analytic light. Adds that light's radiance, weighed
// against the light sample that could have found it, and ends the path. Only the camera sees lights as bodies: they throw
// no shadows, so other rays go on behind them (light samples and bounces must see the same scene, or MIS is biased).
// Reads: Ids, Hit, HitDistance, RayOrigin, RayDirection, Throughput, Radiance, Cone.
// Writes: film, Ids; of rays that go on: Radiance, RayOrigin. Pushes to: extension rays.
// Runs after: scan_buckets, before new_path.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/film.glsl"
#include "lib/contribute.glsl"
#include "lib/lights/light_table.glsl"

layout(local_size_x = 64) in;

// Adds the lights at infinity along a ray that left the scene; dome lights may be hidden from the camera.
vec3 addMiss(vec3 radiance, inout float alpha, vec3 throughput, vec3 direction, float bsdfPdf, float coneSpread, uint events) {
  bool camera = bsdfPdf == 0.0;
  [[dont_unroll]] for (uint i = 0u; i < frame.infiniteLightCount; ++i) {
    Light l = lightLoad(i);
    bool dome = kHasDomeLights && (!kHasDistantLights || l.type == kLightDome);
    if (camera && (!dome || (frame.flags & kFrameDomeVisible) == 0u || (l.flags & kLightFlagCameraVisible) == 0u)) continue;
    float pdf = dome ? domePdf(l, direction) : distantPdf(l, direction);
    if (!dome && pdf == 0.0) continue;
    float weight = camera ? 1.0 : powerHeuristic(bsdfPdf, pdf * infiniteLightProbability(l.item));
    if (!camera && !castsShadow(l.flags)) weight = 0.0;
    // A light sample reads the texture sharp. Where it shares the estimate, both must see one radiance: a blurred sun
    // would be added once more beside the place where light samples find it.
    vec3 found = weight * lightRadiance(l, -direction, vec3(0.0), camera ? coneSpread * 0.15915494309 : 0.0);
    radiance = contribute(radiance, throughput * found, events, lightGroup(l.flags));
    if (camera) alpha = 1.0;
  }
  return radiance;
}

// Adds what the analytic light that was hit sends towards the ray.
vec3 addShape(vec3 radiance, vec3 throughput, uint instance, vec3 origin, vec3 direction, float t, float width, float bsdfPdf, uint events) {
  Light l = lightLoad(instanceWord(instance, 7u).x);
  uint kind = instanceWord(instance, 3u).z & kInstanceKindMask;
  vec3 local = transformPoint(instanceRow(instance, 0u), instanceRow(instance, 1u), instanceRow(instance, 2u), origin + t * direction);
  vec3 unitPoint = lightShapePoint(kind, local);
  vec3 area = lightAreaVector(l, unitNormal(l.type, unitPoint));
  if (dot(area, direction) >= 0.0) return radiance;
  float weight = bsdfPdf == 0.0 ? 1.0 : powerHeuristic(bsdfPdf, shapeHitPdf(l, origin, direction, t, unitPoint) * lightItemProbability(l.item, origin));
  if (bsdfPdf != 0.0 && !castsShadow(l.flags)) weight = 0.0;
  // As in addMiss: sharp where a light sample shares the estimate.
  float footprint = bsdfPdf == 0.0 ? width / max(sqrt(length(area)), 1e-20) : 0.0;
  vec3 found = weight * lightRadiance(l, -direction, unitPoint, footprint);
  return contribute(radiance, throughput * found, events, lightGroup(l.flags));
}

void main() {
  uint path;
  if (!queuePath(kQueueEscape, path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uvec4 hit = loadPath(kChunkHit, path);
  uint t = loadPathWord(kChunkHitDistance, path, 0u);
  uint events = pathEvents(path);
  vec4 throughput = uintBitsToFloat(loadPath(kChunkThroughput, path));
  vec4 origin = uintBitsToFloat(loadPath(kChunkRayOrigin, path));
  vec3 direction = uintBitsToFloat(loadPath(kChunkRayDirection, path)).xyz;
  vec3 radiance = uintBitsToFloat(loadPath(kChunkRadiance, path)).rgb;
  float alpha = pathAlpha(ids.w);
  uvec4 cone = loadPath(kChunkCone, path);
  float spread = uintBitsToFloat(cone.x);
  if (!kHasLightShapes || hit.x == 0xffffffffu) {
    if (kHasInfiniteLights) radiance = addMiss(radiance, alpha, throughput.rgb, direction, throughput.a, spread, events);
  } else {
    float distance = uintBitsToFloat(t);
    radiance = addShape(radiance, throughput.rgb, hit.x, origin.xyz, direction, distance, uintBitsToFloat(cone.w) + spread * distance, throughput.a, events);
  }
  if (kHasLightShapes && hit.x != 0xffffffffu && pathBounce(ids.w) != 0u) {
    storePathRgb(kChunkRadiance, path, radiance);
    storePathWord(kChunkRayOrigin, path, 3u, t);
    pushExtensionRay(path);
    return;
  }
  filmAddSample(ids.x, radiance, alpha);
  storePathWord(kChunkIds, path, 3u, kPhaseIdle);
}
