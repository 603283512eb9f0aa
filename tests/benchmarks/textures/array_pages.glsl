// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The renderer's records, levels and pages, but the pages stand in the layers of an array image of 1024 x 1024 texels (one
// page to a layer would end at 2048 pages). An entry of the page table: layer << 20 | y << 10 | x.
#include "lib/textures.glsl"
// A scene holds both formats, and so does the contract: an array image each.
layout(binding = 43) uniform sampler2DArray byteLayers;
layout(binding = 44) uniform sampler2DArray halfLayers;

vec4 arrayBilinear(sampler2DArray pageLayers, ivec3 at, vec2 wx, vec2 wy) {
#ifdef HARDWARE_FILTER
  return textureLod(pageLayers, vec3((vec2(at.xy) + 0.5 + vec2(wx.y, wy.y)) * (1.0 / 1024.0), float(at.z)), 0.0);
#else
  return wy.x * (wx.x * texelFetch(pageLayers, at, 0) + wx.y * texelFetch(pageLayers, at + ivec3(1, 0, 0), 0)) +
         wy.y * (wx.x * texelFetch(pageLayers, at + ivec3(0, 1, 0), 0) + wx.y * texelFetch(pageLayers, at + ivec3(1, 1, 0), 0));
#endif
}

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
    ivec2 size = max(ivec2(info.xy >> level), ivec2(1));
    vec2 wx, wy;
    int x = textureTaps(uv.x, size.x, kWrapRepeat, wx), y = textureTaps(uv.y, size.y, kWrapRepeat, wy);
    uint pagesPerRow = (uint(size.x) + kPageSide - 1u) >> kPageShift;
    uint entry = texelFetch(pageTable, int(info.w + level)).x + (uint(y) >> kPageShift) * pagesPerRow + (uint(x) >> kPageShift);
    uint page = texelFetch(pageTable, int(entry)).x;
    ivec3 at = ivec3(int(page & 1023u) + (x & 63), int((page >> 10u) & 1023u) + (y & 63), int(page >> 20u));
    vec4 sum = vec4(0.0);
    if ((info.z >> 16u) == 0u) sum = arrayBilinear(byteLayers, at, wx, wy);
    else sum = arrayBilinear(halfLayers, at, wx, wy);
    result += (l == 0u ? 1.0 - levelBlend : levelBlend) * sum;
  }
  return result;
}
