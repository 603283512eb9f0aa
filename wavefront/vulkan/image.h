// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A sampled image and its sampler: texture page pools and colour look-up tables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/buffer.h"
#include "wavefront/vulkan/device.h"

namespace wavefront::vulkan {

enum class ImageShape : uint8_t { Line, Plane, PlaneArray, Volume };  // sampler1D, sampler2D, sampler2DArray, sampler3D

struct ImageDesc {
  ImageShape shape = ImageShape::Plane;
  Format format = Format::Rgba32Float;
  uint32_t width = 1, height = 1, depth = 1;  // texels
  uint32_t layers = 1;                        // PlaneArray
  MemoryKind kind = MemoryKind::Textures;
  std::string name;
};

// A box of texels and where its data starts; rows, then slices follow each other without gaps.
struct ImageRegion {
  uint32_t x = 0, y = 0, z = 0, layer = 0;
  uint32_t width = 1, height = 1, depth = 1;
  uint64_t dataOffset = 0;  // bytes
};

// One level, no mip chain. One thread at a time. The contents start undefined.
class Image {
 public:
  // An error where the device lacks the size, or linear filtering of the format.
  static Result<std::unique_ptr<Image>> Create(Device& device, const ImageDesc& desc);
  // Waits for its own uploads, as ~Buffer.
  ~Image();
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;

  const ImageDesc& desc() const { return desc_; }
  // Ordered after all submitted work and before all later work; waits for the staging ring only. Give many regions at
  // once: they share submissions.
  Status Upload(std::span<const ImageRegion> regions, std::span<const std::byte> data);
  // All texels of an image of one layer.
  Status Upload(std::span<const std::byte> data);

  VkImage handle() const { return image_; }
  VkImageView view() const { return view_; }

 private:
  Image(Device& device, ImageDesc desc);
  Status Build();
  Status SubmitRegions(std::span<const ImageRegion> regions, std::span<const std::byte> data);

  ContextRef context_;
  ImageDesc desc_;
  VkImage image_ = nullptr;
  VkImageView view_ = nullptr;
  VkDeviceMemory memory_ = nullptr;
  uint64_t memoryBytes_ = 0;
};

enum class Filter : uint8_t { Nearest, Linear };

// Clamps to the edge, normalised coordinates. Thread-safe after creation.
class Sampler {
 public:
  static Result<std::unique_ptr<Sampler>> Create(Device& device, Filter filter);
  ~Sampler();
  Sampler(const Sampler&) = delete;
  Sampler& operator=(const Sampler&) = delete;
  VkSampler handle() const { return sampler_; }

 private:
  explicit Sampler(Device& device);
  ContextRef context_;
  VkSampler sampler_ = nullptr;
};

}  // namespace wavefront::vulkan
