// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// One texel buffer per texture, its levels after each other: no page table, one format. Squares of a power of two only.
#include "lib/textures.glsl"
layout(binding = 46) uniform textureBuffer linearTexels;

vec4 benchRead(uint textureId, vec2 uv, float footprint) {
  uvec4 info = texelFetch(textureRecords, int(textureId));
  if (any(isnan(uv)) || any(isinf(uv))) uv = vec2(0.0);
  uv = clamp(uv, vec2(-65536.0), vec2(65536.0));
  uint lastLevel = (info.z & 0xffffu) - 1u;
  float lod = clamp(log2(max(footprint * float(max(info.x, info.y)), 1e-8)), 0.0, float(lastLevel));
  uint level0 = uint(lod);
  float levelBlend = lod - float(level0);
  vec4 result = vec4(0.0);
  [[unroll]] for (uint l = 0u; l < 2u; ++l) {
    uint level = level0 + (levelBlend > 0.0 ? l : 0u);
    int size = int(info.x >> level);
    vec2 wx, wy;
    int x = textureTaps(uv.x, size, kWrapRepeat, wx), y = textureTaps(uv.y, size, kWrapRepeat, wy);
    int nextX = x + 1 < size ? x + 1 : 0, nextY = y + 1 < size ? y + 1 : 0;
    // s^2 + (s/2)^2 + ... down to the level above: 4/3 of what lies between the squares.
    int start = int((info.x * info.x - uint(size * size)) * 4u / 3u);
    int row = start + y * size, nextRow = start + nextY * size;
    vec4 sum = wy.x * (wx.x * texelFetch(linearTexels, row + x) + wx.y * texelFetch(linearTexels, row + nextX)) +
               wy.y * (wx.x * texelFetch(linearTexels, nextRow + x) + wx.y * texelFetch(linearTexels, nextRow + nextX));
    result += (l == 0u ? 1.0 - levelBlend : levelBlend) * sum;
  }
  return result;
}
