// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Materials in GLSL, by number: patterns of as many operations as are asked for, over a diffuse lobe.
#pragma once

#include <cstdint>

#include "delegate/capture/captured_scene.h"

namespace bench {

// Kernel of topology `number`: its pattern is another sequence of operations than those of other numbers. About
// `operations` of them are run for each evaluation. They stand in a straight line up to 400 of them, which a loop repeats, so
// that code and compile time stay those of a large material, not of one that nobody has.
delegate::CapturedKernel MakeKernel(uint32_t number, uint32_t operations);
// A material of it with values of its own.
wavefront::MaterialData MakeMaterial(const delegate::CapturedKernel& kernel, uint32_t number);
// A plain diffuse one.
delegate::CapturedKernel MakePlainKernel();

}  // namespace bench
