// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/image.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/formats.h"
#include "wavefront/vulkan/transfer.h"

namespace wavefront::vulkan {
namespace {

uint64_t RegionBytes(const ImageRegion& region, Format format) {
  return uint64_t{region.width} * region.height * region.depth * FormatBytes(format);
}

std::string SizeText(const ImageDesc& desc) {
  return std::to_string(desc.width) + "x" + std::to_string(desc.height) + "x" + std::to_string(desc.depth) + ", " +
         std::to_string(desc.layers) + " layers";
}

// Halves of a region that follow each other in the data: slices, else rows, else texels of the one row.
std::pair<ImageRegion, ImageRegion> Split(const ImageRegion& region, Format format) {
  ImageRegion first = region, second = region;
  if (region.depth > 1) {
    first.depth = region.depth / 2, second.depth -= first.depth, second.z += first.depth;
  } else if (region.height > 1) {
    first.height = region.height / 2, second.height -= first.height, second.y += first.height;
  } else {
    first.width = region.width / 2, second.width -= first.width, second.x += first.width;
  }
  second.dataOffset += RegionBytes(first, format);
  return {first, second};
}

}  // namespace

Image::Image(Device& device, ImageDesc desc) : context_(device.context()), desc_(std::move(desc)) {}

Image::~Image() {
  const VolkDeviceTable& vk = context_->vk;
  if (memory_ != nullptr) context_->transfer().Drain();
  if (view_ != nullptr) vk.vkDestroyImageView(context_->device, view_, nullptr);
  if (image_ != nullptr) vk.vkDestroyImage(context_->device, image_, nullptr);
  context_->Free({memory_, memoryBytes_, nullptr}, desc_.kind);
}

Result<std::unique_ptr<Image>> Image::Create(Device& device, const ImageDesc& desc) {
  const DeviceLimits& limits = device.info().limits;
  const bool volume = desc.shape == ImageShape::Volume;
  const uint32_t side = volume ? limits.maxImageDimension3D : limits.maxImageDimension2D;
  const bool flat = desc.shape == ImageShape::Line ? desc.height == 1 : true;
  if (desc.width == 0 || desc.height == 0 || desc.depth == 0 || desc.layers == 0 || !flat || desc.width > side ||
      desc.height > side || desc.depth > (volume ? side : 1) ||
      desc.layers > (desc.shape == ImageShape::PlaneArray ? limits.maxImageArrayLayers : 1)) {
    return Error{"image '" + desc.name + "' (" + SizeText(desc) + ") is not possible on " + device.info().name};
  }
  std::unique_ptr<Image> image(new Image(device, desc));
  if (Status built = image->Build(); !built) return built.error();
  return image;
}

Status Image::Build() {
  const VolkDeviceTable& vk = context_->vk;
  const VkFormat format = ToVulkan(desc_.format);
  const bool integer = desc_.format == Format::R32Uint || desc_.format == Format::Rg32Uint || desc_.format == Format::Rgba32Uint;
  VkFormatFeatureFlags wanted = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
  if (!integer) wanted |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
  VkFormatProperties properties{};
  vkGetPhysicalDeviceFormatProperties(context_->physical, format, &properties);
  if ((properties.optimalTilingFeatures & wanted) != wanted) {
    return Error{context_->info.name + " cannot sample the format of image '" + desc_.name + "' linearly"};
  }

  const bool line = desc_.shape == ImageShape::Line, volume = desc_.shape == ImageShape::Volume;
  auto info = Struct<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = line ? VK_IMAGE_TYPE_1D : volume ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {desc_.width, desc_.height, desc_.depth};
  info.mipLevels = 1;
  info.arrayLayers = desc_.layers;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  VkResult result = vk.vkCreateImage(context_->device, &info, nullptr, &image_);
  if (result != VK_SUCCESS) {
    image_ = nullptr;
    return context_->Fail("vkCreateImage", result);
  }
  VkMemoryRequirements needs{};
  vk.vkGetImageMemoryRequirements(context_->device, image_, &needs);
  auto allocation = context_->Allocate(needs, false, desc_.kind, desc_.name);
  if (!allocation) return allocation.error();
  memory_ = allocation->memory;
  memoryBytes_ = allocation->size;
  result = vk.vkBindImageMemory(context_->device, image_, memory_, 0);
  if (result != VK_SUCCESS) return context_->Fail("vkBindImageMemory", result);

  auto view = Struct<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = image_;
  view.viewType = line ? VK_IMAGE_VIEW_TYPE_1D
                  : volume ? VK_IMAGE_VIEW_TYPE_3D
                  : desc_.shape == ImageShape::PlaneArray ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                          : VK_IMAGE_VIEW_TYPE_2D;
  view.format = format;
  view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, desc_.layers};
  result = vk.vkCreateImageView(context_->device, &view, nullptr, &view_);
  if (result != VK_SUCCESS) return context_->Fail("vkCreateImageView", result);
  context_->Name(VK_OBJECT_TYPE_IMAGE, image_, desc_.name);

  // The general layout for life: pages are written while others are sampled, and no device of interest is slower by it.
  return context_->transfer().Run(
      {},
      [&](VkCommandBuffer commands, VkBuffer) {
        auto barrier = Struct<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_READ_BIT;
        barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image_;
        barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, desc_.layers};
        auto dependency = Struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
        dependency.imageMemoryBarrierCount = 1;
        dependency.pImageMemoryBarriers = &barrier;
        vk.vkCmdPipelineBarrier2(commands, &dependency);
      },
      false);
}

Status Image::SubmitRegions(std::span<const ImageRegion> regions, std::span<const std::byte> data) {
  std::vector<Transfer::Piece> pieces;
  std::vector<VkBufferImageCopy> copies;
  VkDeviceSize offset = 0;
  for (const ImageRegion& region : regions) {
    VkBufferImageCopy copy{};
    copy.bufferOffset = offset;
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, region.layer, 1};
    copy.imageOffset = {static_cast<int32_t>(region.x), static_cast<int32_t>(region.y), static_cast<int32_t>(region.z)};
    copy.imageExtent = {region.width, region.height, region.depth};
    copies.push_back(copy);
    pieces.push_back(data.subspan(region.dataOffset, RegionBytes(region, desc_.format)));
    offset += pieces.back().size();
  }
  return context_->transfer().Run(
      pieces,
      [&](VkCommandBuffer commands, VkBuffer staging) {
        context_->vk.vkCmdCopyBufferToImage(commands, staging, image_, VK_IMAGE_LAYOUT_GENERAL,
                                            static_cast<uint32_t>(copies.size()), copies.data());
      },
      false);
}

// As many regions to a submission as a staging chunk takes; a region too big for one goes in halves.
Status Image::Upload(std::span<const ImageRegion> regions, std::span<const std::byte> data) {
  std::vector<ImageRegion> waiting(regions.rbegin(), regions.rend()), batch;
  for (const ImageRegion& region : regions) {
    const auto inside = [](uint32_t start, uint32_t count, uint32_t size) {
      return count > 0 && start <= size && count <= size - start;
    };
    if (!inside(region.x, region.width, desc_.width) || !inside(region.y, region.height, desc_.height) ||
        !inside(region.z, region.depth, desc_.depth) || region.layer >= desc_.layers || region.dataOffset > data.size() ||
        RegionBytes(region, desc_.format) > data.size() - region.dataOffset) {
      return Error{"an upload passes the end of image '" + desc_.name + "' or of its data"};
    }
  }
  for (const ImageRegion& region : regions) context_->uploadedBytes += RegionBytes(region, desc_.format);
  uint64_t bytes = 0;
  while (!waiting.empty()) {
    const ImageRegion region = waiting.back();
    const uint64_t size = RegionBytes(region, desc_.format);
    waiting.pop_back();
    if (size > Transfer::kChunkBytes) {
      const auto [first, second] = Split(region, desc_.format);
      waiting.push_back(second);
      waiting.push_back(first);
      continue;
    }
    if (bytes + size > Transfer::kChunkBytes) {
      if (Status done = SubmitRegions(batch, data); !done) return done;
      batch.clear();
      bytes = 0;
    }
    batch.push_back(region);
    bytes += size;
  }
  return batch.empty() ? Status{} : SubmitRegions(batch, data);
}

Status Image::Upload(std::span<const std::byte> data) {
  const ImageRegion region{0, 0, 0, 0, desc_.width, desc_.height, desc_.depth, 0};
  return Upload(std::span(&region, 1), data);
}

Sampler::Sampler(Device& device) : context_(device.context()) {}

Sampler::~Sampler() {
  if (sampler_ != nullptr) context_->vk.vkDestroySampler(context_->device, sampler_, nullptr);
}

Result<std::unique_ptr<Sampler>> Sampler::Create(Device& device, Filter filter) {
  std::unique_ptr<Sampler> sampler(new Sampler(device));
  const VkFilter vkFilter = filter == Filter::Linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
  auto info = Struct<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
  info.magFilter = info.minFilter = vkFilter;
  info.addressModeU = info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  const VkResult result = sampler->context_->vk.vkCreateSampler(sampler->context_->device, &info, nullptr, &sampler->sampler_);
  if (result != VK_SUCCESS) return sampler->context_->Fail("vkCreateSampler", result);
  return sampler;
}

}  // namespace wavefront::vulkan
