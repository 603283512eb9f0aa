// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#ifndef WAVEFRONT_BSDF_SHEEN_ALBEDO_GLSL
#define WAVEFRONT_BSDF_SHEEN_ALBEDO_GLSL
#include "bsdf_common.glsl"
float sheenContyKullaReflectance(float cosO, float r) { return 0.1; }
#endif
