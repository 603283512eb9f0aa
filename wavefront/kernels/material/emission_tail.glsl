// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Emission kernel: the light sample lies on an emissive triangle of this material and is seen; adds its radiance.
// Reads: Ids, ShadowContribution, LightSample, Cone, Walk, Radiance. Writes: Radiance, Ids. Runs after: scatter.
#include "lib/contribute.glsl"

vec2 emissionTriangleSample(vec2 u) {   // as sampleTriangle in lights/light_table.glsl
  if (u.y > u.x) { u.x *= 0.5; u.y -= u.x; } else { u.y *= 0.5; u.x -= u.y; }
  return vec2(1.0 - u.x - u.y, u.y);
}
void main() {
  uint path;
  if (!bucketPath(path)) return;
  uvec4 ids = loadPath(kChunkIds, path);
  uvec4 cone = loadPath(kChunkCone, path);
  vec4 light = uintBitsToFloat(loadPath(kChunkLightSample, path));
  uvec4 item = texelFetch(lightItems, int(cone.z));
  // The point that the light sample kernel found, or medium_scatter: the same random numbers give it again.
  uint bounce = pathBounce(ids.w) - ((ids.w & (kFlagEnd | kFlagSubsurface)) != 0u ? 0u : 1u);
  uint pair = (ids.w & kFlagMediumLight) != 0u ? loadPath(kChunkWalk, path).y : bouncePair(bounce, kPairLightPoint);
  vec2 b = emissionTriangleSample(sample2D(ids.z, ids.y, pair));
  ShadingPoint sp = shadingPointMake(item.x, item.y, b, -light.xyz, 0.0, uintBitsToFloat(cone.y));
  vec3 contribution = uintBitsToFloat(loadPath(kChunkShadowContribution, path).rgb) * max(materialEmission(sp), vec3(0.0));
  addSeenLight(path, contribution);
  storePathWord(kChunkIds, path, 3u, withPhase(ids.w, kPhaseReady));
}
