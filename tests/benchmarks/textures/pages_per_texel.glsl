// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pages of 64 x 64 texels with nothing beyond, a pool per format: each texel wraps and looks up its page by itself.
// Records: width, height, levels, format; table. The table: an offset per level, then page indices.
#include "lib/bindings.glsl"
layout(binding = 43) uniform textureBuffer pagesRgba8;
layout(binding = 44) uniform textureBuffer pagesRgba16f;

int wrapTexel(int i, int size) {
  int m = i % size;
  return m < 0 ? m + size : m;
}

vec4 benchRead(uint textureId, vec2 uv, float footprint) {
  uvec4 info = texelFetch(textureRecords, int(textureId * 2u));
  uint tableBase = texelFetch(textureRecords, int(textureId * 2u + 1u)).x;
  if (any(isnan(uv)) || any(isinf(uv))) uv = vec2(0.0);
  uv = clamp(uv, vec2(-65536.0), vec2(65536.0));
  float lod = clamp(log2(max(footprint * float(max(info.x, info.y)), 1e-8)), 0.0, float(info.z - 1u));
  uint level0 = uint(lod);
  float levelBlend = lod - float(level0);
  uint levelCount = levelBlend > 0.0 ? 2u : 1u;
  vec4 result = vec4(0.0);
  [[dont_unroll]] for (uint l = 0u; l < levelCount; ++l) {
    uint level = level0 + l;
    ivec2 size = max(ivec2(info.xy >> level), ivec2(1));
    uint entryBase = tableBase + texelFetch(pageTable, int(tableBase + level)).x;
    uint pagesPerRow = (uint(size.x) + 63u) >> 6u;
    uint tailOffset = 0u;
    if (max(size.x, size.y) <= 32) {
      uint largest = max(info.x, info.y);
      uint firstTail = largest <= 32u ? 0u : uint(findMSB(largest)) - 5u + ((largest >> (uint(findMSB(largest)) - 5u)) > 32u ? 1u : 0u);
      tailOffset = 64u - (64u >> (level - firstTail));
    }
    vec2 p = uv * vec2(size) - 0.5;
    vec2 base = floor(p);
    vec2 f = p - base;
    ivec2 i0 = ivec2(base);
    vec4 sum = vec4(0.0);
    [[dont_unroll]] for (int tap = 0; tap < 4; ++tap) {
      ivec2 d = ivec2(tap & 1, tap >> 1);
      int x = wrapTexel(i0.x + d.x, size.x), y = wrapTexel(i0.y + d.y, size.y);
      float w = (d.x == 0 ? 1.0 - f.x : f.x) * (d.y == 0 ? 1.0 - f.y : f.y);
      uint page = texelFetch(pageTable, int(entryBase + (uint(y) >> 6u) * pagesPerRow + (uint(x) >> 6u))).x;
      int at = int((page << 12u) + ((uint(y) & 63u) << 6u) + ((uint(x) & 63u) + tailOffset));
      vec4 texel;
      if (info.w == 0u) texel = texelFetch(pagesRgba8, at);
      else texel = texelFetch(pagesRgba16f, at);
      sum += w * texel;
    }
    result += (l == 0u ? 1.0 - levelBlend : levelBlend) * sum;
  }
  return result;
}
