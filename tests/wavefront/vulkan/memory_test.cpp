// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Buffers, images and the memory accounts.
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>

#include "fixture.h"
#include "wavefront/vulkan/image.h"

namespace wavefront::vulkan {
namespace {

INSTANTIATE_TEST_SUITE_P(Memory, StagingTest, testing::Bool(),
                         [](const auto& info) { return info.param ? "Staged" : "Direct"; });

TEST_P(StagingTest, ABufferRoundTrips) {
  std::vector<uint32_t> values(5'000'000 + 3);  // 20 MB: several staging chunks
  std::iota(values.begin(), values.end(), 17u);
  auto buffer = MakeBuffer(values);
  EXPECT_EQ(buffer->Map().empty(), GetParam());
  EXPECT_EQ(Read<uint32_t>(*buffer, values.size()), values);
  const std::vector<uint32_t> patch = {1, 2, 3};
  Must(buffer->Upload(1'000'000 * 4, std::span<const uint32_t>(patch)));
  EXPECT_EQ(Read<uint32_t>(*buffer, 5, 999'999 * 4), (std::vector<uint32_t>{999'999 + 17, 1, 2, 3, 1'000'003 + 17}));
}

TEST_P(StagingTest, ABufferStartsAsZeros) {
  for (int i = 0; i < 3; ++i) {  // later ones get memory that was used before
    auto buffer = MakeBuffer(1 << 16);
    EXPECT_EQ(Read<uint32_t>(*buffer, 1 << 14), std::vector<uint32_t>(1 << 14, 0));
    Must(buffer->Upload(0, std::span<const uint32_t>(std::vector<uint32_t>(1 << 14, 0xdeadbeef))));
    EXPECT_EQ(Read<uint32_t>(*buffer, 1)[0], 0xdeadbeefu);
  }
}

// What the system was asked for the memory at `address` (VmFlags of /proc/self/smaps); empty where it does not tell.
std::string AdviceFor(const void* address) {
  std::ifstream maps("/proc/self/smaps");
  bool isIn = false;
  for (std::string line; std::getline(maps, line);) {
    char* end = nullptr;
    const uint64_t first = std::strtoull(line.c_str(), &end, 16);
    if (*end == '-') {
      const uint64_t last = std::strtoull(end + 1, nullptr, 16), at = reinterpret_cast<uintptr_t>(address);
      isIn = first <= at && at < last;
    } else if (isIn && line.starts_with("VmFlags:")) {
      return line + ' ';
    }
  }
  return {};
}

TEST_P(StagingTest, AsksForHugePagesWhereTheDeviceIsSoftware) {
  if (!std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled")) GTEST_SKIP() << "the system has no huge pages";
  auto buffer = MakeBuffer(uint64_t{48} << 20);
  const auto memory = buffer->Map();
  ASSERT_EQ(memory.empty(), GetParam());
  if (GetParam()) return;  // staged: not this process's memory
  if (device_->info().type != DeviceType::Cpu) GTEST_SKIP() << "a device with memory of its own";
  const std::string advice = AdviceFor(memory.data() + memory.size() / 2);
  if (advice.empty()) GTEST_SKIP() << "the system does not tell";
  EXPECT_NE(advice.find(" hg "), std::string::npos) << advice;
}

TEST_P(StagingTest, DestructionWaitsForUploads) {
  const std::vector<uint32_t> values(4'000'000, 3);
  for (int i = 0; i < 4; ++i) MakeBuffer(values);
  const ImageDesc desc{ImageShape::Plane, Format::R32Float, 2000, 2000, 1, 1, MemoryKind::Textures, "short-lived"};
  for (int i = 0; i < 4; ++i) {
    auto image = Must(Image::Create(*device_, desc));
    Must(image->Upload(std::as_bytes(std::span(values))));
  }
}

TEST_P(StagingTest, AccessPastTheEndIsAnError) {
  auto buffer = MakeBuffer(64, "small");
  std::byte bytes[80] = {};
  for (const uint64_t offset : {uint64_t{0}, uint64_t{1}, uint64_t{65}, ~uint64_t{0}}) {
    const Status upload = buffer->Upload(offset, std::span<const std::byte>(bytes, offset == 0 ? 80 : 64));
    ASSERT_FALSE(upload.ok());
    EXPECT_NE(upload.error().message.find("'small'"), std::string::npos);
    EXPECT_FALSE(buffer->Download(offset, std::span(bytes, offset == 0 ? 80 : 64)).ok());
  }
}

TEST_P(StagingTest, GrowingKeepsTheContents) {
  const std::vector<uint32_t> values = {5, 6, 7, 8};
  auto buffer = MakeBuffer(values);
  const uint64_t generation = buffer->generation();
  Must(buffer->TexelView(Format::R32Uint));
  Must(buffer->Reserve(16));
  EXPECT_EQ(buffer->generation(), generation);
  Must(buffer->Reserve(1 << 20));
  EXPECT_GT(buffer->generation(), generation);
  EXPECT_GE(buffer->size(), 1u << 20);
  EXPECT_EQ(Read<uint32_t>(*buffer, 4), values);
  EXPECT_EQ(Read<uint32_t>(*buffer, 1000, 16), std::vector<uint32_t>(1000, 0));
  EXPECT_FALSE(buffer->Reserve(uint64_t{1} << 60).ok());
  EXPECT_EQ(Read<uint32_t>(*buffer, 4), values);
}

TEST_P(StagingTest, HostVisibleBuffersAreAlwaysMapped) {
  auto buffer = Must(Buffer::Create(*device_, {256, MemoryKind::Queues, MemoryLocation::HostVisible, "status"}));
  ASSERT_EQ(buffer->Map().size(), 256u);
  std::memset(buffer->Map().data(), 0, 256);
  auto stream = Must(CommandStream::Create(*device_));
  Must(stream->Begin());
  stream->Fill(*buffer, 16, 16, 0x01020304);
  EXPECT_TRUE(Must(stream->Wait(Must(stream->Submit()))));
  uint32_t value = 0;
  std::memcpy(&value, buffer->Map().data() + 28, 4);
  EXPECT_EQ(value, 0x01020304u);
  std::memcpy(&value, buffer->Map().data() + 32, 4);
  EXPECT_EQ(value, 0u);
}

TEST_F(VulkanTest, TexelViewsAreCheckedAndKept) {
  auto buffer = MakeBuffer(4096);
  const VkBufferView view = Must(buffer->TexelView(Format::Rgba32Float));
  EXPECT_EQ(Must(buffer->TexelView(Format::Rgba32Float)), view);
  EXPECT_NE(Must(buffer->TexelView(Format::Rgba32Uint)), view);
  EXPECT_FALSE(buffer->TexelView(Format::R32Uint, 1).ok());
  EXPECT_FALSE(buffer->TexelView(Format::R32Uint, 8192).ok());
  EXPECT_FALSE(buffer->TexelView(Format::R32Uint, 0, 8192).ok());
  EXPECT_FALSE(buffer->TexelView(Format::Rgba32Uint, 0, 24).ok());
}

TEST(Memory, TheBudgetRefusesAndSaysWhoHoldsWhat) {
  const uint64_t messages = ValidationMessageCount();
  DeviceOptions options;
  options.synchronizationValidation = true;
  options.memoryBudgetBytes = 10 << 20;
  auto device = Must(Device::Create(options));
  EXPECT_EQ(device->memoryBudget(), 10u << 20);
  auto path = Must(Buffer::Create(*device, {6 << 20, MemoryKind::PathState, MemoryLocation::DeviceLocal, "path"}));
  const auto refused = Buffer::Create(*device, {5 << 20, MemoryKind::Film, MemoryLocation::DeviceLocal, "film sum"});
  ASSERT_FALSE(refused.ok());
  for (const char* part : {"film sum", "5.0 MiB", "10.0 MiB", "path state 6.0 MiB"}) {
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
  }
  EXPECT_FALSE(path->Reserve(8 << 20).ok());
  EXPECT_EQ(path->size(), 6u << 20);
  auto index = static_cast<std::size_t>(MemoryKind::PathState);
  EXPECT_EQ(device->memoryByKind()[index].current, 6u << 20);
  EXPECT_EQ(device->memoryByKind()[static_cast<std::size_t>(MemoryKind::Film)].peak, 0u);
  path.reset();
  EXPECT_EQ(device->memoryByKind()[index].current, 0u);
  EXPECT_EQ(device->memoryByKind()[index].peak, 6u << 20);
  EXPECT_TRUE(Buffer::Create(*device, {8 << 20, MemoryKind::Film, MemoryLocation::DeviceLocal, "film sum"}).ok());
  EXPECT_EQ(device->memoryUse().peak, 8u << 20);
  EXPECT_EQ(ValidationMessageCount(), messages);
}

TEST_F(VulkanTest, AbsurdSizesAreErrors) {
  for (const uint64_t size : {uint64_t{1} << 40, uint64_t{1} << 62, ~uint64_t{0}}) {
    EXPECT_FALSE(Buffer::Create(*device_, {size, MemoryKind::Other, MemoryLocation::DeviceLocal, "absurd"}).ok());
  }
  ImageDesc desc;
  desc.width = 1 << 30;
  EXPECT_FALSE(Image::Create(*device_, desc).ok());
  desc.width = 0;
  EXPECT_FALSE(Image::Create(*device_, desc).ok());
}

// Samples along a ramp in each dimension: linear filtering, clamping at the edge, layers apart.
TEST_P(StagingTest, ImagesOfEveryShapeAreSampled) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer},
                                                       {1, DescriptorKind::SampledImage},
                                                       {2, DescriptorKind::SampledImage},
                                                       {3, DescriptorKind::SampledImage},
                                                       {4, DescriptorKind::SampledImage, 2}}));
  auto pipeline = MakePipeline(*layout, R"(
    layout(local_size_x = 1) in;
    layout(binding = 0, std430) buffer Out { float result[8]; };
    layout(binding = 1) uniform sampler1D line;
    layout(binding = 2) uniform sampler2D plane;
    layout(binding = 3) uniform sampler3D volume;
    layout(binding = 4) uniform sampler2DArray pools[2];
    void main() {
      result[0] = textureLod(line, 0.5, 0).x;
      result[1] = textureLod(line, -3.0, 0).x;
      result[2] = textureLod(plane, vec2(0.5, 0.5), 0).x;
      result[3] = textureLod(plane, vec2(0.25, 1.0), 0).x;
      result[4] = textureLod(volume, vec3(0.25, 0.25, 0.5), 0).x;
      result[5] = textureLod(pools[0], vec3(0.5, 0.5, 1), 0).x;
      result[6] = textureLod(pools[1], vec3(0.5, 0.5, 0), 0).y;
      result[7] = textureLod(pools[1], vec3(0.5, 0.5, 2), 0).y;
    })");
  const auto make = [&](ImageShape shape, Format format, uint32_t w, uint32_t h, uint32_t d, uint32_t layers) {
    return Must(Image::Create(*device_, {shape, format, w, h, d, layers, MemoryKind::Textures, "image"}));
  };
  const auto line = make(ImageShape::Line, Format::R32Float, 4, 1, 1, 1);
  const auto plane = make(ImageShape::Plane, Format::R32Float, 2, 2, 1, 1);
  const auto volume = make(ImageShape::Volume, Format::R32Float, 2, 2, 2, 1);
  const auto floats = make(ImageShape::PlaneArray, Format::Rgba32Float, 1, 1, 1, 2);
  const auto bytes = make(ImageShape::PlaneArray, Format::Rgba8Unorm, 2, 2, 1, 3);
  const float ramp[] = {1, 2, 4, 8, 16, 32, 64, 128};
  Must(line->Upload(std::as_bytes(std::span(ramp, 4))));
  Must(plane->Upload(std::as_bytes(std::span(ramp, 4))));
  Must(volume->Upload(std::as_bytes(std::span(ramp))));
  const ImageRegion page{0, 0, 0, 1, 1, 1, 1, 16};
  Must(floats->Upload(std::span(&page, 1), std::as_bytes(std::span(ramp))));
  const std::vector<uint8_t> texels = {0, 51, 0, 0, 0, 51, 0, 0, 0, 51, 0, 0, 0, 51, 0, 0, 0, 102, 0, 0,
                                       0, 102, 0, 0, 0, 102, 0, 0, 0, 102, 0, 0};
  const ImageRegion pages[] = {{0, 0, 0, 0, 2, 2, 1, 0}, {0, 0, 0, 2, 2, 2, 1, 16}};
  Must(bytes->Upload(pages, std::as_bytes(std::span(texels))));
  const ImageRegion outside[] = {{1, 0, 0, 0, 2, 2, 1, 0}, {0, 0, 0, 3, 2, 2, 1, 0}, {0, 0, 0, 0, 2, 2, 1, 20}};
  for (const ImageRegion& region : outside) {
    EXPECT_FALSE(bytes->Upload(std::span(&region, 1), std::as_bytes(std::span(texels))).ok());
  }

  const auto sampler = Must(Sampler::Create(*device_, Filter::Linear));
  auto out = MakeBuffer(32);
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *out));
  Must(set->WriteImage(1, *line, *sampler));
  Must(set->WriteImage(2, *plane, *sampler));
  Must(set->WriteImage(3, *volume, *sampler));
  Must(set->WriteImage(4, *floats, *sampler, 0));
  Must(set->WriteImage(4, *bytes, *sampler, 1));
  EXPECT_FALSE(set->WriteImage(4, *bytes, *sampler, 2).ok());
  RunOnce(*pipeline, *set, 1);
  const std::vector<float> result = Read<float>(*out, 8);
  const float expected[] = {3, 1, 3.75f, 4, 8.5f, 16, 0.2f, 0.4f};
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(result[i], expected[i], 1e-3f * expected[i]) << i;
}

TEST_F(VulkanTest, ABigImageIsUploadedInPieces) {
  constexpr uint32_t kSize = 160;  // 160^3 * 4 bytes = 16 MB: more than a staging chunk
  auto image = Must(Image::Create(
      *device_, {ImageShape::Volume, Format::R32Float, kSize, kSize, kSize, 1, MemoryKind::Tables, "big"}));
  std::vector<float> values(kSize * kSize * kSize);
  std::iota(values.begin(), values.end(), 0.0f);
  Must(image->Upload(std::as_bytes(std::span(values))));
  auto layout = Must(
      PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}, {1, DescriptorKind::SampledImage}}));
  auto pipeline = MakePipeline(*layout, R"(
    layout(local_size_x = 64) in;
    layout(binding = 0) buffer Wrong { uint wrong; };
    layout(binding = 1) uniform sampler3D volume;
    void main() {
      uint i = gl_GlobalInvocationID.x;
      float value = texelFetch(volume, ivec3(i % 160, i / 160 % 160, i / 25600), 0).x;
      if (value != float(i)) atomicAdd(wrong, 1);
    })");
  auto wrong = MakeBuffer(std::vector<uint32_t>{0});
  const auto sampler = Must(Sampler::Create(*device_, Filter::Nearest));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *wrong));
  Must(set->WriteImage(1, *image, *sampler));
  RunOnce(*pipeline, *set, kSize * kSize * kSize / 64);
  EXPECT_EQ(Read<uint32_t>(*wrong, 1)[0], 0u);
}

// As a texture page pool is filled: more pages than a staging chunk holds, in one call, in any order.
TEST_F(VulkanTest, ManyPagesAreUploadedAtOnce) {
  constexpr uint32_t kLayers = 700, kPageBytes = 64 * 64 * 4;
  auto image = Must(Image::Create(
      *device_, {ImageShape::PlaneArray, Format::Rgba8Unorm, 64, 64, 1, kLayers, MemoryKind::Textures, "pool"}));
  std::vector<uint32_t> texels(kLayers * 64 * 64);
  std::vector<ImageRegion> regions;
  for (uint32_t i = 0; i < kLayers; ++i) {
    const uint32_t layer = (i * 37) % kLayers;
    for (uint32_t t = 0; t < 64 * 64; ++t) texels[i * 64 * 64 + t] = layer * 4096 + t;
    regions.push_back({0, 0, 0, layer, 64, 64, 1, uint64_t{i} * kPageBytes});
  }
  Must(image->Upload(regions, std::as_bytes(std::span(texels))));
  auto layout = Must(
      PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}, {1, DescriptorKind::SampledImage}}));
  auto pipeline = MakePipeline(*layout, R"(
    layout(local_size_x = 64) in;
    layout(binding = 0) buffer Wrong { uint wrong; };
    layout(binding = 1) uniform sampler2DArray pool;
    void main() {
      uint i = gl_GlobalInvocationID.x;
      uint value = packUnorm4x8(texelFetch(pool, ivec3(i % 64, i / 64 % 64, i / 4096), 0));
      if (value != i) atomicAdd(wrong, 1);
    })");
  auto wrong = MakeBuffer(std::vector<uint32_t>{0});
  const auto sampler = Must(Sampler::Create(*device_, Filter::Nearest));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *wrong));
  Must(set->WriteImage(1, *image, *sampler));
  RunOnce(*pipeline, *set, kLayers * 64);
  EXPECT_EQ(Read<uint32_t>(*wrong, 1)[0], 0u);
}

}  // namespace
}  // namespace wavefront::vulkan
