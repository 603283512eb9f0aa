// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A colour transform is built once for as long as it is the same, and anew as soon as its text or a table differs.
#include "wavefront/scheduler/color_kernel.h"

#include <string>

#include "tests/wavefront/vulkan/fixture.h"

namespace wavefront {
namespace {

std::vector<uint32_t> Shader(const std::string& expression) {
  return vulkan::Glsl(R"(layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) buffer Pixels { vec4 pixels[]; };
layout(set = 0, binding = 1) uniform sampler1D table;
layout(push_constant) uniform Push { uint pixelCount; };
void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < pixelCount) pixels[i] = )" + expression + R"(;
})");
}

std::vector<Renderer::ColorLut> Table(float first, float second) {
  Renderer::ColorLut lut;
  lut.sampler = "table";
  lut.width = 2;
  lut.components = 1;
  lut.linear = false;
  lut.values = {first, second};
  lut.binding = 1;
  return {lut};
}

class ColorKernelTest : public vulkan::StagingTest {
 protected:
  void TearDown() override {
    kernel_.reset();
    StagingTest::TearDown();
  }
  // Of a picture of two pixels: red 0 and 1.
  std::vector<float> Reds(std::span<const uint32_t> spirv, const std::vector<Renderer::ColorLut>& luts) {
    std::vector<float> rgba{0, 0, 0, 1, 1, 0, 0, 1};
    EXPECT_TRUE(kernel_->Run(*device_, spirv, luts, rgba, 2, 1).ok());
    return {rgba[0], rgba[4]};
  }
  std::unique_ptr<ColorKernel> kernel_ = std::make_unique<ColorKernel>();
};

TEST_P(ColorKernelTest, TheSameTransformIsBuiltOnce) {
  const auto lookUp = Shader("vec4(texture(table, pixels[i].r).r, pixels[i].gba)");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(Reds(lookUp, Table(5, 7)), (std::vector<float>{5, 7}));
  EXPECT_EQ(kernel_->builds(), 1u);
}

TEST_P(ColorKernelTest, AnotherTableOrTextIsAnotherTransform) {
  const auto lookUp = Shader("vec4(texture(table, pixels[i].r).r, pixels[i].gba)");
  const auto twice = Shader("vec4(2.0 * texture(table, pixels[i].r).r, pixels[i].gba)");
  EXPECT_EQ(Reds(lookUp, Table(5, 7)), (std::vector<float>{5, 7}));
  EXPECT_EQ(Reds(lookUp, Table(5, 8)), (std::vector<float>{5, 8}));
  EXPECT_EQ(Reds(twice, Table(5, 8)), (std::vector<float>{10, 16}));
  EXPECT_EQ(Reds(lookUp, Table(5, 8)), (std::vector<float>{5, 8}));
  EXPECT_EQ(kernel_->builds(), 4u);
}

TEST_P(ColorKernelTest, HowATableIsReadIsPartOfTheTransform) {
  const auto middle = Shader("vec4(texture(table, 0.5).r, pixels[i].gba)");
  auto table = Table(5, 7);
  table[0].linear = true;
  EXPECT_EQ(Reds(middle, table), (std::vector<float>{6, 6}));
  table[0].linear = false;
  EXPECT_NE(Reds(middle, table)[0], 6);
  EXPECT_EQ(kernel_->builds(), 2u);
}

TEST_P(ColorKernelTest, EveryPixelIsTransformedAndNoneBeyond) {
  const auto twice = Shader("2.0 * pixels[i]");
  std::vector<float> rgba(4 * 13 * 11, 0.5f);  // no multiple of a group
  ASSERT_TRUE(kernel_->Run(*device_, twice, Table(0, 0), rgba, 13, 11).ok());
  EXPECT_EQ(rgba, std::vector<float>(rgba.size(), 1.0f));
  EXPECT_FALSE(kernel_->Run(*device_, twice, Table(0, 0), rgba, 13, 12).ok());
}

TEST_P(ColorKernelTest, ATransformThatCannotBeBuiltLeavesNothing) {
  const auto lookUp = Shader("vec4(texture(table, pixels[i].r).r, pixels[i].gba)");
  EXPECT_EQ(Reds(lookUp, Table(5, 7)), (std::vector<float>{5, 7}));
  auto lacking = Table(5, 7);
  lacking[0].values.pop_back();
  std::vector<float> rgba(8);
  EXPECT_FALSE(kernel_->Run(*device_, lookUp, lacking, rgba, 2, 1).ok());
  EXPECT_FALSE(kernel_->Run(*device_, lookUp, lacking, rgba, 2, 1).ok());
  EXPECT_EQ(Reds(lookUp, Table(5, 7)), (std::vector<float>{5, 7}));
  EXPECT_EQ(kernel_->builds(), 2u);  // what was there before is given back first: memory for one is enough
}

INSTANTIATE_TEST_SUITE_P(Uploads, ColorKernelTest, testing::Bool());

}  // namespace
}  // namespace wavefront
