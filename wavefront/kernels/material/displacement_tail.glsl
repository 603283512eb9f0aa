// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Displacement kernel: how far the material moves each corner of the listed triangles. A point where triangles meet moves
// by the mean over its corners (scene/displacement.h), so seams and subsets leave no gap.
// Reads: mesh record, index stream, primvar stream, binding record, parameters, textures. Writes: Resolve (3 floats a
// corner, object space). Runs: in the commit, before the mesh's BVH is built.
// Push constants: triangles in the list, where it starts in the index stream, the binding record, where the positions
// start in the primvar stream.
ShadingPoint displacementPoint(uint triangle, uint corner) {
  ShadingPoint sp;
  sp.instance = 0u;
  sp.triangle = triangle;
  sp.mesh = 0u;
  sp.binding = pushWord2;
  sp.parameterBase = texelFetch(bindingRecords, int(sp.binding)).w;
  sp.barycentric = vec2(corner == 1u ? 1.0 : 0.0, corner == 2u ? 1.0 : 0.0);
  sp.time = 0.0;
  uint indexBase = texelFetch(meshRecords, 0).x, normalBase = texelFetch(meshRecords, 1).x;
  // The corner's own position and normal to the bit, not interpolated.
  [[dont_unroll]] for (uint c = 0u; c < 3u; ++c) {
    uint point = texelFetch(indexStream, int(indexBase + 3u * triangle + c)).x;
    int at = int(pushWord3 + 3u * point);
    vec3 p = vec3(texelFetch(primvarStream, at).x, texelFetch(primvarStream, at + 1).x, texelFetch(primvarStream, at + 2).x);
    if (c == 0u) gCorner0 = p;
    if (c == 1u) gCorner1 = p;
    if (c == 2u) gCorner2 = p;
    if (c == corner) {
      int n = int(normalBase + 3u * point);
      sp.positionObject = p;
      sp.normalWorld = vec3(texelFetch(primvarStream, n).x, texelFetch(primvarStream, n + 1).x, texelFetch(primvarStream, n + 2).x);
    }
  }
  sp.positionWorld = sp.positionObject;
  gEdge1World = gCorner1 - gCorner0;
  gEdge2World = gCorner2 - gCorner0;
  vec3 across = cross(gEdge1World, gEdge2World);
  float twiceArea = length(across);
  sp.normalGeometric = twiceArea > 0.0 ? across / twiceArea : sp.normalWorld;
  sp.wo = sp.normalWorld;
  sp.frontFacing = true;
  // Textures are filtered over what a point of the mesh stands for: the side of a square of two triangles.
  sp.footprint = sqrt(twiceArea);
  return sp;
}
void main() {
  uint item = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u + gl_GlobalInvocationID.x;
  if (item >= 3u * pushBucket) return;
  uint triangle = texelFetch(indexStream, int(pushWord1 + item / 3u)).x;
  vec3 offset = materialDisplacement(displacementPoint(triangle, item % 3u));
  resolved[3u * item] = floatBitsToUint(offset.x);
  resolved[3u * item + 1u] = floatBitsToUint(offset.y);
  resolved[3u * item + 2u] = floatBitsToUint(offset.z);
}
