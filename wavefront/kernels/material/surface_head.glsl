// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Head of the surface kernels: what patterns and lobes may read. The generated text follows, then surface_tail.glsl.
#extension GL_GOOGLE_include_directive : require
#include "material/pattern_head.glsl"
#include "lib/media.glsl"
#include "lib/subsurface.glsl"
#include "lib/ray_offset.glsl"
#include "lib/film.glsl"
#include "lib/contribute.glsl"
#include "lib/lights/light_pick.glsl"
#include "lib/shadow_cast.glsl"
#include "lib/bsdf/subsurface.glsl"
