// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Filtered texture reads through the one texel contract: a page table and one texel-buffer pool per format.
// No image descriptor is named, so any material runs in any scene; filtering is exact and the same on every device.
// Levels whose larger side is at most 32 texels share one page (the mip tail), side by side.
#ifndef WAVEFRONT_LIB_TEXTURES_GLSL
#define WAVEFRONT_LIB_TEXTURES_GLSL
#include "lib/bindings.glsl"

const uint kWrapRepeat = 0u, kWrapClamp = 1u, kWrapMirror = 2u, kWrapBlack = 3u;

bool textureExists(uint textureId) { return textureId != 0xffffffffu; }

// Wraps a texel coordinate; -1: outside (Black).
int wrapTexel(int i, int size, uint mode) {
  if (mode == kWrapRepeat) { int m = i % size; return m < 0 ? m + size : m; }
  if (mode == kWrapMirror) { int p = 2 * size; int m = i % p; m = m < 0 ? m + p : m; return m < size ? m : p - 1 - m; }
  if (mode == kWrapClamp) return clamp(i, 0, size - 1);
  return i >= 0 && i < size ? i : -1;
}

vec4 textureRead(uint textureId, vec2 uv, float footprint, uint wrapU, uint wrapV, vec4 outside) {
  if (textureId == 0xffffffffu) return outside;
  uvec4 info = texelFetch(textureRecords, int(textureId * kTextureTexels));       // width, height, levels, format
  uint tableBase = texelFetch(textureRecords, int(textureId * kTextureTexels + 1u)).x;
  if (any(isnan(uv)) || any(isinf(uv))) uv = vec2(0.0);
  // Keep integers in range: a repeat of 2^20 texels is far past what float uv resolves.
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
    uint pagesPerRow = (uint(size.x) + 63u) >> kPageShift;
    // Tail levels stand side by side in one page: the k-th tail level starts at 64 - (64 >> k).
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
      int x = wrapTexel(i0.x + d.x, size.x, wrapU);
      int y = wrapTexel(i0.y + d.y, size.y, wrapV);
      float w = (d.x == 0 ? 1.0 - f.x : f.x) * (d.y == 0 ? 1.0 - f.y : f.y);
      vec4 texel = outside;
      if (x >= 0 && y >= 0) {
        uint entry = entryBase + (uint(y) >> kPageShift) * pagesPerRow + (uint(x) >> kPageShift);
        uint page = texelFetch(pageTable, int(entry)).x;
        int at = int((page << (2u * kPageShift)) + ((uint(y) & 63u) << kPageShift) + ((uint(x) & 63u) + tailOffset));
        if (info.w == 0u) texel = texelFetch(pagesRgba8, at);
        else texel = texelFetch(pagesRgba16f, at);
      }
      sum += w * texel;
    }
    result += (l == 0u ? 1.0 - levelBlend : levelBlend) * sum;
  }
  return result;
}
#endif
