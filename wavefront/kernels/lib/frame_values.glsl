// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What patterns ask of the frame. Displacement runs before there is one: its head has functions of its own.
#ifndef WAVEFRONT_LIB_FRAME_VALUES_GLSL
#define WAVEFRONT_LIB_FRAME_VALUES_GLSL
#include "lib/bindings.glsl"

float frameNumber() { return frame.frameNumber; }
float frameSeconds() { return frame.timeSeconds; }
vec3 sceneOrigin() { return frame.sceneOrigin.xyz; }
#endif
