// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Items of eight textures in one dispatch, without indexing descriptors by a variable (which lavapipe 22.3.6 lacks).
#define PLAIN_COUNT 8
#include "plain.glsl"
#define benchRead benchSwitch

vec4 benchSwitch(uint textureId, vec2 uv, float footprint) {
  switch (textureId) {
    case 0u: return PLAIN_READ(0);
    case 1u: return PLAIN_READ(1);
    case 2u: return PLAIN_READ(2);
    case 3u: return PLAIN_READ(3);
    case 4u: return PLAIN_READ(4);
    case 5u: return PLAIN_READ(5);
    case 6u: return PLAIN_READ(6);
    default: return PLAIN_READ(7);
  }
}
