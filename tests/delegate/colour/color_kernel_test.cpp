// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The GLSL text of a colour transform on its way to the compute kernel.
#include "delegate/colour/color_kernel.h"

#include <gtest/gtest.h>

#include "tests/delegate/fakes.h"

namespace {

TEST(ColorKernel, SamplersAreFoundByTheTextsLayout) {
  const std::string glsl =
      "layout(set=0, binding = 1) uniform sampler1D lut_aSampler; \n"
      "layout(set=0, binding=12) uniform sampler3D lut_b;\n";
  EXPECT_EQ(delegate::FindSamplerBinding(glsl, "lut_aSampler"), 1u);
  EXPECT_EQ(delegate::FindSamplerBinding(glsl, "lut_b"), 12u);
  EXPECT_FALSE(delegate::FindSamplerBinding(glsl, "lut_a"));
  EXPECT_FALSE(delegate::FindSamplerBinding(glsl, "lut_b;x"));
  // However long a text is, it is no reason to run out of stack.
  const std::string endless(1'000'000, 'x');
  EXPECT_FALSE(delegate::FindSamplerBinding("layout(" + endless, "lut_b"));
  EXPECT_FALSE(delegate::FindSamplerBinding("layout(" + endless + ", binding=1) uniform sampler1D lut_b;", "lut_b"));
}

TEST(ColorKernel, BadShadersAreErrors) {
  delegate_test::FakeRenderer renderer;
  std::vector<float> pixels(2 * 3 * 4, 0.5f);
  delegate::ColorShader shader;
  shader.glsl = "vec4 f(vec4 c) { return 2.0 * c; }";
  shader.function = "f";
  EXPECT_TRUE(delegate::RunColorShader(renderer, shader, pixels, 2, 3).ok());
  EXPECT_GT(renderer.colorKernelWords, 0u);
  EXPECT_FALSE(delegate::RunColorShader(renderer, shader, pixels, 3, 3).ok());
  shader.luts.push_back({"nowhere", 1, 2, 1, 1, 1, true, {0, 1}, 0});
  EXPECT_FALSE(delegate::RunColorShader(renderer, shader, pixels, 2, 3).ok());
  shader.luts.clear();
  for (const char* function : {"f); discard(", "f(vec4(0)); f"}) {  // the second would compile
    shader.function = function;
    EXPECT_FALSE(delegate::RunColorShader(renderer, shader, pixels, 2, 3).ok()) << function;
  }
  shader.function = "g";
  const auto status = delegate::RunColorShader(renderer, shader, pixels, 2, 3);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("g"), std::string::npos);
}

}  // namespace
