// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the tests of the device layer share: a device with validation, kernels from GLSL text, and the promise that
// no test draws a validation message or leaves an object behind.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/kernel_runner/glsl.h"
#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/device.h"
#include "wavefront/vulkan/image.h"
#include "wavefront/vulkan/pipeline.h"

#ifdef VULKAN_CORE_H_
#error "a public header of wavefront/vulkan includes vulkan.h"
#endif

namespace wavefront::vulkan {

template <typename T>
T Must(Result<T> result) {
  if (!result) {
    ADD_FAILURE() << result.error().message;
    std::abort();  // nothing after it makes sense
  }
  return std::move(result).value();
}
inline void Must(const Status& status) { ASSERT_TRUE(status.ok()) << status.error().message; }

inline std::vector<uint32_t> Glsl(const std::string& body) {
  return kernel_runner::CompileGlsl("#version 460\n" + body, "comp", {});
}

template <typename T>
std::vector<T> Read(Buffer& buffer, std::size_t count, uint64_t offset = 0) {
  std::vector<T> values(count);
  Must(buffer.Download(offset, std::as_writable_bytes(std::span(values))));
  return values;
}

// Runs with direct writes (false) and as a discrete GPU would be driven (true).
class VulkanTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    messages_ = ValidationMessageCount();
    DeviceOptions options;
    options.synchronizationValidation = true;
    options.forceStaging = Staging();
    device_ = Must(Device::Create(options));
  }
  void TearDown() override {
    EXPECT_EQ(device_->liveObjects(), 0);
    device_.reset();
    EXPECT_EQ(LiveDevices(), 0);
    EXPECT_EQ(ValidationMessageCount(), messages_);
  }
  virtual bool Staging() const { return false; }

  std::unique_ptr<Buffer> MakeBuffer(uint64_t size, std::string name = "buffer") {
    return Must(Buffer::Create(*device_, {size, MemoryKind::Other, MemoryLocation::DeviceLocal, std::move(name)}));
  }
  template <typename T>
  std::unique_ptr<Buffer> MakeBuffer(const std::vector<T>& values) {
    auto buffer = MakeBuffer(values.size() * sizeof(T));
    Must(buffer->Upload(0, std::span<const T>(values)));
    return buffer;
  }
  std::unique_ptr<ComputePipeline> MakePipeline(const PipelineLayout& layout, const std::string& body,
                                                std::vector<std::pair<uint32_t, uint32_t>> specialization = {}) {
    const std::vector<uint32_t> spirv = Glsl(body);
    return Must(ComputePipeline::Create(*device_, layout, {spirv, "main", std::move(specialization), "test"}));
  }
  // One dispatch, waited for.
  void RunOnce(const ComputePipeline& pipeline, const DescriptorSet& set, uint32_t groups) {
    auto stream = Must(CommandStream::Create(*device_));
    Must(stream->Begin());
    stream->BindSet(set);
    stream->BindPipeline(pipeline);
    stream->Dispatch(groups);
    EXPECT_TRUE(Must(stream->Wait(Must(stream->Submit()))));
  }

  std::unique_ptr<Device> device_;
  uint64_t messages_ = 0;
};

class StagingTest : public VulkanTest {
 protected:
  bool Staging() const override { return GetParam(); }
};

}  // namespace wavefront::vulkan
