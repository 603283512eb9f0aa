// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Head of the opacity and emission kernels: what patterns may read.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/sampler.glsl"
#include "lib/frame.glsl"
#include "lib/frame_values.glsl"
#include "lib/shading_point.glsl"
#include "lib/geometry.glsl"
#include "lib/textures.glsl"

layout(local_size_x = 64) in;
