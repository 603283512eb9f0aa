// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Head of the displacement kernels: what patterns may read at a corner of a triangle, before there are instances, rays
// and a film. The bindings hold one mesh (scheduler/displacer.cpp); world space is object space.
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
#include "lib/frame.glsl"
#include "lib/shading_point.glsl"
#include "lib/geometry.glsl"
#include "lib/textures.glsl"

// A mesh is displaced once, whatever the frame; the generator says so to who asks.
float frameNumber() { return 1.0; }
float frameSeconds() { return 0.0; }
vec3 sceneOrigin() { return vec3(0.0); }

layout(local_size_x = 64) in;
