// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Walking the light tree (scene/light_tree.h). Importance of a node as seen from a point: Conty Estevez and Kulla 2018,
// section 5, without the receiver's normal: only the point is known again when a bounce ray finds a light, and there the
// probability has to be the same.
#ifndef WAVEFRONT_LIGHTS_LIGHT_TREE_GLSL
#define WAVEFRONT_LIGHTS_LIGHT_TREE_GLSL
#include "lib/bindings.glsl"

// Light from that cluster that may arrive at p, up to a factor; 0 only where none can.
float lightNodeImportance(uint node, vec3 p, out uint reference) {
  int texel = int(frame.lightTree + node * kLightNodeTexels);
  vec4 sphere = uintBitsToFloat(texelFetch(lightItems, texel));
  uvec4 rest = texelFetch(lightItems, texel + 1);
  reference = rest.w;
  vec3 d = p - sphere.xyz;
  float d2 = dot(d, d), r2 = sphere.w * sphere.w;
  float power = uintBitsToFloat(rest.z);
  if (!(d2 > r2)) return r2 > 0.0 ? power / r2 : power;  // from inside, light comes from all sides

  vec2 oct = unpackSnorm2x16(rest.x);
  vec3 axis = vec3(oct, 1.0 - abs(oct.x) - abs(oct.y));
  if (axis.z < 0.0) axis.xy = (1.0 - abs(axis.yx)) * vec2(axis.x < 0.0 ? -1.0 : 1.0, axis.y < 0.0 ? -1.0 : 1.0);
  vec2 cones = unpackUnorm2x16(rest.y) * 2.0 - 1.0;
  float cosine = dot(normalize(axis), d) * inversesqrt(d2);
  if ((rest.w & kLightNodeTwoSided) != 0u) cosine = abs(cosine);
  // The least angle between a normal in the cone and a direction from the sphere to p. Cosines and sines of differences
  // that stop at 0.
  float sine = sqrt(max(0.0, 1.0 - cosine * cosine)), sinO = sqrt(max(0.0, 1.0 - cones.x * cones.x));
  bool within = cosine > cones.x;
  float cosX = within ? 1.0 : cosine * cones.x + sine * sinO;
  float sinX = within ? 0.0 : sine * cones.x - cosine * sinO;
  float sinU2 = r2 / d2, cosU = sqrt(max(0.0, 1.0 - sinU2));
  float least = cosX > cosU ? 1.0 : cosX * cosU + sinX * sqrt(sinU2);
  // Packed angles are off by at most this.
  if (least < cones.y - 1e-3) return 0.0;
  return power * max(least, 1e-3) / d2;
}

// From the root to a leaf: by u, a uniform number, or, where `trail` is to be followed, by its bits. Returns the item
// (kNoLight: no light reaches p) and the probability of it.
uint lightTreeWalk(vec3 p, bool follow, uint trail, float u, out float probability) {
  uint reference = texelFetch(lightItems, int(frame.lightTree) + 1).w;
  probability = 1.0;
  uint depth = 0u;
  [[dont_unroll]] while ((reference & kLightNodeLeaf) == 0u) {
    // One site for both children: compile time follows the sites.
    uint child = reference & kLightNodeMask;
    vec2 importance = vec2(0.0);
    uvec2 below;
    [[dont_unroll]] for (uint c = 0u; c < 2u; ++c) {
      uint to;
      float i = lightNodeImportance(child + c, p, to);
      if (c == 0u) { importance.x = i; below.x = to; } else { importance.y = i; below.y = to; }
    }
    float sum = importance.x + importance.y;
    if (!(sum > 0.0)) { probability = 0.0; return kNoLight; }
    float q = importance.x / sum;
    bool right = follow ? ((trail >> depth) & 1u) != 0u : u >= q;
    probability *= right ? 1.0 - q : q;
    // The rest of u is uniform again; halves of its bits are spent on the way down, so deep trees stir it.
    u = clamp(right ? (u - q) / (1.0 - q) : u / q, 0.0, 0.99999994);
    reference = right ? below.y : below.x;
    ++depth;
    if (depth % 10u == 0u) u = float((floatBitsToUint(u) * 0x9e3779b9u) >> 8) * 5.9604645e-8;
  }
  return reference & kLightNodeMask;
}
#endif
