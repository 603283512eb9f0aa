// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Opacity kernel: a shadow ray met a surface of this material that is not opaque; what gets through goes on.
// Reads: Ids, ShadowHit, ShadowOrigin, ShadowContribution, LightSample. Writes: ShadowContribution, Ids.
// Pushes to: shadow rays. Runs after: scatter.
void main() {
  uint path;
  if (!bucketPath(path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uvec4 hit = loadPath(kChunkShadowHit, path);
  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  uvec4 contributionItem = loadPath(kChunkShadowContribution, path);
  vec3 contribution = uintBitsToFloat(contributionItem.rgb);
  ShadingPoint sp = shadingPointMake(hit.x, hit.y, uintBitsToFloat(hit.zw), -light.xyz, 0.0, uintBitsToFloat(loadPath(kChunkCone, path)).y);
  contribution *= vec3(1.0) - clamp(materialOpacity(sp), vec3(0.0), vec3(1.0));
  uint passes = pathShadowPasses(ids.w);
  bool over = passes >= frame.maxTransparency;
  if (over) reportError(kErrorTransparency);
  ids.w = withPhase(ids.w, kPhaseReady);
  if (!over && !(max(contribution.r, max(contribution.g, contribution.b)) <= 0.0)) {
    ids.w += 1u << kShadowPassShift;
    storePath(kChunkShadowContribution, path, uvec4(floatBitsToUint(contribution), contributionItem.w));
    pushShadowRay(path);
  }
  storePathWord(kChunkIds, path, 3u, ids.w);
}
