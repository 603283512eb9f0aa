// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Records work, submits it, and says when it is done. A ring of command buffers is reused: no allocation per frame,
// and nothing here waits but Wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/buffer.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/device.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront::vulkan {

struct CommandStreamOptions {
  uint32_t slots = 3;                    // submissions in flight
  uint32_t timestampsPerSubmit = 256;    // 0: none
  std::string name = "stream";
};

// One recording thread; Wait and Completed may be called from any thread.
// Between Begin and Submit the recorded commands run in order but overlap unless a Barrier is between them.
// Begin and Submit put barriers around the whole submission, so submissions never overlap, and what the device wrote
// is visible to the host after Wait.
class CommandStream {
 public:
  static Result<std::unique_ptr<CommandStream>> Create(Device& device, const CommandStreamOptions& options = {});
  // Waits for what was submitted.
  ~CommandStream();
  CommandStream(const CommandStream&) = delete;
  CommandStream& operator=(const CommandStream&) = delete;

  // The value to Wait for before the next Begin can succeed; 0 or a completed value: at once.
  uint64_t nextFreeAt() const;
  // Starts recording in the next slot. An error where that slot is still in flight (see nextFreeAt).
  Status Begin();

  // The bindings and push constants keep their values over pipelines of the same layout.
  void BindSet(const DescriptorSet& set);
  void BindPipeline(const ComputePipeline& pipeline);
  // At most kPushConstantBytes, a multiple of 4; after BindSet.
  void PushConstants(std::span<const std::byte> data, uint32_t offset = 0);
  void Dispatch(uint32_t x, uint32_t y = 1, uint32_t z = 1);
  // Three uint32 group counts at `offset` (a multiple of 4).
  void DispatchIndirect(const Buffer& arguments, uint64_t offset);

  // Everything recorded before is finished and visible to everything after: kernels, copies, indirect arguments.
  void Barrier();

  // Sizes and offsets are multiples of 4. Update: at most 65536 bytes, copied at the call. `bytes` 0: to the end.
  void Fill(const Buffer& target, uint64_t offset, uint64_t bytes, uint32_t value);
  void Update(const Buffer& target, uint64_t offset, std::span<const std::byte> data);
  void Copy(const Buffer& source, uint64_t sourceOffset, const Buffer& target, uint64_t targetOffset, uint64_t bytes);

  // Index of a timestamp taken when everything recorded before is finished, or kNoTimestamp when the submission has
  // no more left.
  static constexpr uint32_t kNoTimestamp = 0xffffffffu;
  uint32_t Timestamp();
  // Named region in a debugger; costs nothing without one.
  void BeginLabel(const char* name);
  void EndLabel();

  // Submits what was recorded; the value is complete when all of it is done. Values count up from 1.
  Result<uint64_t> Submit();
  // False: the time ran out.
  Result<bool> Wait(uint64_t value, uint64_t timeoutNanoseconds = UINT64_MAX);
  Result<uint64_t> Completed() const;

  // Nanoseconds on the device's clock of the timestamps of a completed submission, by index; the count written. An
  // error when its slot was begun again.
  Result<uint32_t> ReadTimestamps(uint64_t value, std::span<double> nanoseconds) const;

 private:
  struct Slot {
    VkCommandPool pool = nullptr;
    VkCommandBuffer commands = nullptr;
    uint64_t value = 0;  // of its last submission
    uint32_t timestamps = 0;
  };
  explicit CommandStream(Device& device);
  Status Build(const CommandStreamOptions& options);
  Slot& slot() { return slots_[current_]; }

  ContextRef context_;
  std::vector<Slot> slots_;
  std::size_t current_ = 0;
  bool recording_ = false;
  VkSemaphore timeline_ = nullptr;
  uint64_t submitted_ = 0;
  VkQueryPool queries_ = nullptr;
  uint32_t queriesPerSlot_ = 0;
  VkPipelineLayout boundLayout_ = nullptr;
  mutable std::vector<uint64_t> ticks_;
};

}  // namespace wavefront::vulkan
