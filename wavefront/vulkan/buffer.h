// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A range of device memory. Every buffer may be bound as storage, uniform or texel buffer, hold indirect
// arguments, and be copied from and to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/device.h"

namespace wavefront::vulkan {

// DeviceLocal: the fastest memory; written by Upload, directly where memory is unified. HostVisible: always mapped;
// for counters the host reads each frame.
enum class MemoryLocation : uint8_t { DeviceLocal, HostVisible };

// What one element of a texel-buffer view or a texel of an image is.
enum class Format : uint8_t { R32Uint, R32Float, Rg32Uint, Rgba32Uint, Rgba32Float, Rgba8Unorm, Rgba16Float };
constexpr bool IsUint(Format format) { return format == Format::R32Uint || format == Format::Rg32Uint || format == Format::Rgba32Uint; }
uint32_t FormatBytes(Format format);

struct BufferDesc {
  uint64_t size = 0;  // bytes; rounded up to a multiple of 16, at least 16
  MemoryKind kind = MemoryKind::Other;
  MemoryLocation location = MemoryLocation::DeviceLocal;
  std::string name;  // for errors and debuggers
  bool texels = false;  // kernels read it through texel views: a few spare bytes keep drivers from compiling by its size
};

// One thread at a time. The contents start as zeros: what a kernel reads before it is written does not depend on chance.
class Buffer {
 public:
  static Result<std::unique_ptr<Buffer>> Create(Device& device, const BufferDesc& desc);
  // Waits for its own uploads; that no other submitted work uses it any more is the owner's to know.
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  uint64_t size() const { return size_; }  // bytes, as rounded
  const std::string& name() const { return desc_.name; }
  // The memory as the host sees it, or empty where the host cannot reach it. What the device wrote is visible after
  // CommandStream::Wait; what the host writes is visible to later submissions.
  std::span<std::byte> Map();

  // Writes `data` at `offset`. No submitted work may still read the range. Does not wait for the device, except for
  // the staging ring where memory is not unified.
  Status Upload(uint64_t offset, std::span<const std::byte> data);
  template <typename T>
  Status Upload(uint64_t offset, std::span<const T> data) {
    return Upload(offset, std::as_bytes(data));
  }
  // Reads `data.size()` bytes; waits for all submitted work. For read-backs after rendering, not for frames.
  Status Download(uint64_t offset, std::span<std::byte> data);

  // Makes room for `size` bytes, keeping the contents (zeros follow); grows by at least half where the budget and
  // `atMost` bytes allow. No submitted work may still use the buffer. A change of generation() says that descriptor sets must be written again.
  Status Reserve(uint64_t size, uint64_t atMost = ~uint64_t{0});
  uint64_t generation() const { return generation_; }

  // A view for a texel binding; owned and kept by the buffer. `bytes` 0: to the end. An error where the view would
  // pass the limits of the device.
  Result<VkBufferView> TexelView(Format format, uint64_t offset = 0, uint64_t bytes = 0) const;
  VkBuffer handle() const { return handle_; }

 private:
  struct View {
    Format format;
    uint64_t offset, bytes;
    VkBufferView handle;
  };
  struct Memory {
    VkDeviceMemory handle = nullptr;
    uint64_t size = 0;
    void* mapped = nullptr;
  };
  Buffer(Device& device, BufferDesc desc);
  Status Allocate(uint64_t size);
  Status Clear(uint64_t offset);
  void Release();

  ContextRef context_;
  BufferDesc desc_;
  VkBuffer handle_ = nullptr;
  Memory memory_;
  uint64_t spare_ = 0;  // bytes after size_
  uint64_t size_ = 0;
  uint64_t generation_ = 0;
  mutable std::vector<View> views_;
};

}  // namespace wavefront::vulkan
