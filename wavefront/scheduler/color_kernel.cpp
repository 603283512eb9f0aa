// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/color_kernel.h"

#include <algorithm>

#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/image.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront {

Status RunColor(vulkan::Device& device, std::span<const uint32_t> spirv, const std::vector<Renderer::ColorLut>& luts,
                std::span<float> rgba, uint32_t width, uint32_t height) {
  using namespace vulkan;
  const uint64_t pixels = static_cast<uint64_t>(width) * height;
  if (pixels == 0) return {};
  if (rgba.size() != pixels * 4) return Error{"the colour kernel wants width * height * 4 floats"};
  std::vector<Binding> bindings{{0, DescriptorKind::StorageBuffer, 1}};
  for (const auto& lut : luts) bindings.push_back({lut.binding, DescriptorKind::SampledImage, 1});
  auto layout = PipelineLayout::Create(device, bindings, "colour");
  if (!layout) return layout.error();
  auto pipeline = ComputePipeline::Create(device, *layout.value(), {spirv, "main", {}, "colour"});
  if (!pipeline) return pipeline.error();
  auto set = DescriptorSet::Create(device, *layout.value(), "colour");
  if (!set) return set.error();
  std::vector<std::unique_ptr<Image>> images;
  auto linear = Sampler::Create(device, Filter::Linear);
  auto nearest = Sampler::Create(device, Filter::Nearest);
  if (!linear) return linear.error();
  if (!nearest) return nearest.error();
  for (const auto& lut : luts) {
    ImageDesc desc;
    desc.shape = lut.dimension == 1 ? ImageShape::Line : lut.dimension == 2 ? ImageShape::Plane : ImageShape::Volume;
    desc.width = lut.width; desc.height = lut.height; desc.depth = lut.depth;
    desc.kind = MemoryKind::Tables;
    desc.name = lut.sampler;
    auto image = Image::Create(device, desc);
    if (!image) return image.error();
    const std::size_t texels = static_cast<std::size_t>(lut.width) * lut.height * lut.depth;
    if (lut.components == 0 || lut.values.size() < texels * lut.components) return Error{"the colour table " + lut.sampler + " is too short"};
    std::vector<float> values(texels * 4, 1.0f);
    for (std::size_t t = 0; t < texels; ++t) {
      for (uint32_t c = 0; c < std::min(lut.components, 4u); ++c) values[4 * t + c] = lut.values[t * lut.components + c];
    }
    if (Status s = image.value()->Upload(std::as_bytes(std::span(values))); !s) return s;
    if (Status s = set.value()->WriteImage(lut.binding, *image.value(), lut.linear ? *linear.value() : *nearest.value()); !s) return s;
    images.push_back(std::move(image).value());
  }
  // Slices keep the buffer inside a storage binding and the memory small.
  const uint64_t slice = std::min<uint64_t>(pixels, device.info().limits.maxStorageBufferRange / 16);
  auto buffer = Buffer::Create(device, {slice * 16, MemoryKind::Film, MemoryLocation::DeviceLocal, "colour pixels"});
  if (!buffer) return buffer.error();
  if (Status s = set.value()->Write(0, *buffer.value()); !s) return s;
  auto stream = CommandStream::Create(device, {1, 0, "colour"});
  if (!stream) return stream.error();
  for (uint64_t first = 0; first < pixels; first += slice) {
    const uint32_t count = static_cast<uint32_t>(std::min(slice, pixels - first));
    const std::span<float> part = rgba.subspan(first * 4, static_cast<std::size_t>(count) * 4);
    if (Status s = buffer.value()->Upload<float>(0, part); !s) return s;
    if (Status s = stream.value()->Begin(); !s) return s;
    stream.value()->BindSet(*set.value());
    stream.value()->BindPipeline(*pipeline.value());
    stream.value()->PushConstants(std::as_bytes(std::span(&count, 1)));
    // Group counts in x end at 65,535.
    const uint32_t groups = (count + 63) / 64;
    stream.value()->Dispatch(std::min(groups, 65535u), (groups + 65534) / 65535);
    auto value = stream.value()->Submit();
    if (!value) return value.error();
    if (auto done = stream.value()->Wait(value.value()); !done) return done.error();
    if (Status s = buffer.value()->Download(0, std::as_writable_bytes(part)); !s) return s;
  }
  return {};
}

}  // namespace wavefront
