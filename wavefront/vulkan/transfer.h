// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Copies between host and device through a ring of staging chunks, on the compute queue. Private to
// wavefront/vulkan. Thread-safe. Ordered with every submission of the queue, before and after.
#pragma once

#include <volk.h>

#include <array>
#include <cstddef>
#include <functional>
#include <mutex>
#include <span>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/context.h"

namespace wavefront::vulkan {

class Transfer {
 public:
  static constexpr VkDeviceSize kChunkBytes = 8u << 20;
  static constexpr std::size_t kChunks = 4;

  explicit Transfer(Context& context) : context_(context) {}
  ~Transfer();
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;

  // Returns when `data` may be reused; waits only for chunks of its own ring.
  Status Upload(VkBuffer target, VkDeviceSize offset, std::span<const std::byte> data);
  // Waits for all work submitted before, and for the copy.
  Status Download(VkBuffer source, VkDeviceSize offset, std::span<std::byte> data);
  // Waits as Download does.
  Status Copy(VkBuffer source, VkBuffer target, VkDeviceSize size);
  // Zeros from `offset` to the end; does not wait.
  Status Clear(VkBuffer target, VkDeviceSize offset);
  // Waits for every copy submitted so far: what they touch may then be destroyed.
  void Drain();
  // Submits what `record` records, with the pieces (together at most kChunkBytes) staged one after another from offset
  // 0 of the buffer that it is given.
  using Piece = std::span<const std::byte>;
  using Record = std::function<void(VkCommandBuffer, VkBuffer)>;
  Status Run(std::span<const Piece> pieces, const Record& record, bool wait);

 private:
  struct Chunk {
    VkBuffer buffer = VK_NULL_HANDLE;
    Allocation allocation;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    uint64_t busyUntil = 0;
  };
  Status Prepare(bool staging, Chunk*& chunk);
  Status CreateShared();
  Status CreateStaging(Chunk& chunk);
  Status SubmitAndMaybeWait(Chunk& chunk, const Record& record, bool wait);
  Status Wait(uint64_t value);

  Context& context_;
  std::mutex mutex_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkSemaphore timeline_ = VK_NULL_HANDLE;
  uint64_t submitted_ = 0;
  std::array<Chunk, kChunks> chunks_;
  std::size_t next_ = 0;
};

// Everything before is finished and visible to everything after, transfers and indirect arguments included.
void FullBarrier(const VolkDeviceTable& vk, VkCommandBuffer commands, bool toHost);

}  // namespace wavefront::vulkan
