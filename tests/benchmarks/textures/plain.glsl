// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// One image descriptor per texture, named by the kernel. PLAIN: which of the array (a constant, 0 where it is not defined).
#include "lib/bindings.glsl"
#ifndef PLAIN
#define PLAIN 0
#endif
#ifndef PLAIN_COUNT
#define PLAIN_COUNT 1
#endif
layout(binding = 45) uniform sampler2D plainTextures[PLAIN_COUNT];

float plainLevel(ivec2 size, float footprint) { return log2(max(footprint * float(max(size.x, size.y)), 1e-8)); }

#define PLAIN_READ(index) textureLod(plainTextures[index], uv, plainLevel(textureSize(plainTextures[index], 0), footprint))
vec4 benchRead(uint textureId, vec2 uv, float footprint) { return PLAIN_READ(PLAIN); }
