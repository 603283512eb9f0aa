// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Opacity kernel: a shadow ray met a surface of this material that is not opaque; what gets through goes on.
// Reads: Ids, ShadowHit, ShadowOrigin, ShadowContribution, LightSample, Cone. Writes: ShadowContribution, Ids.
// Pushes to: shadow rays. Runs after: scatter.
void main() {
  uint path;
  if (!bucketPath(path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uvec4 hit = loadPath(kChunkShadowHit, path);
  uint instance = loadPathWord(kChunkShadowOrigin, path, 3u) & ~kShadowPassed;
  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  uvec4 contributionTriangle = loadPath(kChunkShadowContribution, path);
  vec3 contribution = uintBitsToFloat(contributionTriangle.rgb);
  ShadingPoint sp = shadingPointMake(instance, contributionTriangle.w, uintBitsToFloat(hit.xy), -light.xyz, 0.0, uintBitsToFloat(loadPathWord(kChunkCone, path, 1u)));
  contribution *= vec3(1.0) - clamp(materialOpacity(sp), vec3(0.0), vec3(1.0));
  uint passes = pathShadowPasses(ids.w);
  bool over = passes >= frame.maxTransparency;
  if (over) reportError(kErrorTransparency);
  ids.w = withPhase(ids.w, kPhaseReady);
  if (!over && !(max(contribution.r, max(contribution.g, contribution.b)) <= 0.0)) {
    ids.w += 1u << kShadowPassShift;
    storePathRgb(kChunkShadowContribution, path, contribution);
    pushShadowRay(path);
  }
  storePathWord(kChunkIds, path, 3u, ids.w);
}
