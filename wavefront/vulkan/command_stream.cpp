// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/command_stream.h"

#include <algorithm>

#include "wavefront/base/check.h"
#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/transfer.h"

namespace wavefront::vulkan {

CommandStream::CommandStream(Device& device) : context_(device.context()) {}

CommandStream::~CommandStream() {
  const VolkDeviceTable& vk = context_->vk;
  if (timeline_ != nullptr && submitted_ > 0 && !context_->lost) (void)Wait(submitted_);
  for (const Slot& slot : slots_) {
    if (slot.pool != nullptr) vk.vkDestroyCommandPool(context_->device, slot.pool, nullptr);
  }
  if (queries_ != nullptr) vk.vkDestroyQueryPool(context_->device, queries_, nullptr);
  if (timeline_ != nullptr) vk.vkDestroySemaphore(context_->device, timeline_, nullptr);
}

Result<std::unique_ptr<CommandStream>> CommandStream::Create(Device& device, const CommandStreamOptions& options) {
  std::unique_ptr<CommandStream> stream(new CommandStream(device));
  if (Status built = stream->Build(options); !built) return built.error();
  return stream;
}

Status CommandStream::Build(const CommandStreamOptions& options) {
  const VolkDeviceTable& vk = context_->vk;
  auto type = Struct<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
  type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  auto semaphore = Struct<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type);
  VkResult result = vk.vkCreateSemaphore(context_->device, &semaphore, nullptr, &timeline_);
  if (result != VK_SUCCESS) return context_->Fail("vkCreateSemaphore", result);
  context_->Name(VK_OBJECT_TYPE_SEMAPHORE, timeline_, options.name);

  slots_.resize(std::max(1u, options.slots));
  for (Slot& slot : slots_) {
    auto pool = Struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
    pool.queueFamilyIndex = context_->queueFamily;
    result = vk.vkCreateCommandPool(context_->device, &pool, nullptr, &slot.pool);
    if (result != VK_SUCCESS) return context_->Fail("vkCreateCommandPool", result);
    auto info = Struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    info.commandPool = slot.pool;
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    result = vk.vkAllocateCommandBuffers(context_->device, &info, &slot.commands);
    if (result != VK_SUCCESS) return context_->Fail("vkAllocateCommandBuffers", result);
    context_->Name(VK_OBJECT_TYPE_COMMAND_BUFFER, slot.commands, options.name);
  }
  queriesPerSlot_ = options.timestampsPerSubmit;
  if (queriesPerSlot_ > 0) {
    auto info = Struct<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = queriesPerSlot_ * static_cast<uint32_t>(slots_.size());
    result = vk.vkCreateQueryPool(context_->device, &info, nullptr, &queries_);
    if (result != VK_SUCCESS) return context_->Fail("vkCreateQueryPool", result);
    ticks_.resize(queriesPerSlot_);
  }
  return {};
}

uint64_t CommandStream::nextFreeAt() const { return slots_[current_].value; }

Status CommandStream::Begin() {
  WAVEFRONT_CHECK(!recording_, "Begin without Submit");
  if (context_->lost) return Error{"the device was lost"};
  auto completed = Completed();
  if (!completed) return completed.error();
  if (*completed < slot().value) {
    return Error{"all " + std::to_string(slots_.size()) + " command buffers are in flight: Wait for nextFreeAt() first"};
  }
  const VolkDeviceTable& vk = context_->vk;
  VkResult result = vk.vkResetCommandPool(context_->device, slot().pool, 0);
  if (result != VK_SUCCESS) return context_->Fail("vkResetCommandPool", result);
  auto begin = Struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  result = vk.vkBeginCommandBuffer(slot().commands, &begin);
  if (result != VK_SUCCESS) return context_->Fail("vkBeginCommandBuffer", result);
  if (queriesPerSlot_ > 0) {
    vk.vkResetQueryPool(context_->device, queries_, static_cast<uint32_t>(current_) * queriesPerSlot_, queriesPerSlot_);
  }
  slot().timestamps = 0;
  slot().value = 0;
  recording_ = true;
  boundLayout_ = nullptr;
  Barrier();
  return {};
}

void CommandStream::BindSet(const DescriptorSet& set) {
  boundLayout_ = set.layout().handle();
  const VkDescriptorSet handle = set.handle();
  context_->vk.vkCmdBindDescriptorSets(slot().commands, VK_PIPELINE_BIND_POINT_COMPUTE, boundLayout_, 0, 1, &handle, 0,
                                       nullptr);
}

void CommandStream::BindPipeline(const ComputePipeline& pipeline) {
  context_->vk.vkCmdBindPipeline(slot().commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
}

void CommandStream::PushConstants(std::span<const std::byte> data, uint32_t offset) {
  WAVEFRONT_CHECK(boundLayout_ != nullptr, "PushConstants before BindSet");
  WAVEFRONT_CHECK(offset + data.size() <= kPushConstantBytes && data.size() % 4 == 0, "%zu bytes at %u", data.size(), offset);
  if (data.empty()) return;
  context_->vk.vkCmdPushConstants(slot().commands, boundLayout_, VK_SHADER_STAGE_COMPUTE_BIT, offset,
                                  static_cast<uint32_t>(data.size()), data.data());
}

void CommandStream::Dispatch(uint32_t x, uint32_t y, uint32_t z) {
  context_->vk.vkCmdDispatch(slot().commands, x, y, z);
}

void CommandStream::DispatchIndirect(const Buffer& arguments, uint64_t offset) {
  WAVEFRONT_CHECK(offset % 4 == 0 && offset + 12 <= arguments.size(), "offset %llu", static_cast<unsigned long long>(offset));
  context_->vk.vkCmdDispatchIndirect(slot().commands, arguments.handle(), offset);
}

void CommandStream::Barrier() { FullBarrier(context_->vk, slot().commands, false); }

void CommandStream::Fill(const Buffer& target, uint64_t offset, uint64_t bytes, uint32_t value) {
  context_->vk.vkCmdFillBuffer(slot().commands, target.handle(), offset, bytes != 0 ? bytes : VK_WHOLE_SIZE, value);
}

void CommandStream::Update(const Buffer& target, uint64_t offset, std::span<const std::byte> data) {
  if (data.empty()) return;
  context_->vk.vkCmdUpdateBuffer(slot().commands, target.handle(), offset, data.size(), data.data());
}

void CommandStream::Copy(const Buffer& source, uint64_t sourceOffset, const Buffer& target, uint64_t targetOffset,
                         uint64_t bytes) {
  if (bytes == 0) return;
  const VkBufferCopy region{sourceOffset, targetOffset, bytes};
  context_->vk.vkCmdCopyBuffer(slot().commands, source.handle(), target.handle(), 1, &region);
}

uint32_t CommandStream::Timestamp() {
  if (slot().timestamps >= queriesPerSlot_) return kNoTimestamp;
  const uint32_t index = slot().timestamps++;
  context_->vk.vkCmdWriteTimestamp2(slot().commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_,
                                    static_cast<uint32_t>(current_) * queriesPerSlot_ + index);
  return index;
}

void CommandStream::BeginLabel(const char* name) {
  if (context_->instance->beginLabel == nullptr) return;
  auto label = Struct<VkDebugUtilsLabelEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
  label.pLabelName = name;
  context_->instance->beginLabel(slot().commands, &label);
}

void CommandStream::EndLabel() {
  if (context_->instance->endLabel != nullptr) context_->instance->endLabel(slot().commands);
}

Result<uint64_t> CommandStream::Submit() {
  WAVEFRONT_CHECK(recording_, "Submit without Begin");
  recording_ = false;
  const VolkDeviceTable& vk = context_->vk;
  FullBarrier(vk, slot().commands, true);
  const VkResult result = vk.vkEndCommandBuffer(slot().commands);
  if (result != VK_SUCCESS) return context_->Fail("vkEndCommandBuffer", result);
  auto commands = Struct<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  commands.commandBuffer = slot().commands;
  auto signal = Struct<VkSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
  signal.semaphore = timeline_;
  signal.value = submitted_ + 1;
  signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  auto submit = Struct<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &commands;
  submit.signalSemaphoreInfoCount = 1;
  submit.pSignalSemaphoreInfos = &signal;
  if (Status done = context_->Submit(submit); !done) return done.error();
  slot().value = ++submitted_;
  current_ = (current_ + 1) % slots_.size();
  return submitted_;
}

Result<bool> CommandStream::Wait(uint64_t value, uint64_t timeoutNanoseconds) {
  if (value == 0) return true;
  auto info = Struct<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
  info.semaphoreCount = 1;
  info.pSemaphores = &timeline_;
  info.pValues = &value;
  const VkResult result = context_->vk.vkWaitSemaphores(context_->device, &info, timeoutNanoseconds);
  if (result == VK_TIMEOUT) return false;
  if (result != VK_SUCCESS) return context_->Fail("vkWaitSemaphores", result);
  return true;
}

Result<uint64_t> CommandStream::Completed() const {
  uint64_t value = 0;
  const VkResult result = context_->vk.vkGetSemaphoreCounterValue(context_->device, timeline_, &value);
  if (result != VK_SUCCESS) return context_->Fail("vkGetSemaphoreCounterValue", result);
  return value;
}

Result<uint32_t> CommandStream::ReadTimestamps(uint64_t value, std::span<double> nanoseconds) const {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const Slot& slot = slots_[i];
    if (slot.value != value || value == 0) continue;
    const uint32_t count = std::min<uint32_t>(slot.timestamps, static_cast<uint32_t>(nanoseconds.size()));
    if (count == 0) return 0u;
    const VkResult result = context_->vk.vkGetQueryPoolResults(
        context_->device, queries_, static_cast<uint32_t>(i) * queriesPerSlot_, count, count * sizeof(uint64_t),
        ticks_.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
    if (result == VK_NOT_READY) return Error{"submission " + std::to_string(value) + " is not complete"};
    if (result != VK_SUCCESS) return context_->Fail("vkGetQueryPoolResults", result);
    for (uint32_t j = 0; j < count; ++j) {
      nanoseconds[j] = static_cast<double>(ticks_[j]) * context_->info.limits.timestampPeriod;
    }
    return count;
  }
  return Error{"the timestamps of submission " + std::to_string(value) + " are gone: its slot was used again"};
}

}  // namespace wavefront::vulkan
