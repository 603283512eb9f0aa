// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/pipeline.h"

#include <chrono>

#include "wavefront/vulkan/context.h"

namespace wavefront::vulkan {

ComputePipeline::ComputePipeline(Device& device) : context_(device.context()) {}

ComputePipeline::~ComputePipeline() {
  if (pipeline_ != nullptr) context_->vk.vkDestroyPipeline(context_->device, pipeline_, nullptr);
}

Result<std::unique_ptr<ComputePipeline>> ComputePipeline::Create(Device& device, const PipelineLayout& layout,
                                                                 const PipelineDesc& desc) {
  constexpr uint32_t kSpirvMagic = 0x07230203;
  if (desc.spirv.size() < 5 || desc.spirv[0] != kSpirvMagic) return Error{"kernel '" + desc.name + "' is not SPIR-V"};
  const auto start = std::chrono::steady_clock::now();
  std::unique_ptr<ComputePipeline> pipeline(new ComputePipeline(device));
  pipeline->name_ = desc.name;
  Context& context = *pipeline->context_;

  auto moduleInfo = Struct<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  moduleInfo.codeSize = desc.spirv.size_bytes();
  moduleInfo.pCode = desc.spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  VkResult result = context.vk.vkCreateShaderModule(context.device, &moduleInfo, nullptr, &module);
  if (result != VK_SUCCESS) {
    return Error{context.Fail("vkCreateShaderModule", result).message + " (kernel '" + desc.name + "')"};
  }

  std::vector<VkSpecializationMapEntry> entries;
  std::vector<uint32_t> values;
  for (const auto& [id, value] : desc.specialization) {
    entries.push_back({id, static_cast<uint32_t>(values.size() * sizeof(uint32_t)), sizeof(uint32_t)});
    values.push_back(value);
  }
  VkSpecializationInfo specialization{};
  specialization.mapEntryCount = static_cast<uint32_t>(entries.size());
  specialization.pMapEntries = entries.data();
  specialization.dataSize = values.size() * sizeof(uint32_t);
  specialization.pData = values.data();

  auto info = Struct<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = desc.entryPoint.c_str();
  info.stage.pSpecializationInfo = entries.empty() ? nullptr : &specialization;
  info.layout = layout.handle();
  if (context.capturesStatistics) info.flags |= VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
  result = context.vk.vkCreateComputePipelines(context.device, context.pipelineCache, 1, &info, nullptr, &pipeline->pipeline_);
  context.vk.vkDestroyShaderModule(context.device, module, nullptr);
  if (result != VK_SUCCESS) {
    pipeline->pipeline_ = nullptr;
    return Error{context.Fail("vkCreateComputePipelines", result).message + " (kernel '" + desc.name + "')"};
  }
  context.Name(VK_OBJECT_TYPE_PIPELINE, pipeline->pipeline_, desc.name);
  pipeline->creationSeconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return pipeline;
}

std::vector<std::string> ComputePipeline::DriverStatistics() const {
  std::vector<std::string> texts;
  if (!context_->capturesStatistics) return texts;
  auto info = Struct<VkPipelineInfoKHR>(VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR);
  info.pipeline = pipeline_;
  uint32_t executables = 0;
  context_->vk.vkGetPipelineExecutablePropertiesKHR(context_->device, &info, &executables, nullptr);
  for (uint32_t e = 0; e < executables; ++e) {
    auto executable = Struct<VkPipelineExecutableInfoKHR>(VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR);
    executable.pipeline = pipeline_;
    executable.executableIndex = e;
    uint32_t count = 0;
    context_->vk.vkGetPipelineExecutableStatisticsKHR(context_->device, &executable, &count, nullptr);
    std::vector<VkPipelineExecutableStatisticKHR> statistics(
        count, Struct<VkPipelineExecutableStatisticKHR>(VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR));
    context_->vk.vkGetPipelineExecutableStatisticsKHR(context_->device, &executable, &count, statistics.data());
    for (uint32_t i = 0; i < count; ++i) {
      const VkPipelineExecutableStatisticKHR& s = statistics[i];
      std::string value;
      switch (s.format) {
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: value = s.value.b32 ? "yes" : "no"; break;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: value = std::to_string(s.value.i64); break;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR: value = std::to_string(s.value.u64); break;
        default: value = std::to_string(s.value.f64); break;
      }
      texts.push_back(std::string(s.name) + ": " + value);
    }
  }
  return texts;
}

}  // namespace wavefront::vulkan
