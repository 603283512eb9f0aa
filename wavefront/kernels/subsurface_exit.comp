#version 460
// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Subsurface exit kernel: a random walk came back to the surface of the body that it entered. It leaves as from a white
// diffuse surface seen from inside, whatever the material is there: the body's colour is in the walk.
// Reads: Ids, RayDirection, Hit, Throughput, LightSample, LightRadiance, MediaStack, Cone.
// Writes: those of the next segment. Pushes to: extension rays, shadow rays. Runs after: light_sample.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/sampler.glsl"
#include "lib/geometry.glsl"
#include "lib/media.glsl"
#include "lib/ray_offset.glsl"
#include "lib/contribute.glsl"
#include "lib/shadow_cast.glsl"
#include "lib/bsdf/bsdf_common.glsl"

layout(local_size_x = 64) in;

void main() {
  uint path;
  if (!queuePath(kQueueSubsurfaceExit, path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  vec3 wo = -uintBitsToFloat(loadPath(kChunkRayDirection, path)).xyz;
  uvec4 hit = loadPath(kChunkHit, path);
  vec3 throughput = uintBitsToFloat(loadPath(kChunkThroughput, path)).rgb;
  uvec4 medium = mediumOf(mediumTop(loadPath(kChunkMediaStack, path), 0u));
  uvec4 cone = loadPath(kChunkCone, path);
  uint bounce = pathBounce(ids.w);
  ShadingPoint sp = shadingPointMake(hit.x, hit.y, uintBitsToFloat(hit.zw), wo, 0.0, uintBitsToFloat(cone.y));
  // Both normals on the side that the path leaves to.
  float side = sp.frontFacing ? -1.0 : 1.0;
  vec3 ng = side * sp.normalGeometric, n = side * sp.normalWorld;

  vec3 wi = toWorld(frameFromNormal(n), bsdfSampleCosine(sample2D(ids.z, ids.y, bouncePair(bounce, kPairExit))));
  float pdf = dot(wi, ng) > 0.0 ? max(dot(wi, n), 0.0) * kBsdfInvPi : 0.0;
  vec3 error = surfacePointError(sp.instance, gCorner0, gCorner1, gCorner2, sp.positionWorld);
  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  vec4 lightRadiance = uintBitsToFloat(loadPath(kChunkLightRadiance, path));
  if (frame.lightItemCount == 0u) lightRadiance.a = 0.0;
  float towards = dot(light.xyz, ng) > 0.0 ? max(dot(light.xyz, n), 0.0) * kBsdfInvPi : 0.0;
  castShadowRay(path, sp.positionWorld, offsetRayOrigin(sp.positionWorld, error, ng, light.xyz), hit.xy, throughput, light,
                lightRadiance, cone.z,
                vec4(towards * mediumTransmittance(medium, abs(light.w)), towards));

  ids.w &= ~(kFlagSubsurface | kFlagMediumLight);
  storePath(kChunkMedium, path, medium);
  if (!(pdf > 0.0)) ids.w |= kFlagEnd;
  storePathWord(kChunkIds, path, 3u, ids.w + (pdf > 0.0 ? 1u << kBounceShift : 0u));
  if (!(pdf > 0.0)) return;
  float flight = samplePass(ids.z ^ 0x6a09e667u, ids.y, bounce, 0u);
  storePathF(kChunkRayOrigin, path, vec4(offsetRayOrigin(sp.positionWorld, error, ng, wi), 0.0));
  storePathF(kChunkRayDirection, path, vec4(wi, mediumScatters(medium) ? mediumFlight(medium, throughput, flight) : 3.4e38));
  storePathF(kChunkThroughput, path, vec4(throughput, pdf));
  storePathWord(kChunkCone, path, 0u, floatBitsToUint(0.25));
  setPathEvents(path, pathEvents(path) | kEventTransmission);
  pushExtensionRay(path);
}
