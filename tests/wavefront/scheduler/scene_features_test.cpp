// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which code fixed kernels are made with, and when they are made again.
#include <gtest/gtest.h>

#include "tests/wavefront/vulkan/fixture.h"
#include "wavefront/scheduler/kernel_registry.h"

namespace wavefront {
namespace {

SceneFacts Lights(uint32_t infinite, uint32_t shapes, uint32_t triangles) {
  SceneFacts facts;
  facts.infiniteLightCount = infinite;
  facts.lightCount = infinite + shapes;
  facts.lightItemCount = facts.lightCount + triangles;
  return facts;
}

constexpr uint32_t kLightShapes = 1, kEmissiveMeshes = 2, kLightTree = 4, kInfiniteLights = 8, kScatteringMedia = 16, kBodies = 32;

TEST(SceneFeatures, AreThoseOfTheScene) {
  EXPECT_EQ(SceneFeatures::Of(Lights(0, 0, 0)).bits, 0u);
  EXPECT_EQ(SceneFeatures::Of(Lights(2, 0, 0)).bits, kInfiniteLights);
  EXPECT_EQ(SceneFeatures::Of(Lights(0, 1, 0)).bits, kLightShapes);
  EXPECT_EQ(SceneFeatures::Of(Lights(1, 1, 5)).bits, kInfiniteLights | kLightShapes | kEmissiveMeshes);
  SceneFacts facts = Lights(0, 0, 20);
  facts.lightTree = 7;
  facts.hasMedia = true;
  EXPECT_EQ(SceneFeatures::Of(facts).bits, kEmissiveMeshes | kLightTree | kScatteringMedia);
  facts = {};
  facts.hasBodies = true;
  EXPECT_EQ(SceneFeatures::Of(facts).bits, kBodies);
}

TEST(SceneFeatures, NameTheTypesAndTraitsOfLights) {
  const auto of = [](uint32_t traits) {
    SceneFacts facts;
    facts.lightTraits = traits;
    return SceneFeatures::Of(facts).bits;
  };
  EXPECT_EQ(of(LightTraitOf(LightType::Rect)), 1u << 6);
  EXPECT_EQ(of(LightTraitOf(LightType::Disk)), 1u << 7);
  EXPECT_EQ(of(LightTraitOf(LightType::Sphere)), 1u << 8);
  EXPECT_EQ(of(LightTraitOf(LightType::Cylinder)), 1u << 9);
  EXPECT_EQ(of(LightTraitOf(LightType::Distant)), 1u << 10);
  EXPECT_EQ(of(LightTraitOf(LightType::Dome)), 1u << 11);
  EXPECT_EQ(of(kLightTraitShaped | kLightTraitTextured), 3u << 12);
}

class SceneFeaturesTest : public vulkan::VulkanTest {};

TEST_F(SceneFeaturesTest, KernelsAreMadeAgainForWhatIsNewAndNeverForWhatIsGone) {
  auto kernels = vulkan::Must(KernelRegistry::Create(*device_));
  ASSERT_TRUE(kernels->Specialize({kInfiniteLights}).ok());
  const vulkan::ComputePipeline* first = &kernels->fixed(Kernel::LightSample);
  ASSERT_TRUE(kernels->Specialize({0}).ok());
  EXPECT_EQ(&kernels->fixed(Kernel::LightSample), first);
  EXPECT_EQ(kernels->features().bits, kInfiniteLights);
  kernels->times()[static_cast<uint32_t>(Kernel::LightSample)].compile.createSeconds = -1;
  ASSERT_TRUE(kernels->Specialize({kLightShapes}).ok());
  EXPECT_GE(kernels->times()[static_cast<uint32_t>(Kernel::LightSample)].compile.createSeconds, 0) << "made anew";
  EXPECT_EQ(kernels->features().bits, kInfiniteLights | kLightShapes);
}

}  // namespace
}  // namespace wavefront
