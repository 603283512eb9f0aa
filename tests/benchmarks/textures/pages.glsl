// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The renderer's own reader.
#include "lib/textures.glsl"

vec4 benchRead(uint textureId, vec2 uv, float footprint) {
  return textureRead(textureId, uv, footprint, kWrapRepeat, kWrapRepeat, vec4(0.0));
}
