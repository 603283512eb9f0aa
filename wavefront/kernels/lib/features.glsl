// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// kHas<Feature>: false where the scene is known to have no such thing (shared/features.def). Kernels of materials and of
// tests are not made for a scene: there all are true.
#ifndef WAVEFRONT_LIB_FEATURES_GLSL
#define WAVEFRONT_LIB_FEATURES_GLSL
#define WAVEFRONT_FEATURE(Name, index, doc) layout(constant_id = 1000 + index) const bool kHas##Name = true;
#include "shared/features.def"
#undef WAVEFRONT_FEATURE
#endif
