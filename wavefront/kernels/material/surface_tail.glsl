// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Material kernel, the part that every material shares (Laine et al. 2013): emission, pass-through by opacity, first-hit
// AOVs, then sampling a direction and weighing the light sample in one go, so that the closure can be dropped.
// Reads: RayOrigin, RayDirection, Hit, HitDistance, Throughput, Radiance, Ids, LightSample, LightRadiance, MediaStack,
// Medium, Cone.
// Writes: those of the next segment. Pushes to: extension rays, shadow rays. Runs after: scatter.

// Emission of the surface itself, weighed against the light sample that could have found it.
vec3 surfaceEmission(ShadingPoint sp, Closure c, float bsdfPdf, vec3 from, float t) {
  float weight = 1.0;
  uint itemBase = instanceWord(sp.instance, 7u).w;
  if (bsdfPdf > 0.0 && itemBase != kNoLight) {
    float pdf = lightItemProbability(itemBase + sp.triangle, from) * trianglePdf(gEdge1World, gEdge2World, sp.wo, t);
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

// The ray goes on behind this hit as if nothing were there: it keeps its origin and moves its start forward.
void passOn(uint path, uvec4 ids, uvec4 hit, float t, vec3 throughput, float bsdfPdf) {
  if (pathPasses(ids.w) >= frame.maxTransparency) {
    reportError(kErrorTransparency);
    storePathWord(kChunkIds, path, 3u, ids.w | kFlagEnd);
    return;
  }
  bool camera = pathBounce(ids.w) == 0u && (ids.w & kFlagSubsurface) == 0u;
  storePathF(kChunkThroughput, path, vec4(throughput, bsdfPdf));
  if (camera) storePathWord(kChunkHit, path, 1u, hit.y | kHitCamera);
  storePathWord(kChunkRayOrigin, path, 3u, floatBitsToUint(t));
  storePathWord(kChunkIds, path, 3u, ids.w + (1u << kPassShift));
  pushExtensionRay(path);
}

// Passing through by opacity: the surface is there with probability mean(opacity). What gets through costs no bounce.
// True: the ray goes on, this hit is done with.
bool passThrough(inout uvec4 ids, Closure c, inout vec3 throughput) {
  vec3 opacity = clamp(c.opacity, vec3(0.0), vec3(1.0));
  float present = (opacity.r + opacity.g + opacity.b) * (1.0 / 3.0);
  uint bounce = pathBounce(ids.w);
  if (samplePass(ids.z, ids.y, bounce, pathPasses(ids.w)) < present) {
    throughput *= opacity / max(present, 1e-6);
    return false;
  }
  throughput *= (vec3(1.0) - opacity) / max(1.0 - present, 1e-6);
  // The logic kernel counted this hit as coverage before it was known that the camera sees past it.
  if (bounce == 0u) ids.w &= ~kFlagCovered;
  return true;
}

// A body's boundary: the media stack beyond it, and the indices on both sides. Only what refracts has one.
struct Boundary {
  uvec4 beyond;   // the stack once the path has crossed
  bool fits;      // false: entering, and the stack is full
  bool isThere;   // false: another body of higher priority, or one entered later, fills both sides
};
Boundary boundaryMake(uvec4 stack, uint entry, bool entering, inout ShadingPoint sp) {
  Boundary b;
  b.beyond = stack;
  b.fits = true;
  // Of the same material no other body counts: a row of panes, each entered and never left, looks as it should.
  uint outside = mediumTop(stack, entry);
  if (entering) {
    b.fits = mediumEnter(b.beyond, entry);
    b.isThere = mediumPriority(entry) >= mediumPriority(outside);
  } else {
    uint inside = mediumTop(stack, 0u);
    mediumLeave(b.beyond, entry);
    // What was never entered (the camera stands inside) is left all the same.
    bool known = any(equal(stack, uvec4(entry)));
    b.isThere = !known || inside == entry;
  }
  sp.exteriorIor = mediumIor(outside);
  return b;
}

void main() {
  uint path;
  if (!bucketPath(path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  vec3 origin = uintBitsToFloat(loadPath(kChunkRayOrigin, path)).xyz;
  vec3 wo = -uintBitsToFloat(loadPath(kChunkRayDirection, path)).xyz;
  uvec4 hit = loadPath(kChunkHit, path);
  vec4 throughputPdf = uintBitsToFloat(loadPath(kChunkThroughput, path));
  uvec4 coneBits = loadPath(kChunkCone, path);
  uvec4 medium = loadPath(kChunkMedium, path);
  float spread = uintBitsToFloat(coneBits.x);
  float t = uintBitsToFloat(loadPathWord(kChunkHitDistance, path, 0u));
  uint bounce = pathBounce(ids.w);
  vec3 throughput = throughputPdf.rgb;
  float coneWidth = uintBitsToFloat(coneBits.w) + spread * t;

  ShadingPoint sp = shadingPointMake(hit.x, hit.y, uintBitsToFloat(hit.zw), wo, coneWidth, uintBitsToFloat(coneBits.y));
  bool front = sp.frontFacing;
  Boundary boundary;
  if (kHasTransmission) {
    uint priority = texelFetch(bindingRecords, int(sp.binding) + 1).w;
    boundary = boundaryMake(loadPath(kChunkMediaStack, path), mediumEntry(sp.parameterBase, priority), front, sp);
    if (!boundary.isThere) {
      storePath(kChunkMediaStack, path, boundary.beyond);
      if (!boundary.fits) reportError(kErrorMediaStack);
      passOn(path, ids, hit, t, throughput, throughputPdf.a);
      return;
    }
  }
  vec3 error = surfacePointError(sp.instance, gCorner0, gCorner1, gCorner2, sp.positionWorld);
  float shortest = 32.0 * max(error.x, max(error.y, error.z));  // of paths to walk in a medium
  if (kHasSubsurface) gSubsurfaceShortest = shortest;
  Closure c;
  closureMake(sp, c);
  if (kHasOpacity && passThrough(ids, c, throughput)) {
    // Colours were filtered, and the choice of the flight's channel follows them: a new flight from here.
    float flight = t + mediumFlight(medium, throughput, samplePass(ids.z ^ 0x3c6ef372u, ids.y, bounce, pathPasses(ids.w)));
    if (mediumScatters(medium)) storePathF(kChunkRayDirection, path, vec4(-wo, flight));
    passOn(path, ids, hit, t, throughput, throughputPdf.a);
    return;
  }

  if ((ids.w & kFlagAovWritten) == 0u) {
    filmFirstHit(ids, sp, c);
    ids.w |= kFlagAovWritten;
  }
  if (kHasEmission) {
    vec3 radiance = uintBitsToFloat(loadPath(kChunkRadiance, path)).rgb;
    radiance = contribute(radiance, throughput * surfaceEmission(sp, c, throughputPdf.a, origin, t), pathEvents(path), kNoLightGroup);
    storePathRgb(kChunkRadiance, path, radiance);
  }
  ids.w &= ~((0xffu << kPassShift) | (0xffu << kShadowPassShift) | kFlagMediumLight);
  if (bounce >= frame.maxBounces) {
    storePathWord(kChunkIds, path, 3u, ids.w | kFlagEnd);
    return;
  }

  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  vec4 lightRadiance = uintBitsToFloat(loadPath(kChunkLightRadiance, path));
  if (frame.lightItemCount == 0u) lightRadiance.a = 0.0;
  vec3 wi = closureSample(c, wo, sample1D(ids.z, ids.y, bouncePair(bounce, kPairLobe)), sample2D(ids.z, ids.y, bouncePair(bounce, kPairDirection)));

  // Both directions through one evaluation site: compile time follows the sites, not the trips.
  vec4 sampled = vec4(0.0), lit = vec4(0.0);
  vec3 sampledBelow = vec3(0.0);
  [[dont_unroll]] for (int i = 0; i < 2; ++i) {
    vec3 w = i == 0 ? wi : light.xyz;
    vec3 below = vec3(0.0);  // what of it goes on a random walk
    // The shading normal must not move light through the surface: both normals have to agree on the side of wi.
    vec4 value = closureEval(c, wo, w, below);
    if (!(dot(w, sp.normalGeometric) * dot(w, sp.normalWorld) > 0.0)) { value = vec4(0.0); below = vec3(0.0); }
    if (dot(w, sp.normalGeometric) >= 0.0 == front) below = vec3(0.0);
    if (i == 0) { sampled = value; sampledBelow = below; } else lit = value - vec4(below, 0.0);
  }

  // The medium behind a boundary that is crossed. Its own body fills it on the way in, whatever else is there.
  uvec4 beyond = medium;
  if (kHasTransmission) {
    uvec4 left = mediumOf(mediumTop(boundary.beyond, 0u));
    beyond = front ? (boundary.fits ? packMedium(walkableMedium(c.interior, shortest)) : medium) : left;
  }
  bool litBeyond = (dot(light.xyz, sp.normalGeometric) >= 0.0) != front;
  lit.rgb *= mediumTransmittance(kHasTransmission && litBeyond ? beyond : medium, abs(light.w));
  castShadowRay(path, sp.positionWorld, offsetRayOrigin(sp.positionWorld, error, sp.normalGeometric, light.xyz), hit.xy, throughput,
                light, lightRadiance, coneBits.z, lit);
  bool transmitted = (dot(wi, sp.normalGeometric) >= 0.0) != front;
  bool walks = false;
  if (kHasSubsurface && transmitted) {
    // Which of the lobes took the direction decides where it leads to; in proportion to what they let through.
    float share = bsdfMean(sampledBelow) / max(bsdfMean(sampled.rgb), 1e-20);
    walks = samplePass(ids.z ^ 0xbb67ae85u, ids.y, bounce, 0u) < share;
    if (walks) {
      SubsurfaceLobe lobe = closureWalk(c, samplePass(ids.z ^ 0xa54ff53au, ids.y, bounce, 0u), sampledBelow);
      Medium inside = subsurfaceMedium(lobe.color, lobe.radius, lobe.anisotropy, shortest);
      beyond = packMedium(inside);
      sampled.rgb = sampledBelow / (max(lobe.color, vec3(1e-6)) * max(share, 1e-6));  // the colour comes from the walk
      if (!mediumScatters(beyond)) sampled = vec4(0.0);
    } else {
      sampled.rgb = (sampled.rgb - sampledBelow) / max(1.0 - share, 1e-6);
    }
  }
  if (!(sampled.a > 0.0) || !(max(sampled.r, max(sampled.g, sampled.b)) > 0.0)) {
    storePathWord(kChunkIds, path, 3u, ids.w | kFlagEnd);
    return;
  }
  bool enters = walks;
  if (kHasTransmission) {
    if (transmitted && !walks) {
      if (!boundary.fits) reportError(kErrorMediaStack);
      storePath(kChunkMediaStack, path, boundary.beyond);
      enters = true;
    }
  }
  if (kHasTransmission || kHasSubsurface) {
    if (enters) {
      medium = beyond;
      storePath(kChunkMedium, path, medium);
      storePath(kChunkWalk, path, uvec4(0u, 0u, hit.x, 0u));
    }
  }

  // Bodies that scatter: no farther than the next event.
  throughput *= sampled.rgb / sampled.a;
  float u = kHasTransmission || kHasSubsurface ? sample1D(ids.z, ids.y, mediumPair(bounce, 0u, kMediumFlight))
                                               : samplePass(ids.z ^ 0x6a09e667u, ids.y, bounce, 0u);
  float flight = mediumFlight(medium, throughput, u);
  storePathF(kChunkRayOrigin, path, vec4(offsetRayOrigin(sp.positionWorld, error, sp.normalGeometric, wi), 0.0));
  storePathF(kChunkRayDirection, path, vec4(wi, mediumScatters(medium) ? flight : 3.4e38));
  // A planar surface cannot be hit again by a ray that leaves it: it stands in chunk Hit, and is skipped whatever rounding
  // says.
  storePathF(kChunkThroughput, path, vec4(throughput, sampled.a));
  // A rough bounce widens the cone: about the angle of the solid angle 1/pdf, bounded so that textures never turn to mush.
  storePathWord(kChunkCone, path, 0u, floatBitsToUint(min(spread + 0.125 * inversesqrt(sampled.a), 0.25)));
  storePathWord(kChunkCone, path, 3u, floatBitsToUint(coneWidth));
  setPathEvents(path, pathEvents(path) | (transmitted ? kEventTransmission : kEventReflection));
  // A walk is one bounce, counted where it leaves.
  storePathWord(kChunkIds, path, 3u, walks ? ids.w | kFlagSubsurface : ids.w + (1u << kBounceShift));
  pushExtensionRay(path);
}
