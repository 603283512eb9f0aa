// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Several materials in one GLSL program: what the megakernel is made of.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace materialgen {

// Names that a GLSL text declares outside of every function: functions, structures and their like, constants, variables.
// Text of includes and macros is not looked into.
std::set<std::string> TopLevelNames(std::string_view text);

// The text with `countLoop()` (kernels/megakernel/queue.glsl) in the condition of every for and while.
std::string WithCountedLoops(std::string_view text);

}  // namespace materialgen
