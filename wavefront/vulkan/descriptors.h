// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Bindings: one layout of set 0 and one pipeline layout for all kernels that share them, and sets that fill it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/buffer.h"
#include "wavefront/vulkan/device.h"

namespace wavefront::vulkan {

class Image;
class Sampler;

enum class DescriptorKind : uint8_t {
  StorageBuffer,
  UniformBuffer,
  TexelBufferUint,   // usamplerBuffer (utextureBuffer)
  TexelBufferFloat,  // samplerBuffer (textureBuffer)
  SampledImage       // sampler1D, 2D, 2DArray, 3D; every one must be written before use
};

struct Binding {
  uint32_t number = 0;
  DescriptorKind kind = DescriptorKind::StorageBuffer;
  uint32_t count = 1;  // array size
  Format format = Format::Rgba32Uint;  // of a texel buffer, as kernels will find it
};

constexpr uint32_t kPushConstantBytes = 128;

// Thread-safe after creation.
class PipelineLayout {
 public:
  static Result<std::unique_ptr<PipelineLayout>> Create(Device& device, std::vector<Binding> bindings,
                                                        std::string name = "bindings");
  ~PipelineLayout();
  PipelineLayout(const PipelineLayout&) = delete;
  PipelineLayout& operator=(const PipelineLayout&) = delete;

  const std::vector<Binding>& bindings() const { return bindings_; }
  const Binding* Find(uint32_t number) const;
  VkDescriptorSetLayout setLayout() const { return setLayout_; }
  VkPipelineLayout handle() const { return layout_; }
  const Buffer& zeros() const { return *zeros_; }

 private:
  friend class DescriptorSet;
  explicit PipelineLayout(Device& device);
  Status Build();

  ContextRef context_;
  std::vector<Binding> bindings_;
  std::unique_ptr<Buffer> zeros_;  // what unwritten buffer bindings see
  VkDescriptorSetLayout setLayout_ = nullptr;
  VkPipelineLayout layout_ = nullptr;
};

// A filled set 0. Buffer and texel bindings that were never written see a small buffer of zeros, so a scene without
// lights needs no special case. One thread at a time; not to be written while submitted work uses it: keep one set
// per submission in flight where bindings change between frames. The layout, and what is written, must outlive the set's use.
class DescriptorSet {
 public:
  static Result<std::unique_ptr<DescriptorSet>> Create(Device& device, const PipelineLayout& layout,
                                                       std::string name = "set");
  ~DescriptorSet();
  DescriptorSet(const DescriptorSet&) = delete;
  DescriptorSet& operator=(const DescriptorSet&) = delete;

  // Storage or uniform buffer. `bytes` 0: to the end. An error where the range passes the device's limit.
  Status Write(uint32_t number, const Buffer& buffer, uint64_t offset = 0, uint64_t bytes = 0);
  // Texel buffer; the format's numeric type must be the binding's.
  Status WriteTexels(uint32_t number, const Buffer& buffer, Format format, uint64_t offset = 0, uint64_t bytes = 0);
  Status WriteTexels(uint32_t number, const Buffer& buffer);  // all of it, in the format that the layout says
  Status WriteImage(uint32_t number, const Image& image, const Sampler& sampler, uint32_t element = 0);

  const PipelineLayout& layout() const { return layout_; }
  VkDescriptorSet handle() const { return set_; }

 private:
  DescriptorSet(Device& device, const PipelineLayout& layout);
  Status FillWithZeros();

  ContextRef context_;
  const PipelineLayout& layout_;
  VkDescriptorPool pool_ = nullptr;
  VkDescriptorSet set_ = nullptr;
};

}  // namespace wavefront::vulkan
