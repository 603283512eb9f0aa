// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What a driver tells of a pipeline's machine code, in words. The tests' own driver tells nothing, so its answers are ours.
#include <cstdio>

#include "fixture.h"
#include "wavefront/vulkan/context.h"

namespace wavefront::vulkan {
namespace {

VKAPI_ATTR VkResult VKAPI_CALL TwoExecutables(VkDevice, const VkPipelineInfoKHR* info, uint32_t* count,
                                              VkPipelineExecutablePropertiesKHR* properties) {
  EXPECT_NE(info->pipeline, VkPipeline(VK_NULL_HANDLE));
  EXPECT_EQ(properties, nullptr);
  *count = 2;
  return VK_SUCCESS;
}

void Fill(VkPipelineExecutableStatisticKHR* s, const char* name, VkPipelineExecutableStatisticFormatKHR format) {
  EXPECT_EQ(s->sType, VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR);
  std::snprintf(s->name, sizeof(s->name), "%s", name);
  s->format = format;
}

// The first executable has one number of each kind, the second none.
VKAPI_ATTR VkResult VKAPI_CALL OneOfEachFormat(VkDevice, const VkPipelineExecutableInfoKHR* info, uint32_t* count,
                                               VkPipelineExecutableStatisticKHR* statistics) {
  if (!statistics) {
    *count = info->executableIndex == 0 ? 4 : 0;
    return VK_SUCCESS;
  }
  if (info->executableIndex != 0) return VK_SUCCESS;
  Fill(&statistics[0], "Spills", VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR);
  statistics[0].value.b32 = VK_TRUE;
  Fill(&statistics[1], "Offset", VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR);
  statistics[1].value.i64 = -7;
  Fill(&statistics[2], "Register Count", VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR);
  statistics[2].value.u64 = 5000000000u;
  Fill(&statistics[3], "Occupancy", VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_FLOAT64_KHR);
  statistics[3].value.f64 = 0.25;
  return VK_SUCCESS;
}

TEST_F(VulkanTest, DriverStatisticsOfEveryFormatAreTold) {
  auto layout = Must(PipelineLayout::Create(*device_, {}));
  auto pipeline = MakePipeline(*layout, "layout(local_size_x = 1) in;\nvoid main() {}", {});
  Context& context = *device_->context();
  if (!context.capturesStatistics) EXPECT_TRUE(pipeline->DriverStatistics().empty());
  const bool captures = context.capturesStatistics;
  const VolkDeviceTable calls = context.vk;
  context.capturesStatistics = true;
  context.vk.vkGetPipelineExecutablePropertiesKHR = TwoExecutables;
  context.vk.vkGetPipelineExecutableStatisticsKHR = OneOfEachFormat;
  const std::vector<std::string> told = pipeline->DriverStatistics();
  context.vk = calls;
  context.capturesStatistics = captures;
  EXPECT_EQ(told, (std::vector<std::string>{"Spills: yes", "Offset: -7", "Register Count: 5000000000",
                                            "Occupancy: 0.250000"}));
}

}  // namespace
}  // namespace wavefront::vulkan
