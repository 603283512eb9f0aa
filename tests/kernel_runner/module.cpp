// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Python module `_kernel_runner`: runs one compute shader on given buffers. The friendly half, with numpy, is
// kernel_runner/__init__.py.
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstring>
#include <list>
#include <stdexcept>

#include "tests/kernel_runner/glsl.h"
#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/device.h"
#include "wavefront/vulkan/pipeline.h"

namespace nb = nanobind;
using namespace wavefront::vulkan;

namespace {

constexpr std::size_t kCachedPipelines = 64;

template <typename T>
T Unwrap(wavefront::Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}
void Unwrap(const wavefront::Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}

// (binding number, "storage" or a texel format, bytes)
using Input = std::tuple<uint32_t, std::string, nb::bytes>;

const std::map<std::string, Format>& TexelFormats() {
  static const std::map<std::string, Format> formats = {
      {"r32ui", Format::R32Uint},       {"r32f", Format::R32Float},       {"rg32ui", Format::Rg32Uint},     {"rgba32ui", Format::Rgba32Uint},
      {"rgba32f", Format::Rgba32Float}, {"rgba8", Format::Rgba8Unorm}, {"rgba16f", Format::Rgba16Float}};
  return formats;
}

Format TexelFormatOf(const std::string& name) {
  const auto found = TexelFormats().find(name);
  if (found == TexelFormats().end()) {
    throw std::runtime_error("unknown texel format '" + name + "' (r32ui, r32f, rg32ui, rgba32ui, rgba32f, rgba8, rgba16f)");
  }
  return found->second;
}

DescriptorKind KindOf(const std::string& name) {
  if (name == "storage") return DescriptorKind::StorageBuffer;
  const Format format = TexelFormatOf(name);
  const bool integer = format == Format::R32Uint || format == Format::Rg32Uint || format == Format::Rgba32Uint;
  return integer ? DescriptorKind::TexelBufferUint : DescriptorKind::TexelBufferFloat;
}

std::span<const std::byte> Bytes(const nb::bytes& bytes) {
  return {reinterpret_cast<const std::byte*>(bytes.c_str()), bytes.size()};
}

// Compiling is most of the time of a test, so a kernel that is run again is not compiled again.
struct CachedPipeline {
  std::string key;
  std::unique_ptr<PipelineLayout> layout;
  std::unique_ptr<ComputePipeline> pipeline;
};

class Runner {
 public:
  Runner() : device_(Unwrap(Device::Create())), stream_(Unwrap(CommandStream::Create(*device_, {1, 2, "kernel_runner"}))) {}

  Device& device() { return *device_; }

  std::pair<std::vector<nb::bytes>, double> Run(const std::vector<uint32_t>& spirv, const std::vector<Input>& inputs,
                                                std::tuple<uint32_t, uint32_t, uint32_t> groups, const nb::bytes& push,
                                                const std::map<uint32_t, uint32_t>& spec, uint32_t repeat) {
    if (push.size() > kPushConstantBytes || push.size() % 4 != 0) {
      throw std::runtime_error("push constants take at most 128 bytes, a multiple of 4");
    }
    CachedPipeline& cached = Find(spirv, inputs, spec);
    auto set = Unwrap(DescriptorSet::Create(*device_, *cached.layout));
    std::vector<std::unique_ptr<Buffer>> buffers;
    for (const auto& [number, kind, bytes] : inputs) {
      auto buffer = Unwrap(Buffer::Create(
          *device_, {bytes.size(), MemoryKind::Other, MemoryLocation::DeviceLocal, "binding " + std::to_string(number)}));
      Unwrap(buffer->Upload(0, Bytes(bytes)));
      if (kind == "storage") {
        Unwrap(set->Write(number, *buffer));
      } else {
        Unwrap(set->WriteTexels(number, *buffer, TexelFormatOf(kind)));
      }
      buffers.push_back(std::move(buffer));
    }
    const double nanoseconds = Dispatch(cached, *set, groups, push, repeat);
    std::vector<nb::bytes> outputs;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (std::get<1>(inputs[i]) != "storage") continue;
      std::vector<std::byte> data(std::get<2>(inputs[i]).size());
      Unwrap(buffers[i]->Download(0, data));
      outputs.emplace_back(data.data(), data.size());
    }
    return {std::move(outputs), nanoseconds};
  }

 private:
  CachedPipeline& Find(const std::vector<uint32_t>& spirv, const std::vector<Input>& inputs,
                       const std::map<uint32_t, uint32_t>& spec) {
    std::string key(reinterpret_cast<const char*>(spirv.data()), spirv.size() * sizeof(uint32_t));
    std::vector<Binding> bindings;
    for (const auto& [number, kind, bytes] : inputs) {
      key += "|" + std::to_string(number) + ":" + std::to_string(static_cast<int>(KindOf(kind)));
      bindings.push_back({number, KindOf(kind), 1});
    }
    PipelineDesc desc;
    for (const auto& [id, value] : spec) {
      key += ";" + std::to_string(id) + "=" + std::to_string(value);
      desc.specialization.emplace_back(id, value);
    }
    for (auto it = cache_.begin(); it != cache_.end(); ++it) {
      if (it->key != key) continue;
      cache_.splice(cache_.begin(), cache_, it);
      return cache_.front();
    }
    desc.spirv = spirv;
    desc.name = "test kernel";
    auto layout = Unwrap(PipelineLayout::Create(*device_, std::move(bindings), "test bindings"));
    auto pipeline = Unwrap(ComputePipeline::Create(*device_, *layout, desc));
    cache_.push_front({std::move(key), std::move(layout), std::move(pipeline)});
    if (cache_.size() > kCachedPipelines) cache_.pop_back();
    return cache_.front();
  }

  // Device time of the last dispatch.
  double Dispatch(const CachedPipeline& cached, const DescriptorSet& set, std::tuple<uint32_t, uint32_t, uint32_t> groups,
                  const nb::bytes& push, uint32_t repeat) {
    uint64_t value = 0;
    for (uint32_t i = 0; i < repeat; ++i) {
      Unwrap(stream_->Begin());
      stream_->BindSet(set);
      stream_->BindPipeline(*cached.pipeline);
      stream_->PushConstants(Bytes(push));
      stream_->Timestamp();
      stream_->Dispatch(std::get<0>(groups), std::get<1>(groups), std::get<2>(groups));
      stream_->Timestamp();
      value = Unwrap(stream_->Submit());
      nb::gil_scoped_release release;
      Unwrap(stream_->Wait(value));
    }
    double times[2] = {0, 0};
    Unwrap(stream_->ReadTimestamps(value, times));
    return times[1] - times[0];
  }

  std::unique_ptr<Device> device_;
  std::unique_ptr<CommandStream> stream_;
  std::list<CachedPipeline> cache_;
};

std::unique_ptr<Runner>& SharedRunner() {
  static std::unique_ptr<Runner> runner;
  return runner;
}

Runner& TheRunner() {
  if (!SharedRunner()) SharedRunner() = std::make_unique<Runner>();
  return *SharedRunner();
}

std::vector<uint32_t> Words(const nb::bytes& spirv) {
  std::vector<uint32_t> words(spirv.size() / 4);
  std::memcpy(words.data(), spirv.c_str(), words.size() * 4);
  return words;
}

}  // namespace

void bindBench(nb::module_& module);  // bench_bindings.cpp
void bindBvh(nb::module_& module);    // bvh_bindings.cpp
void bindMaterial(nb::module_& module);  // material_bindings.cpp
void bindScene(nb::module_& module);     // scene_bindings.cpp

NB_MODULE(_kernel_runner, m) {
  bindBench(m);
  bindBvh(m);
  bindMaterial(m);
  bindScene(m);
  m.def("compile", [](const std::string& source, const std::string& stage, const std::vector<std::string>& folders) {
    const std::vector<uint32_t> spirv = kernel_runner::CompileGlsl(source, stage, folders);
    return nb::bytes(spirv.data(), spirv.size() * sizeof(uint32_t));
  });
  m.def("binding_names", [](const nb::bytes& spirv) { return kernel_runner::BindingNames(Words(spirv)); });
  m.def("run", [](const nb::bytes& spirv, const std::vector<Input>& inputs, std::tuple<uint32_t, uint32_t, uint32_t> groups,
                  const nb::bytes& push, const std::map<uint32_t, uint32_t>& spec, uint32_t repeat) {
    return TheRunner().Run(Words(spirv), inputs, groups, push, spec, repeat);
  });
  m.def("validation_messages", [] { return ValidationMessages(); });
  m.def("device_name", [] { return TheRunner().device().info().name; });
  m.def("subgroup_size", [] { return TheRunner().device().info().limits.subgroupSize; });
  m.def("release", [] { SharedRunner().reset(); });
}
