// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/buffer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/formats.h"
#include "wavefront/vulkan/transfer.h"

namespace wavefront::vulkan {
namespace {

constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                                      VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT |
                                      VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                                      VK_BUFFER_USAGE_TRANSFER_DST_BIT;

uint64_t RoundUp(uint64_t size) { return std::max<uint64_t>(16, (size + 15) & ~uint64_t{15}); }

// Mesa's software driver compiles a kernel for two facts about each texel buffer that it reads: whether the buffer's size is
// a power of two, and whether bits 8 to 15 of the view's are all zero (lp_sampler_static_texture_state takes them for those
// of an image). With these spare bytes neither is ever so, and code that was compiled once serves buffers of all sizes.
uint64_t SpareBytes(uint64_t size) {
  uint64_t spare = 0;
  const auto isSpecial = [](uint64_t n) { return (n & (n - 1)) == 0 || ((n >> 8) & 255) == 0; };
  while (isSpecial(size + spare)) spare += 272;
  return spare;
}

}  // namespace

VkFormat ToVulkan(Format format) {
  switch (format) {
    case Format::R32Uint: return VK_FORMAT_R32_UINT;
    case Format::R32Float: return VK_FORMAT_R32_SFLOAT;
    case Format::Rg32Uint: return VK_FORMAT_R32G32_UINT;
    case Format::Rgba32Uint: return VK_FORMAT_R32G32B32A32_UINT;
    case Format::Rgba32Float: return VK_FORMAT_R32G32B32A32_SFLOAT;
    case Format::Rgba8Unorm: return VK_FORMAT_R8G8B8A8_UNORM;
    case Format::Rgba16Float: return VK_FORMAT_R16G16B16A16_SFLOAT;
  }
  return VK_FORMAT_UNDEFINED;
}

uint32_t FormatBytes(Format format) {
  switch (format) {
    case Format::R32Uint:
    case Format::R32Float:
    case Format::Rgba8Unorm: return 4;
    case Format::Rg32Uint:
    case Format::Rgba16Float: return 8;
    case Format::Rgba32Uint:
    case Format::Rgba32Float: return 16;
  }
  return 0;
}

Buffer::Buffer(Device& device, BufferDesc desc) : context_(device.context()), desc_(std::move(desc)) {}

Buffer::~Buffer() { Release(); }

void Buffer::Release() {
  const VolkDeviceTable& vk = context_->vk;
  if (memory_.handle != nullptr && memory_.mapped == nullptr) context_->transfer().Drain();
  for (const View& view : views_) vk.vkDestroyBufferView(context_->device, view.handle, nullptr);
  views_.clear();
  if (handle_ != nullptr) vk.vkDestroyBuffer(context_->device, handle_, nullptr);
  context_->Free({memory_.handle, memory_.size, memory_.mapped}, desc_.kind);
  handle_ = nullptr;
  memory_ = {};
  size_ = 0;
}

Status Buffer::Allocate(uint64_t size) {
  const VolkDeviceTable& vk = context_->vk;
  const uint64_t rounded = RoundUp(size), spare = desc_.texels ? SpareBytes(rounded) : 0;
  if (rounded < size || rounded + spare < size || rounded + spare > context_->info.limits.maxBufferSize) {
    return Error{"'" + desc_.name + "' needs " + BytesText(size) + ", more than one buffer of " + context_->info.name +
                 " can hold (" + BytesText(context_->info.limits.maxBufferSize) + ")"};
  }
  auto info = Struct<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = rounded + spare;
  info.usage = kUsage;
  VkResult result = vk.vkCreateBuffer(context_->device, &info, nullptr, &handle_);
  if (result != VK_SUCCESS) {
    handle_ = nullptr;
    return context_->Fail("vkCreateBuffer", result);
  }
  VkMemoryRequirements needs{};
  vk.vkGetBufferMemoryRequirements(context_->device, handle_, &needs);
  auto allocation = context_->Allocate(needs, desc_.location == MemoryLocation::HostVisible, desc_.kind, desc_.name);
  if (!allocation) {
    Release();
    return allocation.error();
  }
  memory_ = {allocation->memory, allocation->size, allocation->mapped};
  result = vk.vkBindBufferMemory(context_->device, handle_, memory_.handle, 0);
  if (result != VK_SUCCESS) {
    Release();
    return context_->Fail("vkBindBufferMemory", result);
  }
  size_ = rounded;
  spare_ = spare;
  ++generation_;
  context_->Name(VK_OBJECT_TYPE_BUFFER, handle_, desc_.name);
  return {};
}

Status Buffer::Clear(uint64_t offset) {
  if (offset == size_) return {};
  if (memory_.mapped == nullptr) return context_->transfer().Clear(handle_, offset);
  std::memset(static_cast<std::byte*>(memory_.mapped) + offset, 0, size_ - offset);
  return {};
}

Result<std::unique_ptr<Buffer>> Buffer::Create(Device& device, const BufferDesc& desc) {
  std::unique_ptr<Buffer> buffer(new Buffer(device, desc));
  if (Status allocated = buffer->Allocate(desc.size); !allocated) return allocated.error();
  if (Status cleared = buffer->Clear(0); !cleared) return cleared.error();
  return buffer;
}

std::span<std::byte> Buffer::Map() {
  if (memory_.mapped == nullptr) return {};
  return {static_cast<std::byte*>(memory_.mapped), static_cast<std::size_t>(size_)};
}

Status Buffer::Upload(uint64_t offset, std::span<const std::byte> data) {
  if (offset > size_ || data.size() > size_ - offset) {
    return Error{"an upload of " + std::to_string(data.size()) + " bytes at " + std::to_string(offset) + " passes the end of '" +
                 desc_.name + "' (" + std::to_string(size_) + " bytes)"};
  }
  if (data.empty()) return {};
  context_->uploadedBytes += data.size();
  if (memory_.mapped == nullptr) return context_->transfer().Upload(handle_, offset, data);
  std::memcpy(static_cast<std::byte*>(memory_.mapped) + offset, data.data(), data.size());
  return {};
}

Status Buffer::Download(uint64_t offset, std::span<std::byte> data) {
  if (offset > size_ || data.size() > size_ - offset) {
    return Error{"a download of " + std::to_string(data.size()) + " bytes at " + std::to_string(offset) +
                 " passes the end of '" + desc_.name + "' (" + std::to_string(size_) + " bytes)"};
  }
  if (data.empty()) return {};
  if (memory_.mapped == nullptr) return context_->transfer().Download(handle_, offset, data);
  if (Status idle = context_->WaitIdle(); !idle) return idle;
  std::memcpy(data.data(), static_cast<const std::byte*>(memory_.mapped) + offset, data.size());
  return {};
}

Status Buffer::Reserve(uint64_t size, uint64_t atMost) {
  if (size <= size_) return {};
  std::vector<View> oldViews = std::exchange(views_, {});
  const VkBuffer oldHandle = std::exchange(handle_, nullptr);
  const Memory oldMemory = std::exchange(memory_, {});
  const uint64_t oldSize = std::exchange(size_, 0);

  Status grown = Allocate(std::max(size, std::min(oldSize + oldSize / 2, atMost)));
  if (!grown) grown = Allocate(size);  // where half more does not fit, what is needed may
  if (grown) {
    if (memory_.mapped != nullptr && oldMemory.mapped != nullptr) {
      std::memcpy(memory_.mapped, oldMemory.mapped, oldSize);
    } else {
      grown = context_->transfer().Copy(oldHandle, handle_, oldSize);
    }
    if (grown) grown = Clear(oldSize);
    if (!grown) Release();
  }
  if (!grown) {  // as before
    views_ = std::move(oldViews), handle_ = oldHandle, memory_ = oldMemory, size_ = oldSize;
    return grown;
  }
  if (oldMemory.mapped == nullptr) context_->transfer().Drain();
  for (const View& view : oldViews) context_->vk.vkDestroyBufferView(context_->device, view.handle, nullptr);
  context_->vk.vkDestroyBuffer(context_->device, oldHandle, nullptr);
  context_->Free({oldMemory.handle, oldMemory.size, oldMemory.mapped}, desc_.kind);
  return {};
}

Result<VkBufferView> Buffer::TexelView(Format format, uint64_t offset, uint64_t bytes) const {
  const DeviceLimits& limits = context_->info.limits;
  uint64_t range = bytes != 0 ? bytes : size_ - std::min(offset, size_);
  const bool isWithin = (range + spare_) / FormatBytes(format) <= limits.maxTexelBufferElements;
  if (range == 0 || offset > size_ || range > size_ - offset || offset % limits.texelBufferOffsetAlignment != 0 ||
      range % FormatBytes(format) != 0) {
    return Error{"a texel view of " + std::to_string(range) + " bytes at " + std::to_string(offset) + " does not fit '" +
                 desc_.name + "' (" + std::to_string(size_) + " bytes)"};
  }
  if (range / FormatBytes(format) > limits.maxTexelBufferElements) {
    return Error{"'" + desc_.name + "' holds " + std::to_string(range / FormatBytes(format)) + " texels; " +
                 context_->info.name + " can address " + std::to_string(limits.maxTexelBufferElements)};
  }
  if (bytes == 0 && isWithin) range += spare_;
  for (const View& view : views_) {
    if (view.format == format && view.offset == offset && view.bytes == range) return VkBufferView{view.handle};
  }
  auto info = Struct<VkBufferViewCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO);
  info.buffer = handle_;
  info.format = ToVulkan(format);
  info.offset = offset;
  info.range = range;
  VkBufferView view = nullptr;
  const VkResult result = context_->vk.vkCreateBufferView(context_->device, &info, nullptr, &view);
  if (result != VK_SUCCESS) return context_->Fail("vkCreateBufferView", result);
  views_.push_back({format, offset, range, view});
  return view;
}

}  // namespace wavefront::vulkan
