// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Material kernel, the part that every material shares (Laine et al. 2013): emission, pass-through by opacity, first-hit
// AOVs, then sampling a direction and weighing the light sample in one go, so that the closure can be dropped.
// Reads: RayOrigin, RayDirection, Hit, HitDistance, Throughput, Radiance, Ids, LightSample, LightRadiance, Media, Cone.
// Writes: those of the next segment. Pushes to: extension rays, shadow rays. Runs after: scatter.

// Emission of the surface itself, weighed against the light sample that could have found it.
vec3 surfaceEmission(ShadingPoint sp, Closure c, float bsdfPdf, float t) {
  float weight = 1.0;
  uint itemBase = instanceWord(sp.instance, 7u).w;
  if (bsdfPdf > 0.0 && itemBase != kNoLight) {
    float pick = uintBitsToFloat(texelFetch(lightItems, int(itemBase + sp.triangle)).z);
    float pdf = pick * trianglePdf(gEdge1World, gEdge2World, sp.wo, t);
    weight = (frame.flags & kFrameShadows) != 0u ? powerHeuristic(bsdfPdf, pdf) : 0.0;  // as castsShadow of lights/record.glsl
  }
  return weight * c.emission;
}

// The descriptors of primvar AOVs follow those of the primvars that the material reads.
void filmFirstPrimvars(uint pixel, ShadingPoint sp) {
  uint first = frame.primvarAovCount == 0u ? 0u : texelFetch(bindingRecords, int(sp.binding) + 1).z;
  [[dont_unroll]] for (uint i = 0u; i < frame.primvarAovCount; ++i) {
    uvec3 value = floatBitsToUint(primvarVec3(sp, first + i, vec3(0.0)));
    uint channel = frame.primvarChannel + 3u * i;
    filmSetFirst(pixel, channel, value.x);
    filmSetFirst(pixel, channel + 1u, value.y);
    filmSetFirst(pixel, channel + 2u, value.z);
  }
}

void filmFirstHit(uvec4 ids, ShadingPoint sp, Closure c) {
  uint pixel = ids.x;
  if (frame.albedoChannel != kNoChannel) filmAdd3(pixel, frame.albedoChannel, closureAlbedo(c, sp.wo));
  if (frame.normalChannel != kNoChannel) filmAdd3(pixel, frame.normalChannel, sp.normalWorld);
  // A normal goes to camera space by the transpose of camera-to-world, and has its length back where that scales.
  if (frame.neyeChannel != kNoChannel) filmAdd3(pixel, frame.neyeChannel, normalize(transformNormal(frame.cameraToWorld0, frame.cameraToWorld1, frame.cameraToWorld2, sp.normalWorld)));
  if (ids.y != frame.rangeFirstSample || frame.firstChannels == 0u) return;
  vec3 zAxis = vec3(frame.cameraToWorld0.z, frame.cameraToWorld1.z, frame.cameraToWorld2.z);
  vec3 eye = vec3(frame.cameraToWorld0.w, frame.cameraToWorld1.w, frame.cameraToWorld2.w);
  float z = -dot(sp.positionWorld - eye, zAxis) / dot(zAxis, zAxis);
  float n = frame.nearClip, f = frame.farClip;
  float depth = frame.orthographic != 0u ? (z - n) / (f - n) : (z - n) / z * (f / (f - n));  // f may be the largest float
  uvec4 instanceIds = instanceWord(sp.instance, 8u);
  uint faceBase = texelFetch(meshRecords, int(sp.mesh)).y;
  uint face = faceBase == kNoStream ? sp.triangle : texelFetch(indexStream, int(faceBase + sp.triangle)).x;
  filmSetFirst(pixel, frame.depthChannel, floatBitsToUint(clamp(depth, 0.0, 1.0)));
  filmSetFirst(pixel, frame.cameraDepthChannel, floatBitsToUint(z));
  filmSetFirst(pixel, frame.primIdChannel, instanceIds.x);
  filmSetFirst(pixel, frame.instanceIdChannel, instanceIds.y);
  filmSetFirst(pixel, frame.elementIdChannel, face);
  filmFirstPrimvars(pixel, sp);
}

// Passing through by opacity: the surface is there with probability mean(opacity). What gets through costs no bounce,
// keeps the ray's origin and moves its start forward. True: the ray went on, this hit is done with.
bool passThrough(uint path, inout uvec4 ids, Closure c, uvec4 hit, uvec4 extra, vec3 origin, inout vec3 throughput, float bsdfPdf) {
  vec3 opacity = clamp(c.opacity, vec3(0.0), vec3(1.0));
  float present = (opacity.r + opacity.g + opacity.b) * (1.0 / 3.0);
  uint bounce = pathBounce(ids.w), passes = pathPasses(ids.w);
  if (samplePass(ids.z, ids.y, bounce, passes) < present) {
    throughput *= opacity / max(present, 1e-6);
    return false;
  }
  if (passes >= frame.maxTransparency) {
    reportError(kErrorTransparency);
    storePath(kChunkIds, path, uvec4(ids.xyz, ids.w | kFlagEnd));
    return true;
  }
  throughput *= (vec3(1.0) - opacity) / max(1.0 - present, 1e-6);
  if (bounce == 0u) {
    // The logic kernel counted this hit as coverage before it was known that the camera sees past it.
    vec4 radiance = uintBitsToFloat(loadPath(kChunkRadiance, path));
    storePathF(kChunkRadiance, path, vec4(radiance.rgb, 0.0));
  }
  storePathF(kChunkThroughput, path, vec4(throughput, bsdfPdf));
  storePath(kChunkRayOrigin, path, uvec4(floatBitsToUint(origin), extra.x));
  storePath(kChunkHitDistance, path, uvec4(extra.x, hit.x, hit.y, extra.w));
  storePath(kChunkIds, path, uvec4(ids.xyz, ids.w + (1u << kPassShift)));
  pushExtensionRay(path);
  return true;
}

// Entering or leaving a transmissive body. False where no more bodies fit.
bool crossBoundary(inout uvec4 mediaA, inout uvec4 mediaB, ShadingPoint sp, Closure c, bool entering) {
  uvec4 material = texelFetch(bindingRecords, int(sp.binding) + 1);
  if (entering) return mediumEnter(mediaA, mediaB, Medium(c.interiorExtinction, material.y, material.w));
  mediumLeave(mediaA, mediaB, material.y);
  return true;
}

// Beer-Lambert on the way to the light sample, as the logic kernel applies it to extension rays: by the medium on the
// light's side of the surface. Lights at infinity are seen from open bodies without loss, there as here.
vec3 lightExtinction(uint path, ShadingPoint sp, Closure c, vec4 light) {
  bool front = dot(sp.wo, sp.normalGeometric) >= 0.0;
  bool crosses = (dot(light.xyz, sp.normalGeometric) >= 0.0) != front;
  uvec4 mediaA = loadPath(kChunkMediaA, path), mediaB = loadPath(kChunkMediaB, path);
  if (kHasTransmission && crosses) crossBoundary(mediaA, mediaB, sp, c, front);
  vec3 extinction = mediumExtinction(mediaA, mediaB);
  return abs(light.w) < 1e29 ? exp(-extinction * abs(light.w)) : vec3(1.0);
}

// The light sample, weighed: casts a shadow ray if it is worth one. `value`: closure towards the light, and its pdf.
void castShadowRay(uint path, inout uvec4 ids, ShadingPoint sp, vec3 error, uvec4 hit, vec3 throughput, vec4 light,
                   vec4 lightRadiance, uint item, vec4 value) {
  if (!(lightRadiance.a > 0.0)) return;
  bool shadowless = light.w < 0.0;
  float weight = shadowless ? 1.0 : powerHeuristic(lightRadiance.a, value.a);
  vec3 contribution = throughput * value.rgb * lightRadiance.rgb * (weight / lightRadiance.a);
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;
  bool triangle = texelFetch(lightItems, int(item)).y != kNoLight;
  vec3 from = offsetRayOrigin(sp.positionWorld, error, sp.normalGeometric, light.xyz);
  // An emissive triangle ends the shadow ray just before it; analytic lights never block. The ray is aimed from where it
  // starts: along the old direction it would meet a triangle close to the surface's plane too early.
  if (triangle && !shadowless) {
    vec3 toLight = sp.positionWorld + light.xyz * light.w - from;
    float distance = length(toLight);
    if (distance > 0.0) light.xyz = toLight / distance;
    light.w = distance * (1.0 - 1e-4);
  }
  storePathF(kChunkShadowOrigin, path, vec4(from, 0.0));
  storePathF(kChunkLightSample, path, light);
  storePath(kChunkShadowContribution, path, uvec4(floatBitsToUint(contribution), triangle ? item : kNoLight));
  storePath(kChunkShadowHit, path, hit);  // to be skipped
  ids.w |= kFlagShadow;
  pushShadowRay(path);
}

void main() {
  uint path;
  if (!bucketPath(path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  vec3 origin = uintBitsToFloat(loadPath(kChunkRayOrigin, path)).xyz;
  vec3 wo = -uintBitsToFloat(loadPath(kChunkRayDirection, path)).xyz;
  uvec4 hit = loadPath(kChunkHit, path);
  uvec4 extra = loadPath(kChunkHitDistance, path);
  vec4 throughputPdf = uintBitsToFloat(loadPath(kChunkThroughput, path));
  uvec4 coneBits = loadPath(kChunkCone, path);
  float spread = uintBitsToFloat(coneBits.x);
  float t = uintBitsToFloat(extra.x);
  uint bounce = pathBounce(ids.w);
  vec3 throughput = throughputPdf.rgb;
  float coneWidth = uintBitsToFloat(extra.w) + spread * t;

  ShadingPoint sp = shadingPointMake(hit.x, hit.y, uintBitsToFloat(hit.zw), wo, coneWidth, uintBitsToFloat(coneBits.y));
  Closure c;
  closureMake(sp, c);
  if (kHasOpacity && passThrough(path, ids, c, hit, extra, origin, throughput, throughputPdf.a)) return;

  if ((ids.w & kFlagAovWritten) == 0u) {
    filmFirstHit(ids, sp, c);
    ids.w |= kFlagAovWritten;
  }
  if (kHasEmission) {
    vec4 radiance = uintBitsToFloat(loadPath(kChunkRadiance, path));
    storePathF(kChunkRadiance, path, contribute(radiance, throughput * surfaceEmission(sp, c, throughputPdf.a, t), coneBits.w, kNoLightGroup));
  }
  ids.w &= ~((0xffu << kPassShift) | (0xffu << kShadowPassShift));
  if (bounce >= frame.maxBounces) {
    storePath(kChunkIds, path, uvec4(ids.xyz, ids.w | kFlagEnd));
    return;
  }

  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  vec4 lightRadiance = uintBitsToFloat(loadPath(kChunkLightRadiance, path));
  vec3 wi = closureSample(c, wo, sample1D(ids.z, ids.y, bouncePair(bounce, kPairLobe)), sample2D(ids.z, ids.y, bouncePair(bounce, kPairDirection)));

  // Both directions through one evaluation site: compile time follows the sites, not the trips.
  vec4 sampled = vec4(0.0), lit = vec4(0.0);
  [[dont_unroll]] for (int i = 0; i < 2; ++i) {
    vec3 w = i == 0 ? wi : light.xyz;
    // The shading normal must not move light through the surface: both normals have to agree on the side of wi.
    vec4 value = closureEval(c, wo, w);
    if (!(dot(w, sp.normalGeometric) * dot(w, sp.normalWorld) > 0.0)) value = vec4(0.0);
    if (i == 0) sampled = value; else lit = value;
  }

  vec3 error = surfacePointError(sp.instance, gCorner0, gCorner1, gCorner2, sp.positionWorld);
  lit.rgb *= lightExtinction(path, sp, c, light);
  castShadowRay(path, ids, sp, error, hit, throughput, light, lightRadiance, coneBits.z, lit);
  if (!(sampled.a > 0.0) || !(max(sampled.r, max(sampled.g, sampled.b)) > 0.0)) {
    storePath(kChunkIds, path, uvec4(ids.xyz, ids.w | kFlagEnd));
    return;
  }
  bool front = dot(wo, sp.normalGeometric) >= 0.0;
  bool transmitted = (dot(wi, sp.normalGeometric) >= 0.0) != front;
  uint events = coneBits.w | (transmitted ? kEventTransmission : kEventReflection);
  if (kHasTransmission && transmitted) {
    uvec4 mediaA = loadPath(kChunkMediaA, path), mediaB = loadPath(kChunkMediaB, path);
    if (!crossBoundary(mediaA, mediaB, sp, c, front)) reportError(kErrorMediaStack);
    storePath(kChunkMediaA, path, mediaA);
    storePath(kChunkMediaB, path, mediaB);
  }

  storePathF(kChunkRayOrigin, path, vec4(offsetRayOrigin(sp.positionWorld, error, sp.normalGeometric, wi), 0.0));
  storePathF(kChunkRayDirection, path, vec4(wi, 3.4e38));
  // A planar surface cannot be hit again by a ray that leaves it: named, it is skipped whatever rounding says.
  storePath(kChunkHitDistance, path, uvec4(0u, hit.x, hit.y, floatBitsToUint(coneWidth)));
  storePathF(kChunkThroughput, path, vec4(throughput * sampled.rgb / sampled.a, sampled.a));
  // A rough bounce widens the cone: about the angle of the solid angle 1/pdf, bounded so that textures never turn to mush.
  storePath(kChunkCone, path, uvec4(floatBitsToUint(min(spread + 0.125 * inversesqrt(sampled.a), 0.25)), coneBits.yz, events));
  storePath(kChunkIds, path, uvec4(ids.xyz, ids.w + (1u << kBounceShift)));
  pushExtensionRay(path);
}
