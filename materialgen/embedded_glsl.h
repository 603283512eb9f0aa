// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <string>
#include <string_view>

namespace materialgen {

/// Text of a GLSL file of the wavefront folder, embedded at build time, so that material kernels can be compiled where
/// there is no source tree. `path` is relative to `wavefront/`: "kernels/lib/queue.glsl", "shared/bindings.h".
/// Holds kernels/**/*.glsl, kernels/*.comp and shared/*.{h,def,glsl}. Empty when there is no such file. Lives as long as the program.
std::string_view EmbeddedGlsl(std::string_view path);

/// The texts of all of them, one after the other: what a version of them can be told by.
std::string EmbeddedGlslText();

}  // namespace materialgen
