// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <string_view>

namespace materialgen {

/// Text of a GLSL file of the wavefront folder, embedded at build time, so that material kernels can be compiled where
/// there is no source tree. `path` is relative to `wavefront/`: "kernels/lib/queue.glsl", "shared/bindings.h".
/// Holds kernels/**/*.glsl and shared/*.{h,def,glsl}. Empty when there is no such file. Lives as long as the program.
std::string_view EmbeddedGlsl(std::string_view path);

}  // namespace materialgen
