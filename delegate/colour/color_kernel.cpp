// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/colour/color_kernel.h"

#include <algorithm>
#include <regex>

#include "materialgen/materialgen.h"

namespace delegate {
namespace {

bool IsIdentifier(const std::string& name) {
  static const std::regex identifier("[A-Za-z_][A-Za-z0-9_]*");
  return std::regex_match(name, identifier);
}

}  // namespace

std::string ColorKernelSource(const ColorShader& shader) {
  return "#version 460\n"
         "layout(local_size_x = 64) in;\n"
         "layout(set = 0, binding = 0, std430) buffer Pixels { vec4 pixels[]; };\n"
         "layout(push_constant) uniform Size { uint pixelCount; };\n" +
         shader.glsl +
         "\nvoid main() {\n"
         "  uint index = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;\n"
         "  if (index >= pixelCount) return;\n"
         "  pixels[index] = " +
         shader.function +
         "(pixels[index]);\n"
         "}\n";
}

std::optional<uint32_t> FindSamplerBinding(const std::string& glsl, const std::string& sampler) {
  if (!IsIdentifier(sampler)) return std::nullopt;
  // layout(set=0, binding = 1) uniform sampler1D name;
  // Only the few characters of one declaration meet the regular expression: std::regex recurses by length.
  constexpr size_t kLongestDeclaration = 200;
  const std::regex declaration("layout *\\(([^)]*)\\) *uniform +sampler[123]D +" + sampler + " *;");
  static const std::regex binding("binding *= *([0-9]{1,6})");
  for (size_t at = glsl.find("layout"); at != std::string::npos; at = glsl.find("layout", at + 1)) {
    const size_t length = glsl.find(';', at) - at + 1;
    const std::string text = glsl.substr(at, std::min(length, kLongestDeclaration + sampler.size()));
    std::smatch found, number;
    if (!std::regex_search(text, found, declaration, std::regex_constants::match_continuous)) continue;
    const std::string qualifiers = found[1];
    if (!std::regex_search(qualifiers, number, binding)) return std::nullopt;
    return static_cast<uint32_t>(std::stoul(number[1]));
  }
  return std::nullopt;
}

wavefront::Result<CompiledColorShader> CompileColorShader(const ColorShader& shader) {
  if (!IsIdentifier(shader.function))
    return wavefront::Error{"\"" + shader.function + "\" cannot be the name of a function."};
  CompiledColorShader compiled;
  compiled.luts = shader.luts;
  for (auto& lut : compiled.luts) {
    const auto binding = FindSamplerBinding(shader.glsl, lut.sampler);
    if (!binding || *binding == 0)
      return wavefront::Error{"The colour shader declares no sampler \"" + lut.sampler + "\" with a binding above 0."};
    lut.binding = *binding;
    const uint64_t texels = uint64_t{lut.width} * lut.height * lut.depth;
    if (lut.dimension < 1 || lut.dimension > 3 || texels == 0 || lut.values.size() != texels * lut.components)
      return wavefront::Error{"The colour table \"" + lut.sampler + "\" does not fit its size."};
  }
  std::string error;
  compiled.spirv = materialgen::CompileGlsl(ColorKernelSource(shader), "colour transform", &error);
  if (compiled.spirv.empty()) return wavefront::Error{"The colour shader does not compile: " + error};
  return compiled;
}

wavefront::Status RunColorShader(wavefront::Renderer& renderer, const CompiledColorShader& shader,
                                 std::span<float> rgba, uint32_t width, uint32_t height) {
  if (width == 0 || height == 0 || rgba.size() != size_t{width} * height * 4)
    return wavefront::Error{"The pixels do not fit the image size."};
  return renderer.RunColorKernel(shader.spirv, shader.luts, rgba, width, height);
}

wavefront::Status RunColorShader(wavefront::Renderer& renderer, const ColorShader& shader, std::span<float> rgba,
                                 uint32_t width, uint32_t height) {
  const auto compiled = CompileColorShader(shader);
  if (!compiled) return compiled.error();
  return RunColorShader(renderer, compiled.value(), rgba, width, height);
}

}  // namespace delegate
