// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/color_kernel.h"

#include <algorithm>

#include "wavefront/vulkan/command_stream.h"

namespace wavefront {
namespace {

bool Same(const std::vector<Renderer::ColorLut>& a, const std::vector<Renderer::ColorLut>& b) {
  return std::ranges::equal(a, b, [](const Renderer::ColorLut& x, const Renderer::ColorLut& y) {
    return x.sampler == y.sampler && x.dimension == y.dimension && x.width == y.width && x.height == y.height &&
           x.depth == y.depth && x.components == y.components && x.linear == y.linear && x.values == y.values &&
           x.binding == y.binding;
  });
}

// The image of a table, with four components: missing ones are 1.
Result<std::unique_ptr<vulkan::Image>> MakeTable(vulkan::Device& device, const Renderer::ColorLut& lut) {
  using namespace vulkan;
  ImageDesc desc;
  desc.shape = lut.dimension == 1 ? ImageShape::Line : lut.dimension == 2 ? ImageShape::Plane : ImageShape::Volume;
  desc.width = lut.width;
  desc.height = lut.height;
  desc.depth = lut.depth;
  desc.kind = MemoryKind::Tables;
  desc.name = lut.sampler;
  auto image = Image::Create(device, desc);
  if (!image) return image.error();
  const std::size_t texels = static_cast<std::size_t>(lut.width) * lut.height * lut.depth;
  if (lut.components == 0 || lut.values.size() < texels * lut.components)
    return Error{"the colour table " + lut.sampler + " is too short"};
  std::vector<float> values(texels * 4, 1.0f);
  for (std::size_t t = 0; t < texels; ++t)
    for (uint32_t c = 0; c < std::min(lut.components, 4u); ++c)
      values[4 * t + c] = lut.values[t * lut.components + c];
  if (Status s = image.value()->Upload(std::as_bytes(std::span(values))); !s) return s.error();
  return std::move(image).value();
}

}  // namespace

Result<std::unique_ptr<ColorKernel::Built>> ColorKernel::Build(vulkan::Device& device, std::span<const uint32_t> spirv,
                                                               const std::vector<Renderer::ColorLut>& luts) {
  using namespace vulkan;
  auto built = std::make_unique<Built>();
  built->spirv.assign(spirv.begin(), spirv.end());
  built->luts = luts;
  std::vector<Binding> bindings{{0, DescriptorKind::StorageBuffer, 1}};
  for (const auto& lut : luts) bindings.push_back({lut.binding, DescriptorKind::SampledImage, 1});
  auto layout = PipelineLayout::Create(device, bindings, "colour");
  if (!layout) return layout.error();
  built->layout = std::move(layout).value();
  auto pipeline = ComputePipeline::Create(device, *built->layout, {spirv, "main", {}, "colour"});
  if (!pipeline) return pipeline.error();
  built->pipeline = std::move(pipeline).value();
  auto set = DescriptorSet::Create(device, *built->layout, "colour");
  if (!set) return set.error();
  built->set = std::move(set).value();
  auto linear = Sampler::Create(device, Filter::Linear), nearest = Sampler::Create(device, Filter::Nearest);
  if (!linear) return linear.error();
  if (!nearest) return nearest.error();
  built->linear = std::move(linear).value();
  built->nearest = std::move(nearest).value();
  for (const auto& lut : luts) {
    auto image = MakeTable(device, lut);
    if (!image) return image.error();
    built->images.push_back(std::move(image).value());
    if (Status s = built->set->WriteImage(lut.binding, *built->images.back(),
                                          lut.linear ? *built->linear : *built->nearest);
        !s)
      return s.error();
  }
  return built;
}

Status ColorKernel::Run(vulkan::Device& device, std::span<const uint32_t> spirv,
                        const std::vector<Renderer::ColorLut>& luts, std::span<float> rgba, uint32_t width,
                        uint32_t height) {
  using namespace vulkan;
  const uint64_t pixels = static_cast<uint64_t>(width) * height;
  if (pixels == 0) return {};
  if (rgba.size() != pixels * 4) return Error{"the colour kernel wants width * height * 4 floats"};
  if (!built_ || !std::ranges::equal(built_->spirv, spirv) || !Same(built_->luts, luts)) {
    built_.reset();
    auto built = Build(device, spirv, luts);
    if (!built) return built.error();
    built_ = std::move(built).value();
    ++builds_;
  }
  // Slices keep the buffer inside a storage binding and the memory small.
  const uint64_t slice = std::min<uint64_t>(pixels, device.info().limits.maxStorageBufferRange / 16);
  auto buffer = Buffer::Create(device, {slice * 16, MemoryKind::Film, MemoryLocation::DeviceLocal, "colour pixels"});
  if (!buffer) return buffer.error();
  if (Status s = built_->set->Write(0, *buffer.value()); !s) return s;
  auto stream = CommandStream::Create(device, {1, 0, "colour"});
  if (!stream) return stream.error();
  for (uint64_t first = 0; first < pixels; first += slice) {
    const uint32_t count = static_cast<uint32_t>(std::min(slice, pixels - first));
    const std::span<float> part = rgba.subspan(first * 4, static_cast<std::size_t>(count) * 4);
    if (Status s = buffer.value()->Upload<float>(0, part); !s) return s;
    if (Status s = stream.value()->Begin(); !s) return s;
    stream.value()->BindSet(*built_->set);
    stream.value()->BindPipeline(*built_->pipeline);
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
