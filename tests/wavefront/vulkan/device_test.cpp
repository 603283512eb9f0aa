// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which device is taken, what it says about itself, and that it goes away without a trace.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <thread>

#include "fixture.h"
#include "wavefront/vulkan/image.h"

namespace wavefront::vulkan {
namespace {

struct ScopedEnvironment {
  ScopedEnvironment(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old, had_ = true;
    setenv(name, value, 1);
  }
  ~ScopedEnvironment() { had_ ? setenv(name_, old_.c_str(), 1) : unsetenv(name_); }
  const char* name_;
  std::string old_;
  bool had_ = false;
};

TEST(Device, ListsAndDescribesDevices) {
  const auto devices = Must(ListDevices());
  ASSERT_FALSE(devices.empty());
  const auto usable = std::find_if(devices.begin(), devices.end(), [](const auto& d) { return d.missing.empty(); });
  ASSERT_NE(usable, devices.end());
  EXPECT_FALSE(usable->name.empty());
  EXPECT_FALSE(usable->driverName.empty());
  EXPECT_EQ(usable->apiVersion.substr(0, 2), "1.");
  EXPECT_GE(usable->limits.subgroupSize, 1u);
  EXPECT_GE(usable->limits.maxPushConstants, 128u);
  EXPECT_FALSE(usable->heaps.empty());
  for (const FeatureInfo& feature : usable->features) EXPECT_TRUE(!feature.required || feature.present) << feature.name;
}

TEST(Device, ASelectorIsAnIndexOrPartOfAName) {
  const auto devices = Must(ListDevices());
  for (const DeviceInfo& info : devices) {
    if (!info.missing.empty()) continue;
    DeviceOptions options;
    options.selector = std::to_string(info.index);
    EXPECT_EQ(Must(Device::Create(options))->info().index, info.index);
    options.selector = info.name.substr(0, 5);
    std::transform(options.selector.begin(), options.selector.end(), options.selector.begin(), ::toupper);
    EXPECT_EQ(Must(Device::Create(options))->info().name.substr(0, 5), info.name.substr(0, 5));
  }
}

TEST(Device, ABadSelectorIsAnErrorThatNamesTheDevices) {
  const auto devices = Must(ListDevices());
  for (const char* selector : {"no such device", "97", "99999999999999999999"}) {
    DeviceOptions options;
    options.selector = selector;
    const auto device = Device::Create(options);
    ASSERT_FALSE(device.ok()) << selector;
    EXPECT_NE(device.error().message.find(selector), std::string::npos);
    EXPECT_NE(device.error().message.find(devices[0].name), std::string::npos);
  }
}

TEST(Device, TheEnvironmentChoosesWhereNoSelectorDoes) {
  const auto devices = Must(ListDevices());
  const auto usable = std::find_if(devices.begin(), devices.end(), [](const auto& d) { return d.missing.empty(); });
  ScopedEnvironment environment("HDWAVEFRONT_DEVICE", "no such device");
  const auto device = Device::Create();
  ASSERT_FALSE(device.ok());
  EXPECT_NE(device.error().message.find("no such device"), std::string::npos);
  DeviceOptions options;
  options.selector = std::to_string(usable->index);
  EXPECT_TRUE(Device::Create(options).ok());
}

TEST(Device, TheEnvironmentTurnsValidationOn) {
  {
    ScopedEnvironment environment("HDWAVEFRONT_VALIDATION", "1");
    EXPECT_TRUE(Must(Device::Create())->validation());
    DeviceOptions options;
    options.validation = options.neverValidate = true;
    EXPECT_FALSE(Must(Device::Create(options))->validation());
  }
  ScopedEnvironment environment("HDWAVEFRONT_VALIDATION", "0");
  EXPECT_FALSE(Must(Device::Create())->validation());
}

// Without this, a silent validation layer would look like a clean one.
TEST(DeviceDeathTest, ValidationIsHeard) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        DeviceOptions options;
        options.synchronizationValidation = true;
        auto device = Must(Device::Create(options));
        auto buffer = Must(Buffer::Create(*device, {64, MemoryKind::Other, MemoryLocation::DeviceLocal, "victim"}));
        auto stream = Must(CommandStream::Create(*device));
        Must(stream->Begin());
        stream->Fill(*buffer, 0, 64, 1);
        stream->Fill(*buffer, 0, 64, 2);  // no barrier between: synchronization validation must say so
        _exit(ValidationMessageCount() > 0 ? 42 : 0);  // at once: the recording is left unfinished
      },
      testing::ExitedWithCode(42), "SYNC-HAZARD-WRITE");
}

TEST(Device, TwentyRecreationsLeaveNothing) {
  const uint64_t messages = ValidationMessageCount();
  const std::vector<uint32_t> spirv = Glsl(R"(
    layout(local_size_x = 1) in;
    layout(binding = 0) buffer Out { uint value; };
    layout(binding = 1) uniform sampler2D image;
    void main() { value = uint(texture(image, vec2(0.5)).x); })");
  for (uint32_t i = 0; i < 20; ++i) {
    DeviceOptions options;
    options.synchronizationValidation = true;
    options.forceStaging = i % 2 == 1;
    auto device = Must(Device::Create(options));
    {
      auto layout = Must(
          PipelineLayout::Create(*device, {{0, DescriptorKind::StorageBuffer}, {1, DescriptorKind::SampledImage}}));
      auto pipeline = Must(ComputePipeline::Create(*device, *layout, {spirv, "main", {}, "kernel"}));
      auto buffer = Must(Buffer::Create(*device, {4, MemoryKind::Film, MemoryLocation::DeviceLocal, "out"}));
      auto image = Must(Image::Create(*device, {}));
      auto sampler = Must(Sampler::Create(*device, Filter::Linear));
      const float texel[4] = {static_cast<float>(i), 0, 0, 0};
      Must(image->Upload(std::as_bytes(std::span(texel))));
      auto set = Must(DescriptorSet::Create(*device, *layout));
      Must(set->Write(0, *buffer));
      Must(set->WriteImage(1, *image, *sampler));
      auto stream = Must(CommandStream::Create(*device));
      Must(stream->Begin());
      stream->BindSet(*set);
      stream->BindPipeline(*pipeline);
      stream->Dispatch(1);
      Must(stream->Submit());
      EXPECT_EQ(Read<uint32_t>(*buffer, 1)[0], i);
      EXPECT_GT(device->liveObjects(), 0);
    }
    EXPECT_EQ(device->liveObjects(), 0);
    const MemoryByKind kinds = device->memoryByKind();
    for (std::size_t kind = 0; kind < kMemoryKindCount; ++kind) {
      if (static_cast<MemoryKind>(kind) == MemoryKind::Staging) continue;  // the device's own ring
      EXPECT_EQ(kinds[kind].current, 0u) << kind;
    }
  }
  EXPECT_EQ(LiveDevices(), 0);
  EXPECT_EQ(ValidationMessageCount(), messages);
}

TEST(Device, ObjectsMayOutliveTheirDevice) {
  const uint64_t messages = ValidationMessageCount();
  DeviceOptions options;
  options.synchronizationValidation = true;
  auto device = Must(Device::Create(options));
  auto buffer = Must(Buffer::Create(*device, {64, MemoryKind::Other, MemoryLocation::DeviceLocal, "late"}));
  auto stream = Must(CommandStream::Create(*device));
  Must(stream->Begin());
  stream->Fill(*buffer, 0, 0, 7);
  Must(stream->Submit());
  device.reset();
  EXPECT_EQ(LiveDevices(), 1);
  EXPECT_EQ(Read<uint32_t>(*buffer, 16), std::vector<uint32_t>(16, 7));
  stream.reset();
  buffer.reset();
  EXPECT_EQ(LiveDevices(), 0);
  EXPECT_EQ(ValidationMessageCount(), messages);
}

TEST(Device, ThePipelineCacheSurvivesARoundTripAndForeignData) {
  const uint64_t messages = ValidationMessageCount();
  std::vector<std::byte> data;
  DeviceOptions options;
  options.synchronizationValidation = true;
  data = Must(Must(Device::Create(options))->PipelineCacheData());
  options.pipelineCache = data;
  EXPECT_TRUE(Device::Create(options).ok());
  const std::vector<std::byte> garbage(100, std::byte{0x5a});
  options.pipelineCache = garbage;
  EXPECT_TRUE(Device::Create(options).ok());
  EXPECT_EQ(ValidationMessageCount(), messages);
}

TEST(Device, DevicesAreMadeInParallel) {
  std::vector<std::thread> threads;
  std::atomic<int> good{0};
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      auto device = Device::Create();
      if (device && Buffer::Create(**device, {1024, MemoryKind::Other, MemoryLocation::DeviceLocal, "b"}).ok()) ++good;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 4);
  EXPECT_EQ(LiveDevices(), 0);
}

}  // namespace
}  // namespace wavefront::vulkan
