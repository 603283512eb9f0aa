// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/descriptors.h"

#include <algorithm>
#include <array>
#include <map>

#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/image.h"

namespace wavefront::vulkan {
namespace {

constexpr uint64_t kZeroBytes = 272;

VkDescriptorType ToVulkan(DescriptorKind kind) {
  switch (kind) {
    case DescriptorKind::StorageBuffer: return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    case DescriptorKind::UniformBuffer: return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case DescriptorKind::TexelBufferUint:
    case DescriptorKind::TexelBufferFloat: return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    case DescriptorKind::SampledImage: return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  }
  return VK_DESCRIPTOR_TYPE_MAX_ENUM;
}

bool IsTexel(DescriptorKind kind) {
  return kind == DescriptorKind::TexelBufferUint || kind == DescriptorKind::TexelBufferFloat;
}

}  // namespace

PipelineLayout::PipelineLayout(Device& device) : context_(device.context()) {}

PipelineLayout::~PipelineLayout() {
  const VolkDeviceTable& vk = context_->vk;
  if (layout_ != nullptr) vk.vkDestroyPipelineLayout(context_->device, layout_, nullptr);
  if (setLayout_ != nullptr) vk.vkDestroyDescriptorSetLayout(context_->device, setLayout_, nullptr);
}

const Binding* PipelineLayout::Find(uint32_t number) const {
  for (const Binding& binding : bindings_) {
    if (binding.number == number) return &binding;
  }
  return nullptr;
}

Result<std::unique_ptr<PipelineLayout>> PipelineLayout::Create(Device& device, std::vector<Binding> bindings,
                                                               std::string name) {
  const DeviceLimits& limits = device.info().limits;
  uint32_t storage = 0, sampled = 0, all = 0;
  for (std::size_t i = 0; i < bindings.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (bindings[i].number == bindings[j].number) {
        return Error{"'" + name + "' has two bindings of number " + std::to_string(bindings[i].number)};
      }
    }
    all += bindings[i].count;
    if (bindings[i].kind == DescriptorKind::StorageBuffer) storage += bindings[i].count;
    if (IsTexel(bindings[i].kind) || bindings[i].kind == DescriptorKind::SampledImage) sampled += bindings[i].count;
  }
  if (storage > limits.maxStorageBuffersPerStage || sampled > limits.maxSampledImagesPerStage ||
      all > limits.maxResourcesPerStage) {
    return Error{"'" + name + "' has " + std::to_string(storage) + " storage buffers and " + std::to_string(sampled) +
                 " texel buffers and images; " + device.info().name + " takes " +
                 std::to_string(limits.maxStorageBuffersPerStage) + " and " +
                 std::to_string(limits.maxSampledImagesPerStage)};
  }
  std::unique_ptr<PipelineLayout> layout(new PipelineLayout(device));
  layout->bindings_ = std::move(bindings);
  auto zeros = Buffer::Create(device, {kZeroBytes, MemoryKind::Other, MemoryLocation::HostVisible, "zeros", true});
  if (!zeros) return zeros.error();
  layout->zeros_ = std::move(*zeros);
  const std::array<std::byte, kZeroBytes> nothing{};
  if (Status cleared = layout->zeros_->Upload(0, std::span<const std::byte>(nothing)); !cleared) return cleared.error();
  if (Status built = layout->Build(); !built) return built.error();
  layout->context_->Name(VK_OBJECT_TYPE_PIPELINE_LAYOUT, layout->layout_, name);
  return layout;
}

Status PipelineLayout::Build() {
  const VolkDeviceTable& vk = context_->vk;
  std::vector<VkDescriptorSetLayoutBinding> vkBindings;
  for (const Binding& binding : bindings_) {
    vkBindings.push_back({binding.number, ToVulkan(binding.kind), binding.count, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  }
  auto set = Struct<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set.bindingCount = static_cast<uint32_t>(vkBindings.size());
  set.pBindings = vkBindings.data();
  VkResult result = vk.vkCreateDescriptorSetLayout(context_->device, &set, nullptr, &setLayout_);
  if (result != VK_SUCCESS) return context_->Fail("vkCreateDescriptorSetLayout", result);
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, kPushConstantBytes};
  auto info = Struct<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  info.setLayoutCount = 1;
  info.pSetLayouts = &setLayout_;
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  result = vk.vkCreatePipelineLayout(context_->device, &info, nullptr, &layout_);
  if (result != VK_SUCCESS) return context_->Fail("vkCreatePipelineLayout", result);
  return {};
}

DescriptorSet::DescriptorSet(Device& device, const PipelineLayout& layout) : context_(device.context()), layout_(layout) {}

DescriptorSet::~DescriptorSet() {
  if (pool_ != nullptr) context_->vk.vkDestroyDescriptorPool(context_->device, pool_, nullptr);
}

Result<std::unique_ptr<DescriptorSet>> DescriptorSet::Create(Device& device, const PipelineLayout& layout,
                                                             std::string name) {
  std::unique_ptr<DescriptorSet> set(new DescriptorSet(device, layout));
  Context& context = *set->context_;
  std::map<VkDescriptorType, uint32_t> counts;
  for (const Binding& binding : layout.bindings()) counts[ToVulkan(binding.kind)] += binding.count;
  std::vector<VkDescriptorPoolSize> sizes;
  for (const auto& [type, count] : counts) sizes.push_back({type, count});
  if (sizes.empty()) sizes.push_back({VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1});
  auto pool = Struct<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.maxSets = 1;
  pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  VkResult result = context.vk.vkCreateDescriptorPool(context.device, &pool, nullptr, &set->pool_);
  if (result != VK_SUCCESS) return context.Fail("vkCreateDescriptorPool", result);
  const VkDescriptorSetLayout setLayout = layout.setLayout();
  auto info = Struct<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  info.descriptorPool = set->pool_;
  info.descriptorSetCount = 1;
  info.pSetLayouts = &setLayout;
  result = context.vk.vkAllocateDescriptorSets(context.device, &info, &set->set_);
  if (result != VK_SUCCESS) return context.Fail("vkAllocateDescriptorSets", result);
  context.Name(VK_OBJECT_TYPE_DESCRIPTOR_SET, set->set_, name);
  if (Status filled = set->FillWithZeros(); !filled) return filled.error();
  return set;
}

Status DescriptorSet::FillWithZeros() {
  const VkDescriptorBufferInfo buffer{layout_.zeros().handle(), 0, VK_WHOLE_SIZE};
  for (const Binding& binding : layout_.bindings()) {
    if (binding.kind == DescriptorKind::SampledImage) continue;
    VkBufferView view = nullptr;
    if (IsTexel(binding.kind)) {
      const bool isUint = binding.kind == DescriptorKind::TexelBufferUint;
      const Format format = IsUint(binding.format) == isUint ? binding.format : Format::Rgba32Float;
      auto made = layout_.zeros().TexelView(format);
      if (!made) return made.error();
      view = *made;
    }
    auto write = Struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = set_;
    write.dstBinding = binding.number;
    write.descriptorCount = 1;
    write.descriptorType = ToVulkan(binding.kind);
    write.pBufferInfo = &buffer;
    write.pTexelBufferView = &view;
    for (write.dstArrayElement = 0; write.dstArrayElement < binding.count; ++write.dstArrayElement) {
      context_->vk.vkUpdateDescriptorSets(context_->device, 1, &write, 0, nullptr);
    }
  }
  return {};
}

Status DescriptorSet::Write(uint32_t number, const Buffer& buffer, uint64_t offset, uint64_t bytes) {
  const Binding* binding = layout_.Find(number);
  if (binding == nullptr ||
      (binding->kind != DescriptorKind::StorageBuffer && binding->kind != DescriptorKind::UniformBuffer)) {
    return Error{"binding " + std::to_string(number) + " is no storage or uniform buffer"};
  }
  const uint64_t range = bytes != 0 ? bytes : buffer.size() - std::min(offset, buffer.size());
  if (range == 0 || offset > buffer.size() || range > buffer.size() - offset ||
      offset % context_->info.limits.storageBufferOffsetAlignment != 0) {
    return Error{"binding " + std::to_string(number) + " takes " + std::to_string(range) + " bytes at " +
                 std::to_string(offset) + " of '" + buffer.name() + "', which has " + std::to_string(buffer.size())};
  }
  const bool storage = binding->kind == DescriptorKind::StorageBuffer;
  const uint64_t limit = storage ? context_->info.limits.maxStorageBufferRange : 16384;
  if (range > limit) {
    return Error{"'" + buffer.name() + "' of " + BytesText(range) + " passes what one binding of " + context_->info.name +
                 " takes (" + BytesText(limit) + ")"};
  }
  const VkDescriptorBufferInfo info{buffer.handle(), offset, range};
  auto write = Struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = set_;
  write.dstBinding = number;
  write.descriptorCount = 1;
  write.descriptorType = ToVulkan(binding->kind);
  write.pBufferInfo = &info;
  context_->vk.vkUpdateDescriptorSets(context_->device, 1, &write, 0, nullptr);
  return {};
}

Status DescriptorSet::WriteTexels(uint32_t number, const Buffer& buffer, Format format, uint64_t offset,
                                  uint64_t bytes) {
  const Binding* binding = layout_.Find(number);
  if (binding == nullptr || !IsTexel(binding->kind)) {
    return Error{"binding " + std::to_string(number) + " is no texel buffer"};
  }
  if (IsUint(format) != (binding->kind == DescriptorKind::TexelBufferUint)) {
    return Error{"binding " + std::to_string(number) + " and the format of '" + buffer.name() +
                 "' differ in being integers or floats"};
  }
  auto view = buffer.TexelView(format, offset, bytes);
  if (!view) return view.error();
  const VkBufferView handle = *view;
  auto write = Struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = set_;
  write.dstBinding = number;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  write.pTexelBufferView = &handle;
  context_->vk.vkUpdateDescriptorSets(context_->device, 1, &write, 0, nullptr);
  return {};
}

Status DescriptorSet::WriteTexels(uint32_t number, const Buffer& buffer) {
  const Binding* binding = layout_.Find(number);
  return WriteTexels(number, buffer, binding != nullptr ? binding->format : Format::Rgba32Uint);
}

Status DescriptorSet::WriteImage(uint32_t number, const Image& image, const Sampler& sampler, uint32_t element) {
  const Binding* binding = layout_.Find(number);
  if (binding == nullptr || binding->kind != DescriptorKind::SampledImage || element >= binding->count) {
    return Error{"binding " + std::to_string(number) + "[" + std::to_string(element) + "] is no sampled image"};
  }
  const VkDescriptorImageInfo info{sampler.handle(), image.view(), VK_IMAGE_LAYOUT_GENERAL};
  auto write = Struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = set_;
  write.dstBinding = number;
  write.dstArrayElement = element;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  write.pImageInfo = &info;
  context_->vk.vkUpdateDescriptorSets(context_->device, 1, &write, 0, nullptr);
  return {};
}

}  // namespace wavefront::vulkan
