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

// A texel of the pool, counted from its start in texels of the format; bytes as 0 to 255, words as 0 to 65535. All formats
// are unpacked from one fetch of 16 bytes: software devices pay for both sides of a branch, and fetches cost more than
// arithmetic.
vec4 textureTexel(uint format, int at) {
  bool isBytes = format == kTexelBytes;
  uvec4 words = texelFetch(texturePages, format == kTexelFloats ? at : at >> (isBytes ? 2 : 1));
  uvec2 pair = (at & (isBytes ? 2 : 1)) == 0 ? words.xy : words.zw;
  uint bytes = (at & 1) == 0 ? pair.x : pair.y;
  uvec2 low = isBytes ? uvec2(bytes, bytes >> 16u) : pair;
  uvec2 next = low >> (isBytes ? 8u : 16u);
  uint mask = isBytes ? 255u : 65535u;
  vec4 whole = vec4(ivec4(low.x & mask, next.x & mask, low.y & mask, next.y & mask));
  vec4 halfs = vec4(unpackHalf2x16(pair.x), unpackHalf2x16(pair.y));
  return format == kTexelHalfs ? halfs : format == kTexelFloats ? uintBitsToFloat(words) : whole;
}

// The four texels of a bilinear read of a level: where the lower left one stands, and the weights of columns and rows.
struct TextureFour {
  int at;
  vec2 columns, rows;
};
TextureFour textureFour(uvec4 info, uint level, vec2 uv, uint wrapU, uint wrapV) {
  ivec2 size = max(ivec2(info.xy >> level), ivec2(1));
  TextureFour four;
  int x = textureTaps(uv.x, size.x, wrapU, four.columns), y = textureTaps(uv.y, size.y, wrapV, four.rows);
  uint pagesPerRow = (uint(size.x) + kPageSide - 1u) >> kPageShift;
  uint entry = texelFetch(pageTable, int(info.w + level)).x + (uint(y) >> kPageShift) * pagesPerRow + (uint(x) >> kPageShift);
  int page = int(texelFetch(pageTable, int(entry)).x);
  const int inside = int(kPageSide) - 1;
  four.at = page + (y & inside) * int(kPagePitch) + (x & inside);
  return four;
}
vec4 textureSum(uint format, TextureFour four) {
  int at = four.at;
  const int pitch = int(kPagePitch);
  return four.rows.x * (four.columns.x * textureTexel(format, at) + four.columns.y * textureTexel(format, at + 1)) +
         four.rows.y * (four.columns.x * textureTexel(format, at + pitch) + four.columns.y * textureTexel(format, at + pitch + 1));
}
float textureScale(uint format) { return format == kTexelBytes ? 1.0 / 255.0 : format == kTexelWords ? 1.0 / 65535.0 : 1.0; }
float textureOutside(TextureFour four) { return 1.0 - (four.columns.x + four.columns.y) * (four.rows.x + four.rows.y); }

// The tile of a set that holds uv: its texture, 0xffffffff where there is none; uv moves into it.
uint textureTile(uint setId, inout vec2 uv) {
  if (setId == 0xffffffffu || any(isnan(uv)) || any(isinf(uv))) return 0xffffffffu;
  uvec4 info = texelFetch(textureRecords, int(setId));
  vec2 tile = floor(uv);
  if (any(lessThan(tile, vec2(0.0))) || any(greaterThanEqual(tile, vec2(info.xy)))) return 0xffffffffu;
  uv -= tile;
  return texelFetch(pageTable, int(info.w + uint(tile.y) * info.x + uint(tile.x))).x;
}

float textureLevels(uvec4 info, float footprint) {
  float last = float(info.z & 0xffffu) - 1.0;
  return clamp(log2(max(footprint * float(max(info.x, info.y)), 1e-8)), 0.0, last);
}
// Keeps integers in range: a repeat of 2^20 texels is far past what float uv resolves.
vec2 textureCoordinates(vec2 uv) {
  if (any(isnan(uv)) || any(isinf(uv))) uv = vec2(0.0);
  return clamp(uv, vec2(-65536.0), vec2(65536.0));
}

// Trilinear.
vec4 textureRead(uint textureId, vec2 uv, float footprint, uint wrapU, uint wrapV, vec4 outside) {
  if (textureId == 0xffffffffu) return outside;
  uvec4 info = texelFetch(textureRecords, int(textureId));
  uv = textureCoordinates(uv);
  uint format = info.z >> 16u;
  float lod = textureLevels(info, footprint);
  uint level = uint(lod);
  float blend = lod - float(level);
  // Both levels in a row, not as a loop: the loop ran longer, and compiled no faster. Where one level is wanted it is
  // read twice: the second time from the cache.
  TextureFour fine = textureFour(info, level, uv, wrapU, wrapV);
  TextureFour coarse = textureFour(info, level + (blend > 0.0 ? 1u : 0u), uv, wrapU, wrapV);
  float beyond = mix(textureOutside(fine), textureOutside(coarse), blend), scale = textureScale(format);
  fine.rows *= (1.0 - blend) * scale;
  coarse.rows *= blend * scale;
  vec4 sum = textureSum(format, fine) + textureSum(format, coarse);
  return wrapU == kWrapBlack || wrapV == kWrapBlack ? sum + beyond * outside : sum;
}

// The nearest texel of the nearest level.
vec4 textureReadClosest(uint textureId, vec2 uv, float footprint, uint wrapU, uint wrapV, vec4 outside) {
  if (textureId == 0xffffffffu) return outside;
  uvec4 info = texelFetch(textureRecords, int(textureId));
  uint format = info.z >> 16u;
  uint level = uint(textureLevels(info, footprint) + 0.5);
  vec2 size = vec2(max(ivec2(info.xy >> level), ivec2(1)));
  uv = (floor(textureCoordinates(uv) * size) + 0.5) / size;
  TextureFour four = textureFour(info, level, uv, wrapU, wrapV);
  four.columns = round(four.columns);
  four.rows = round(four.rows);
  float beyond = textureOutside(four);
  four.rows *= textureScale(format);
  vec4 texel = textureSum(format, four);
  return wrapU == kWrapBlack || wrapV == kWrapBlack ? texel + beyond * outside : texel;
}

// Weight of the two later ones of the four texels that a cubic B-spline takes, and where, from the second texel's centre,
// linear reads give the two sums: Sigg and Hadwiger, "Fast Third-Order Texture Filtering" (GPU Gems 2, chapter 20).
void textureSpline(float f, out float later, out vec2 places) {
  float g = 1.0 - f;
  vec4 w = vec4(g * g * g, 4.0 - 3.0 * f * f * (2.0 - f), 4.0 - 3.0 * g * g * (2.0 - g), f * f * f) * (1.0 / 6.0);
  later = w.z + w.w;
  places = vec2(w.y / (w.x + w.y) - 1.0, w.w / later + 1.0);
}

// Cubic B-spline in each level, levels blended: it smooths, as OpenImageIO's "bicubic" does.
vec4 textureReadCubic(uint textureId, vec2 uv, float footprint, uint wrapU, uint wrapV, vec4 outside) {
  if (textureId == 0xffffffffu) return outside;
  uvec4 info = texelFetch(textureRecords, int(textureId));
  uv = textureCoordinates(uv);
  uint format = info.z >> 16u;
  float lod = textureLevels(info, footprint);
  uint level = uint(lod);
  float blend = lod - float(level), scale = textureScale(format);
  vec4 sum = vec4(0.0);
  [[dont_unroll]] for (uint k = 0u; k < 4u; ++k) {
    bool right = (k & 1u) != 0u, above = k >= 2u;
    TextureFour fours[2];
    float beyond = 0.0;
    [[unroll]] for (uint l = 0u; l < 2u; ++l) {
      uint at = level + (blend > 0.0 ? l : 0u);
      vec2 size = vec2(max(ivec2(info.xy >> at), ivec2(1)));
      vec2 texels = uv * size - 0.5, base = floor(texels);
      vec2 later, px, py;
      textureSpline(texels.x - base.x, later.x, px);
      textureSpline(texels.y - base.y, later.y, py);
      vec2 place = (base + vec2(right ? px.y : px.x, above ? py.y : py.x) + 0.5) / size;
      float weight = (right ? later.x : 1.0 - later.x) * (above ? later.y : 1.0 - later.y) * (l == 0u ? 1.0 - blend : blend);
      fours[l] = textureFour(info, at, place, wrapU, wrapV);
      beyond += weight * textureOutside(fours[l]);
      fours[l].rows *= weight * scale;
    }
    sum += textureSum(format, fours[0]) + textureSum(format, fours[1]);
    if (wrapU == kWrapBlack || wrapV == kWrapBlack) sum += beyond * outside;
  }
  return sum;
}
#endif
