// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A stream: one growing device buffer of equal elements, read by kernels through a texel view, with ranges handed out.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "wavefront/scene/range_allocator.h"
#include "wavefront/vulkan/buffer.h"

namespace wavefront {

// One thread at a time; no submitted work may use the stream while it is written.
class Stream {
 public:
  Stream(vulkan::Device& device, std::string name, vulkan::MemoryKind kind, uint32_t elementBytes)
      : device_(device), name_(std::move(name)), kind_(kind), elementBytes_(elementBytes) {}

  Range Allocate(uint64_t count);
  void Free(Range range) { ranges_.Free(range); }
  // Room for everything that was allocated; call once after all Allocate calls of a commit. Spare room ends at `atMost`
  // elements.
  Status Fit(uint64_t atMost = ~uint64_t{0});
  // Frees the buffer and all ranges.
  void Release();
  template <typename T>
  Status Write(Range range, std::span<const T> values) {
    if (values.empty()) return {};
    return buffer_->Upload(static_cast<uint64_t>(range.first) * elementBytes_, std::as_bytes(values));
  }
  Status Read(uint64_t firstElement, std::span<std::byte> out) { return buffer_->Download(firstElement * elementBytes_, out); }
  vulkan::Buffer* buffer() { return buffer_.get(); }
  uint32_t elements() const { return ranges_.end(); }

 private:
  vulkan::Device& device_;
  std::string name_;
  vulkan::MemoryKind kind_;
  uint32_t elementBytes_;
  RangeAllocator ranges_;
  std::unique_ptr<vulkan::Buffer> buffer_;
  bool overflow_ = false;
};

}  // namespace wavefront
