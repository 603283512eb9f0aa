// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A colour library's own GPU shader (OpenColorIO's GLSL text and LUTs) as a compute kernel over RGBA pixels.
//
// What the kernel made here expects of Renderer::RunColorKernel: descriptor set 0, binding 0: a storage buffer of vec4
// pixels, changed in place; a combined image sampler (1-D, 2-D or 3-D by ColorLut::dimension, clamped to the edge,
// linear or nearest by ColorLut::linear) at each ColorLut::binding; push constants: uint pixelCount; workgroups of 64,
// rows of workgroups following each other where x does not suffice. Entry point "main".
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "wavefront/renderer.h"

namespace delegate {

struct ColorShader {
  std::string glsl;      // declarations and functions, as emitted for GPU_LANGUAGE_GLSL_VK_4_6 (samplers included, in
                         // set 0, from binding 1 on)
  std::string function;  // name of the function: vec4 to vec4
  std::vector<wavefront::Renderer::ColorLut> luts;  // `binding` is read from the text's layout and filled in here
};

// The whole compute shader: pixels in and out, the function called.
std::string ColorKernelSource(const ColorShader& shader);

// The binding that the text's layout gives a sampler, or nothing.
std::optional<uint32_t> FindSamplerBinding(const std::string& glsl, const std::string& sampler);

// For those who run it again and again.
struct CompiledColorShader {
  std::vector<uint32_t> spirv;
  std::vector<wavefront::Renderer::ColorLut> luts;
};
wavefront::Result<CompiledColorShader> CompileColorShader(const ColorShader& shader);

// Pixels are transformed in place. Errors name the shader's line or the device's trouble.
wavefront::Status RunColorShader(wavefront::Renderer& renderer, const CompiledColorShader& shader,
                                 std::span<float> rgba, uint32_t width, uint32_t height);
wavefront::Status RunColorShader(wavefront::Renderer& renderer, const ColorShader& shader, std::span<float> rgba,
                                 uint32_t width, uint32_t height);

}  // namespace delegate
