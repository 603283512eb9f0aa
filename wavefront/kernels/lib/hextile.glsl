// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Hex-tiled images and normal maps: Mikkelsen, "Practical Real-Time Hex-Tiling" (JCGT 11-2, 2022), with the inputs of
// MaterialX's hextiledimage and hextilednormalmap. Every point lies in three overlapping tiles; each reads the image
// turned, scaled and moved by random amounts of its own.
#ifndef WAVEFRONT_LIB_HEXTILE_GLSL
#define WAVEFRONT_LIB_HEXTILE_GLSL
#include "lib/textures.glsl"

const float kHexScale = 3.4641016151377544;  // 2 sqrt(3): tiles as large as the image

// Two random numbers from the tile's integer coordinates; those that MaterialX uses, so that pictures match.
vec2 hexRandom(vec2 p) {
  vec3 q = fract(p.xyx * vec3(0.1031, 0.1030, 0.0973));
  q += dot(q, q.yzx + 33.33);
  return fract((q.xx + q.yz) * q.zy);
}

// The corners of the triangle of tile centres around a point, and the point's barycentric weights.
struct HexCorners {
  vec2 first, second, third;
  vec3 weights;
};
HexCorners hexCorners(vec2 uv) {
  vec2 skewed = mat2(1.0, 0.0, -0.57735027, 1.15470054) * (uv * kHexScale);
  vec2 base = floor(skewed), inside = skewed - base;
  float rest = 1.0 - inside.x - inside.y;
  bool isUpper = rest <= 0.0;
  HexCorners c;
  c.first = base + (isUpper ? vec2(1.0) : vec2(0.0));
  c.second = base + (isUpper ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
  c.third = base + (isUpper ? vec2(0.0, 1.0) : vec2(1.0, 0.0));
  c.weights = isUpper ? vec3(-rest, 1.0 - inside.yx) : vec3(rest, inside.yx);
  return c;
}

// Where a tile reads. amounts: rotation, scale, offset, falloff; ranges: of rotation (degrees) and scale.
struct HexTile {
  vec2 uv;
  float angle, scale;
};
HexTile hexTile(vec2 id, vec2 uv, vec4 amounts, vec4 ranges, vec2 offsets) {
  vec2 random = hexRandom(id + 0.12345);
  vec2 centre = mat2(1.0, 0.0, 0.5, 1.0 / 1.15470054) * (id / kHexScale);
  HexTile tile;
  tile.angle = radians(mix(ranges.x, ranges.y, random.x * amounts.x));
  tile.scale = mix(1.0, mix(ranges.z, ranges.w, random.y), amounts.y);
  float s = sin(tile.angle), c = cos(tile.angle);
  vec2 turned = (uv - centre) * mat2(c, -s, s, c);
  tile.uv = turned / tile.scale + centre + mix(offsets.xx, offsets.yy, random * amounts.z);
  return tile;
}

// Schlick, "Fast Alternatives to Perlin's Bias and Gain Functions" (Graphics Gems IV, 1994).
float hexGain(float x, float gain) {
  float a = (1.0 / clamp(gain, 0.001, 0.999) - 2.0) * (1.0 - 2.0 * x);
  return x < 0.5 ? x / (a + 1.0) : (a - x) / (a - 1.0);
}
vec3 hexWeights(vec3 contrast, vec3 weights, float falloff) {
  vec3 w = contrast * pow(max(weights, vec3(0.0)), vec3(7.0));
  w /= w.x + w.y + w.z;
  if (falloff != 0.5) {
    w = vec3(hexGain(w.x, falloff), hexGain(w.y, falloff), hexGain(w.z, falloff));
    w /= w.x + w.y + w.z;
  }
  return w;
}

// luminance: coefficients, and how far brighter tiles win over others.
vec4 hexTiledImage(uint textureId, vec2 uv, float footprint, vec4 amounts, vec4 ranges, vec2 offsets, vec4 luminance,
                   vec4 fallback) {
  if (!textureExists(textureId)) return fallback;
  HexCorners corners = hexCorners(uv);
  vec4 first, second, third;
  [[dont_unroll]] for (uint i = 0u; i < 3u; ++i) {
    HexTile tile = hexTile(i == 0u ? corners.first : i == 1u ? corners.second : corners.third, uv, amounts, ranges, offsets);
    vec4 texel = textureRead(textureId, tile.uv, footprint / max(abs(tile.scale), 1e-6), kWrapRepeat, kWrapRepeat, fallback);
    if (i == 0u) first = texel;
    if (i == 1u) second = texel;
    third = texel;
  }
  vec3 bright = vec3(dot(first.rgb, luminance.xyz), dot(second.rgb, luminance.xyz), dot(third.rgb, luminance.xyz));
  vec3 w = hexWeights(mix(vec3(1.0), bright, luminance.w), corners.weights, amounts.w);
  vec3 a = hexWeights(vec3(1.0), corners.weights, amounts.w);
  return vec4(w.x * first.rgb + w.y * second.rgb + w.z * third.rgb, dot(a, vec3(first.a, second.a, third.a)));
}

vec3 hexRotate(vec3 v, vec3 axis, float angle) {
  float c = cos(angle);
  return v * c + cross(axis, v) * sin(angle) + axis * (dot(axis, v) * (1.0 - c));
}

// strength: of the map; green upside down; range of offsets. Gradients are blended: Mikkelsen, "Surface Gradient-Based
// Bump Mapping Framework" (JCGT 9-3, 2020).
vec3 hexTiledNormal(uint textureId, vec2 uv, float footprint, vec4 amounts, vec4 ranges, vec4 strength, vec3 fallback,
                    vec3 n, vec3 t, vec3 b) {
  if (!textureExists(textureId)) return n;
  HexCorners corners = hexCorners(uv);
  vec3 weights = clamp(hexWeights(vec3(1.0), corners.weights, amounts.w), vec3(0.0), vec3(1.0));
  vec3 gradient = vec3(0.0);
  [[dont_unroll]] for (uint i = 0u; i < 3u; ++i) {
    HexTile tile = hexTile(i == 0u ? corners.first : i == 1u ? corners.second : corners.third, uv, amounts, ranges, strength.zw);
    vec3 texel = textureRead(textureId, tile.uv, footprint / max(abs(tile.scale), 1e-6), kWrapRepeat, kWrapRepeat, vec4(fallback, 1.0)).xyz;
    if (strength.y != 0.0) texel.y = 1.0 - texel.y;
    texel = 2.0 * texel - 1.0;
    vec3 bent = normalize(hexRotate(t, n, tile.angle) * (texel.x * strength.x) +
                          hexRotate(b, n, tile.angle) * (texel.y * strength.x) + n * texel.z);
    float d = dot(n, bent);
    gradient += (i == 0u ? weights.x : i == 1u ? weights.y : weights.z) * (d * n - bent) / max(abs(d), 1e-8);
  }
  return normalize(n - gradient);
}
#endif
