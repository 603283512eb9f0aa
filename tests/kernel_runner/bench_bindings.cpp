// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// `_kernel_runner.Bench`: buffers, mip-mapped images and kernels that stay on the device, so that variants of one thing can
// be timed in turn. Images here have what the renderer's own (wavefront/vulkan/image.h) has no use for: mip chains,
// repeating samplers, an array of descriptors.
#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <volk.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/formats.h"
#include "wavefront/vulkan/transfer.h"

namespace nb = nanobind;
using namespace wavefront::vulkan;

namespace {

template <typename T>
T Must(wavefront::Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}
void Must(const wavefront::Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}
void Must(VkResult result, const char* call) {
  if (result != VK_SUCCESS) throw std::runtime_error(VulkanError(call, result).message);
}

Format FormatOf(const std::string& name) {
  if (name == "r32ui") return Format::R32Uint;
  if (name == "rg32ui") return Format::Rg32Uint;
  if (name == "rgba32ui") return Format::Rgba32Uint;
  if (name == "rgba32f") return Format::Rgba32Float;
  if (name == "rgba8") return Format::Rgba8Unorm;
  if (name == "rgba16f") return Format::Rgba16Float;
  throw std::runtime_error("unknown format '" + name + "'");
}

DescriptorKind KindOf(const std::string& name) {
  if (name == "storage") return DescriptorKind::StorageBuffer;
  if (name == "image") return DescriptorKind::SampledImage;
  const Format format = FormatOf(name);
  const bool integer = format == Format::R32Uint || format == Format::Rg32Uint || format == Format::Rgba32Uint;
  return integer ? DescriptorKind::TexelBufferUint : DescriptorKind::TexelBufferFloat;
}

std::span<const std::byte> Bytes(const nb::bytes& bytes) {
  return {reinterpret_cast<const std::byte*>(bytes.c_str()), bytes.size()};
}

double Milliseconds(std::chrono::steady_clock::time_point from) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
}

// A sampled 2-D image or array of them with all its levels, and a linear, repeating sampler.
class MippedImage {
 public:
  MippedImage(std::shared_ptr<Context> context, uint32_t width, uint32_t height, uint32_t layers, Format format,
              uint32_t levels, bool array)
      : context_(std::move(context)), width_(width), height_(height), layers_(layers), levels_(levels), format_(format) {
    const VolkDeviceTable& vk = context_->vk;
    auto info = Struct<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = ToVulkan(format);
    info.extent = {width, height, 1};
    info.mipLevels = levels;
    info.arrayLayers = layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    Must(vk.vkCreateImage(context_->device, &info, nullptr, &image_), "vkCreateImage");
    VkMemoryRequirements needs{};
    vk.vkGetImageMemoryRequirements(context_->device, image_, &needs);
    allocation_ = Must(context_->Allocate(needs, false, MemoryKind::Textures, "benchmark image"));
    Must(vk.vkBindImageMemory(context_->device, image_, allocation_.memory, 0), "vkBindImageMemory");
    auto view = Struct<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    view.image = image_;
    view.viewType = array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = info.format;
    view.subresourceRange = Range();
    Must(vk.vkCreateImageView(context_->device, &view, nullptr, &view_), "vkCreateImageView");
    auto sampler = Struct<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
    sampler.magFilter = sampler.minFilter = VK_FILTER_LINEAR;
    sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
    sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_REPEAT;
    sampler.maxLod = VK_LOD_CLAMP_NONE;
    Must(vk.vkCreateSampler(context_->device, &sampler, nullptr, &sampler_), "vkCreateSampler");
    ToGeneralLayout();
  }
  ~MippedImage() {
    const VolkDeviceTable& vk = context_->vk;
    context_->transfer().Drain();
    vk.vkDestroySampler(context_->device, sampler_, nullptr);
    vk.vkDestroyImageView(context_->device, view_, nullptr);
    vk.vkDestroyImage(context_->device, image_, nullptr);
    context_->Free(allocation_, MemoryKind::Textures);
  }
  MippedImage(const MippedImage&) = delete;
  MippedImage& operator=(const MippedImage&) = delete;

  // All layers of a level, rows after each other, in pieces that a staging chunk takes.
  void Upload(uint32_t level, std::span<const std::byte> data) {
    const uint32_t width = std::max(1u, width_ >> level), height = std::max(1u, height_ >> level);
    const uint64_t rowBytes = uint64_t{width} * FormatBytes(format_);
    if (data.size() != rowBytes * height * layers_) throw std::runtime_error("a level has another number of bytes");
    const uint32_t rowsAtOnce = static_cast<uint32_t>(std::min<uint64_t>(height, Transfer::kChunkBytes / rowBytes));
    for (uint32_t layer = 0; layer < layers_; ++layer) {
      for (uint32_t y = 0; y < height; y += rowsAtOnce) {
        const uint32_t rows = std::min(rowsAtOnce, height - y);
        const Transfer::Piece piece = data.subspan((uint64_t{layer} * height + y) * rowBytes, rows * rowBytes);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, layer, 1};
        copy.imageOffset = {0, static_cast<int32_t>(y), 0};
        copy.imageExtent = {width, rows, 1};
        Must(context_->transfer().Run(std::span(&piece, 1), [&](VkCommandBuffer commands, VkBuffer staging) {
          context_->vk.vkCmdCopyBufferToImage(commands, staging, image_, VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
        }, false));
      }
    }
  }

  VkDescriptorImageInfo Descriptor() const { return {sampler_, view_, VK_IMAGE_LAYOUT_GENERAL}; }

 private:
  VkImageSubresourceRange Range() const { return {VK_IMAGE_ASPECT_COLOR_BIT, 0, levels_, 0, layers_}; }
  void ToGeneralLayout() {
    Must(context_->transfer().Run({}, [&](VkCommandBuffer commands, VkBuffer) {
      auto barrier = Struct<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
      barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
      barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_READ_BIT;
      barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
      barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
      barrier.image = image_;
      barrier.subresourceRange = Range();
      auto dependency = Struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
      dependency.imageMemoryBarrierCount = 1;
      dependency.pImageMemoryBarriers = &barrier;
      context_->vk.vkCmdPipelineBarrier2(commands, &dependency);
    }, false));
  }

  std::shared_ptr<Context> context_;
  uint32_t width_, height_, layers_, levels_;
  Format format_;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkSampler sampler_ = VK_NULL_HANDLE;
  Allocation allocation_;
};

struct Program {
  std::unique_ptr<PipelineLayout> layout;
  std::unique_ptr<ComputePipeline> pipeline;
};

// Everything is named by the index that its maker returned.
class Bench {
 public:
  explicit Bench(uint64_t memoryBudget) {
    DeviceOptions options;
    options.memoryBudgetBytes = memoryBudget;
    device_ = Must(Device::Create(options));
    stream_ = Must(CommandStream::Create(*device_, {1, 2, "bench"}));
  }

  std::size_t AddBuffer(const nb::bytes& bytes) {
    auto buffer = Must(Buffer::Create(*device_, {bytes.size(), MemoryKind::Other, MemoryLocation::DeviceLocal, "benchmark buffer"}));
    Must(buffer->Upload(0, Bytes(bytes)));
    buffers_.push_back(std::move(buffer));
    return buffers_.size() - 1;
  }

  std::size_t AddImage(uint32_t width, uint32_t height, uint32_t layers, const std::string& format, const std::vector<nb::bytes>& levels,
                       bool array) {
    auto image = std::make_unique<MippedImage>(device_->context(), width, height, layers, FormatOf(format),
                                               static_cast<uint32_t>(levels.size()), array);
    for (uint32_t level = 0; level < levels.size(); ++level) image->Upload(level, Bytes(levels[level]));
    images_.push_back(std::move(image));
    return images_.size() - 1;
  }

  // bindings: (number, kind, array size). Also the milliseconds of creation.
  std::pair<std::size_t, double> AddProgram(const nb::bytes& spirv,
                                            const std::vector<std::tuple<uint32_t, std::string, uint32_t>>& bindings) {
    std::vector<Binding> all;
    for (const auto& [number, kind, count] : bindings) all.push_back({number, KindOf(kind), count});
    std::vector<uint32_t> words(spirv.size() / 4);
    std::memcpy(words.data(), spirv.c_str(), words.size() * 4);
    Program program;
    program.layout = Must(PipelineLayout::Create(*device_, std::move(all), "benchmark bindings"));
    const auto start = std::chrono::steady_clock::now();
    program.pipeline = Must(ComputePipeline::Create(*device_, *program.layout, {words, "main", {}, "benchmark kernel"}));
    const double milliseconds = Milliseconds(start);
    programs_.push_back(std::move(program));
    return {programs_.size() - 1, milliseconds};
  }

  // entries: (binding, element, kind, buffer or image)
  std::size_t AddSet(std::size_t program, const std::vector<std::tuple<uint32_t, uint32_t, std::string, std::size_t>>& entries) {
    auto set = Must(DescriptorSet::Create(*device_, *programs_.at(program).layout));
    for (const auto& [number, element, kind, index] : entries) {
      if (kind == "storage") {
        Must(set->Write(number, *buffers_.at(index)));
      } else if (kind == "image") {
        const VkDescriptorImageInfo info = images_.at(index)->Descriptor();
        auto write = Struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
        write.dstSet = set->handle();
        write.dstBinding = number;
        write.dstArrayElement = element;
        write.descriptorCount = 1;
        write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        write.pImageInfo = &info;
        device_->context()->vk.vkUpdateDescriptorSets(device_->context()->device, 1, &write, 0, nullptr);
      } else {
        Must(set->WriteTexels(number, *buffers_.at(index), FormatOf(kind)));
      }
    }
    sets_.push_back(std::move(set));
    return sets_.size() - 1;
  }

  // dispatches: (program, set, groups, push constants), in one submission without barriers: device nanoseconds, and the
  // milliseconds from submission to completion as the host sees them (a first dispatch compiles on lavapipe).
  std::pair<double, double> Run(const std::vector<std::tuple<std::size_t, std::size_t, uint32_t, nb::bytes>>& dispatches) {
    Must(stream_->Begin());
    stream_->Timestamp();
    for (const auto& [program, set, groups, push] : dispatches) {
      stream_->BindSet(*sets_.at(set));
      stream_->BindPipeline(*programs_.at(program).pipeline);
      stream_->PushConstants(Bytes(push));
      stream_->Dispatch(groups);
    }
    stream_->Timestamp();
    const auto start = std::chrono::steady_clock::now();
    const uint64_t value = Must(stream_->Submit());
    {
      nb::gil_scoped_release release;
      Must(stream_->Wait(value));
    }
    const double milliseconds = Milliseconds(start);
    double times[2] = {0, 0};
    Must(stream_->ReadTimestamps(value, times));
    return {times[1] - times[0], milliseconds};
  }

  nb::bytes Read(std::size_t buffer) {
    std::vector<std::byte> data(buffers_.at(buffer)->size());
    Must(buffers_.at(buffer)->Download(0, data));
    return nb::bytes(data.data(), data.size());
  }

  nb::dict Limits() const {
    const DeviceInfo& info = device_->info();
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(device_->context()->physical, &properties);
    nb::dict out;
    out["device"] = info.name;
    out["on a CPU"] = info.type == DeviceType::Cpu;
    out["driver"] = info.driverName + " " + info.driverVersion;
    out["sampled images a stage (texel buffers too)"] = info.limits.maxSampledImagesPerStage;
    out["samplers a stage"] = properties.limits.maxPerStageDescriptorSamplers;
    out["resources a stage"] = info.limits.maxResourcesPerStage;
    out["image array layers"] = info.limits.maxImageArrayLayers;
    out["texel buffer elements"] = info.limits.maxTexelBufferElements;
    return out;
  }

 private:
  std::unique_ptr<Device> device_;
  std::vector<std::unique_ptr<Buffer>> buffers_;
  std::vector<std::unique_ptr<MippedImage>> images_;
  std::vector<Program> programs_;
  std::vector<std::unique_ptr<DescriptorSet>> sets_;
  std::unique_ptr<CommandStream> stream_;  // last: it waits for its work before what the work uses goes
};

}  // namespace

void bindBench(nb::module_& module) {
  nb::class_<Bench>(module, "Bench")
      .def(nb::init<uint64_t>(), nb::arg("memory_budget"))
      .def("buffer", &Bench::AddBuffer)
      .def("image", &Bench::AddImage)
      .def("program", &Bench::AddProgram)
      .def("set", &Bench::AddSet)
      .def("run", &Bench::Run)
      .def("read", &Bench::Read)
      .def("limits", &Bench::Limits);
}
