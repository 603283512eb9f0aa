// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A colour library's own GPU shader (OpenColorIO's GLSL text and LUTs) as a compute kernel over RGBA pixels.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "wavefront/renderer.h"

namespace delegate {

struct ColorShader {
  std::string glsl;      // declarations and functions, as emitted for GPU_LANGUAGE_GLSL_VK_4_6 (samplers included)
  std::string function;  // name of the function: vec4 to vec4
  std::vector<wavefront::Renderer::ColorLut> luts;  // `binding` is filled in here
};

// The whole compute shader: pixels in and out, samplers bound, the function called.
std::string ColorKernelSource(const ColorShader& shader);

// Pixels are transformed in place; row order does not matter. Errors name the shader's line or the device's trouble.
wavefront::Status RunColorShader(wavefront::Renderer& renderer, const ColorShader& shader, std::span<float> rgba,
                                 uint32_t width, uint32_t height);

}  // namespace delegate
