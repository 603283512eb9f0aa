// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/transfer.h"

#include <algorithm>
#include <cstring>

namespace wavefront::vulkan {

void FullBarrier(const VolkDeviceTable& vk, VkCommandBuffer commands, bool toHost) {
  auto memory = Struct<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  memory.srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  memory.srcAccessMask = VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT;
  if (toHost) {
    memory.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
    memory.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
  } else {
    memory.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT |
                          VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
    memory.dstAccessMask = VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_UNIFORM_READ_BIT |
                           VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
                           VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;
  }
  auto dependency = Struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  vk.vkCmdPipelineBarrier2(commands, &dependency);
}

Transfer::~Transfer() {
  const VolkDeviceTable& vk = context_.vk;
  for (Chunk& chunk : chunks_) {
    if (chunk.buffer != VK_NULL_HANDLE) vk.vkDestroyBuffer(context_.device, chunk.buffer, nullptr);
    context_.Free(chunk.allocation, MemoryKind::Staging);
  }
  if (pool_ != VK_NULL_HANDLE) vk.vkDestroyCommandPool(context_.device, pool_, nullptr);
  if (timeline_ != VK_NULL_HANDLE) vk.vkDestroySemaphore(context_.device, timeline_, nullptr);
}

Status Transfer::CreateShared() {
  const VolkDeviceTable& vk = context_.vk;
  if (timeline_ == VK_NULL_HANDLE) {
    auto type = Struct<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    auto info = Struct<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type);
    const VkResult result = vk.vkCreateSemaphore(context_.device, &info, nullptr, &timeline_);
    if (result != VK_SUCCESS) return context_.Fail("vkCreateSemaphore", result);
  }
  if (pool_ == VK_NULL_HANDLE) {
    auto info = Struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    info.queueFamilyIndex = context_.queueFamily;
    const VkResult result = vk.vkCreateCommandPool(context_.device, &info, nullptr, &pool_);
    if (result != VK_SUCCESS) return context_.Fail("vkCreateCommandPool", result);
  }
  return {};
}

Status Transfer::CreateStaging(Chunk& chunk) {
  const VolkDeviceTable& vk = context_.vk;
  auto info = Struct<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = kChunkBytes;
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkResult result = vk.vkCreateBuffer(context_.device, &info, nullptr, &chunk.buffer);
  if (result != VK_SUCCESS) return context_.Fail("vkCreateBuffer", result);
  VkMemoryRequirements needs{};
  vk.vkGetBufferMemoryRequirements(context_.device, chunk.buffer, &needs);
  auto allocation = context_.Allocate(needs, true, MemoryKind::Staging, "staging");
  if (allocation) {
    chunk.allocation = *allocation;
    result = vk.vkBindBufferMemory(context_.device, chunk.buffer, chunk.allocation.memory, 0);
    if (result == VK_SUCCESS) return {};
    context_.Free(chunk.allocation, MemoryKind::Staging);
    chunk.allocation = {};
  }
  vk.vkDestroyBuffer(context_.device, chunk.buffer, nullptr);
  chunk.buffer = VK_NULL_HANDLE;
  return allocation ? context_.Fail("vkBindBufferMemory", result) : allocation.error();
}

// The next chunk, idle and recording.
Status Transfer::Prepare(bool staging, Chunk*& chunk) {
  const VolkDeviceTable& vk = context_.vk;
  if (Status shared = CreateShared(); !shared) return shared;
  chunk = &chunks_[next_];
  next_ = (next_ + 1) % kChunks;
  if (staging && chunk->buffer == VK_NULL_HANDLE) {
    if (Status created = CreateStaging(*chunk); !created) return created;
  }
  if (chunk->commands == VK_NULL_HANDLE) {
    auto info = Struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    info.commandPool = pool_;
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    const VkResult result = vk.vkAllocateCommandBuffers(context_.device, &info, &chunk->commands);
    if (result != VK_SUCCESS) return context_.Fail("vkAllocateCommandBuffers", result);
  }
  return Wait(chunk->busyUntil);
}

Status Transfer::SubmitAndMaybeWait(Chunk& chunk, const Record& record, bool wait) {
  const VolkDeviceTable& vk = context_.vk;
  auto begin = Struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VkResult result = vk.vkBeginCommandBuffer(chunk.commands, &begin);
  if (result != VK_SUCCESS) return context_.Fail("vkBeginCommandBuffer", result);
  FullBarrier(vk, chunk.commands, false);
  record(chunk.commands, chunk.buffer);
  FullBarrier(vk, chunk.commands, false);
  if (wait) FullBarrier(vk, chunk.commands, true);
  result = vk.vkEndCommandBuffer(chunk.commands);
  if (result != VK_SUCCESS) return context_.Fail("vkEndCommandBuffer", result);

  auto commands = Struct<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  commands.commandBuffer = chunk.commands;
  auto signal = Struct<VkSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
  signal.semaphore = timeline_;
  signal.value = submitted_ + 1;
  signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  auto submit = Struct<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &commands;
  submit.signalSemaphoreInfoCount = 1;
  submit.pSignalSemaphoreInfos = &signal;
  if (Status submitted = context_.Submit(submit); !submitted) return submitted;
  chunk.busyUntil = ++submitted_;
  return wait ? Wait(chunk.busyUntil) : Status{};
}

Status Transfer::Wait(uint64_t value) {
  if (value == 0) return {};
  auto info = Struct<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
  info.semaphoreCount = 1;
  info.pSemaphores = &timeline_;
  info.pValues = &value;
  const VkResult result = context_.vk.vkWaitSemaphores(context_.device, &info, UINT64_MAX);
  if (result != VK_SUCCESS) return context_.Fail("vkWaitSemaphores", result);
  return {};
}

void Transfer::Drain() {
  std::scoped_lock lock(mutex_);
  if (!context_.lost) (void)Wait(submitted_);
}

Status Transfer::Run(std::span<const Piece> pieces, const Record& record, bool wait) {
  std::scoped_lock lock(mutex_);
  Chunk* chunk = nullptr;
  if (Status ready = Prepare(!pieces.empty(), chunk); !ready) return ready;
  auto* target = static_cast<std::byte*>(chunk->allocation.mapped);
  for (const Piece& piece : pieces) {
    std::memcpy(target, piece.data(), piece.size());
    target += piece.size();
  }
  return SubmitAndMaybeWait(*chunk, record, wait);
}

Status Transfer::Upload(VkBuffer target, VkDeviceSize offset, std::span<const std::byte> data) {
  while (!data.empty()) {
    const std::size_t size = std::min<std::size_t>(data.size(), kChunkBytes);
    const Piece piece = data.first(size);
    Status done = Run(
        std::span(&piece, 1),
        [&](VkCommandBuffer commands, VkBuffer staging) {
          const VkBufferCopy region{0, offset, size};
          context_.vk.vkCmdCopyBuffer(commands, staging, target, 1, &region);
        },
        false);
    if (!done) return done;
    data = data.subspan(size);
    offset += size;
  }
  return {};
}

Status Transfer::Download(VkBuffer source, VkDeviceSize offset, std::span<std::byte> data) {
  std::scoped_lock lock(mutex_);
  while (!data.empty()) {
    const std::size_t size = std::min<std::size_t>(data.size(), kChunkBytes);
    Chunk* chunk = nullptr;
    if (Status ready = Prepare(true, chunk); !ready) return ready;
    Status done = SubmitAndMaybeWait(
        *chunk,
        [&](VkCommandBuffer commands, VkBuffer staging) {
          const VkBufferCopy region{offset, 0, size};
          context_.vk.vkCmdCopyBuffer(commands, source, staging, 1, &region);
        },
        true);
    if (!done) return done;
    std::memcpy(data.data(), chunk->allocation.mapped, size);
    data = data.subspan(size);
    offset += size;
  }
  return {};
}

Status Transfer::Clear(VkBuffer target, VkDeviceSize offset) {
  return Run(
      {},
      [&](VkCommandBuffer commands, VkBuffer) {
        context_.vk.vkCmdFillBuffer(commands, target, offset, VK_WHOLE_SIZE, 0);
      },
      false);
}

Status Transfer::Copy(VkBuffer source, VkBuffer target, VkDeviceSize size) {
  return Run(
      {},
      [&](VkCommandBuffer commands, VkBuffer) {
        const VkBufferCopy region{0, 0, size};
        context_.vk.vkCmdCopyBuffer(commands, source, target, 1, &region);
      },
      true);
}

}  // namespace wavefront::vulkan
