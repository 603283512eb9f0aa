// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/stream.h"

#include <algorithm>

namespace wavefront {
namespace {

constexpr uint64_t kMostSpareBytes = 1u << 20;

}  // namespace

Range Stream::Allocate(uint64_t count) {
  // Texel buffers are addressed with 31 bits; what passes that is refused at Fit with the stream's name.
  if (count + ranges_.end() > 0x7fffffffull) {
    overflow_ = true;
    return {};
  }
  return ranges_.Allocate(static_cast<uint32_t>(count));
}

Status Stream::Fit(uint64_t atMost) {
  if (overflow_) return Error{"the scene does not fit: more than 2^31 elements of " + name_};
  uint64_t bytes = static_cast<uint64_t>(ranges_.end()) * elementBytes_;
  if (bytes == 0) bytes = 16;
  if (!buffer_) {
    // A little more: what a scene adds to its meshes' streams is small, and growing takes half as much again.
    const uint64_t spare = std::min<uint64_t>(bytes / 64, kMostSpareBytes) / elementBytes_;
    bytes += std::min(spare, atMost - std::min<uint64_t>(atMost, ranges_.end())) * elementBytes_;
    auto created = vulkan::Buffer::Create(device_, {bytes, kind_, vulkan::MemoryLocation::DeviceLocal, name_, true});
    if (!created) return created.error();
    buffer_ = std::move(created).value();
    return {};
  }
  if (bytes <= buffer_->size()) return {};
  return buffer_->Reserve(bytes, atMost > ~uint64_t{0} / elementBytes_ ? ~uint64_t{0} : atMost * elementBytes_);
}

void Stream::Release() {
  buffer_.reset();
  ranges_ = {};
  overflow_ = false;
}

}  // namespace wavefront
