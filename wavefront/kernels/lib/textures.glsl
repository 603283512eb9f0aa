// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Filtered texture reads through the one texel contract: a page table and one texel-buffer pool for all formats.
// No image descriptor is named, so any material runs in any scene; filtering is exact and the same on every device.
// A page holds 64 x 64 texels of a level and the column and row after them (of the last ones: the first, as repeating
// has it), so that one look-up serves the four texels of a bilinear read. See scene/texture_store.cpp for the writer, and
// ARCHITECTURE.md for what other forms cost.
#ifndef WAVEFRONT_LIB_TEXTURES_GLSL
#define WAVEFRONT_LIB_TEXTURES_GLSL
#include "lib/bindings.glsl"

const uint kWrapRepeat = 0u, kWrapClamp = 1u, kWrapMirror = 2u, kWrapBlack = 3u;

bool textureExists(uint textureId) { return textureId != 0xffffffffu; }

// The lower of the two texels that a coordinate lies between, always inside of the level, and the weights of it and of
// the next. The coordinate is folded instead of the texels: no division by the size, which processors do one lane at a
// time. Clamped and mirrored coordinates stay between the outermost texels' centres, where both taps would be the same
// texel; Black gives no weight to texels outside.
int textureTaps(float u, int size, uint mode, out vec2 weights) {
  float last = float(size) - 1.0;
  float folded = mode == kWrapRepeat ? u - floor(u) : mode == kWrapMirror ? abs(u - 2.0 * roundEven(0.5 * u)) : u;
  float p = folded * float(size) - 0.5;
  if (mode == kWrapClamp || mode == kWrapMirror) p = clamp(p, 0.0, last);
  float lower = floor(p);
  float f = p - lower;
  int texel = int(lower);
  weights = vec2(1.0 - f, f);
  if (mode == kWrapRepeat) return texel < 0 ? size - 1 : texel;
  if (mode == kWrapBlack) {
    weights = vec2(texel >= 0 && texel < size ? weights.x : 0.0, texel >= -1 && texel < size - 1 ? weights.y : 0.0);
    if (texel == -1) weights = weights.yx;
  }
  return clamp(texel, 0, size - 1);
}

// A texel of the pool, counted from its start in texels of the format. Bytes come as 0 to 255. Both formats are unpacked
// from one fetch: software devices pay for both sides of a branch, and fetches cost more than arithmetic.
vec4 textureTexel(bool isHalf, int at) {
  uvec2 pair = texelFetch(texturePages, isHalf ? at : at >> 1).xy;
  int bytes = int((at & 1) == 0 ? pair.x : pair.y);
  vec4 fromBytes = vec4(bytes & 255, (bytes >> 8) & 255, (bytes >> 16) & 255, (bytes >> 24) & 255);
  vec4 fromHalfs = vec4(unpackHalf2x16(pair.x), unpackHalf2x16(pair.y));
  return isHalf ? fromHalfs : fromBytes;
}

// The tile of a set that holds uv: its texture, 0xffffffff where there is none; uv moves into it.
uint textureTile(uint setId, inout vec2 uv) {
  if (setId == 0xffffffffu || any(isnan(uv)) || any(isinf(uv))) return 0xffffffffu;
  uvec4 info = texelFetch(textureRecords, int(setId));
  vec2 tile = floor(uv);
  if (any(lessThan(tile, vec2(0.0))) || any(greaterThanEqual(tile, vec2(info.xy)))) return 0xffffffffu;
  uv -= tile;
  return texelFetch(pageTable, int(info.w + uint(tile.y) * info.x + uint(tile.x))).x;
}

vec4 textureRead(uint textureId, vec2 uv, float footprint, uint wrapU, uint wrapV, vec4 outside) {
  if (textureId == 0xffffffffu) return outside;
  uvec4 info = texelFetch(textureRecords, int(textureId));
  if (any(isnan(uv)) || any(isinf(uv))) uv = vec2(0.0);
  // Keep integers in range: a repeat of 2^20 texels is far past what float uv resolves.
  uv = clamp(uv, vec2(-65536.0), vec2(65536.0));
  uint lastLevel = (info.z & 0xffffu) - 1u;
  bool isHalf = (info.z >> 16u) != 0u;
  float lod = clamp(log2(max(footprint * float(max(info.x, info.y)), 1e-8)), 0.0, float(lastLevel));
  uint level0 = uint(lod);
  float levelBlend = lod - float(level0);

  vec4 result = vec4(0.0);
  // Both levels in a row, not as a loop: the loop ran longer, and compiled no faster. Where one level is wanted it is
  // read twice: the second time from the cache.
  [[unroll]] for (uint l = 0u; l < 2u; ++l) {
    uint level = level0 + (levelBlend > 0.0 ? l : 0u);
    ivec2 size = max(ivec2(info.xy >> level), ivec2(1));
    vec2 wx, wy;
    int x = textureTaps(uv.x, size.x, wrapU, wx), y = textureTaps(uv.y, size.y, wrapV, wy);
    uint pagesPerRow = (uint(size.x) + kPageSide - 1u) >> kPageShift;
    uint entry = texelFetch(pageTable, int(info.w + level)).x + (uint(y) >> kPageShift) * pagesPerRow + (uint(x) >> kPageShift);
    int page = int(texelFetch(pageTable, int(entry)).x);
    const int inside = int(kPageSide) - 1, pitch = int(kPagePitch);
    int at = page + (y & inside) * pitch + (x & inside);
    vec4 sum = wy.x * (wx.x * textureTexel(isHalf, at) + wx.y * textureTexel(isHalf, at + 1)) +
               wy.y * (wx.x * textureTexel(isHalf, at + pitch) + wx.y * textureTexel(isHalf, at + pitch + 1));
    sum *= isHalf ? 1.0 : 1.0 / 255.0;
    if (wrapU == kWrapBlack || wrapV == kWrapBlack) sum += (1.0 - (wx.x + wx.y) * (wy.x + wy.y)) * outside;
    result += (l == 0u ? 1.0 - levelBlend : levelBlend) * sum;
  }
  return result;
}
#endif
