// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Bindings, pipelines and the command stream.
#include <cstring>
#include <numeric>
#include <thread>

#include "fixture.h"

namespace wavefront::vulkan {
namespace {

template <typename T>
std::span<const std::byte> BytesOf(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

constexpr const char* kAddOne = R"(
  layout(local_size_x_id = 0) in;
  layout(constant_id = 1) const uint kStep = 1;
  layout(binding = 0) buffer Values { uint values[]; };
  void main() { values[gl_GlobalInvocationID.x] += kStep; })";

TEST_F(VulkanTest, SpecializationSetsWorkgroupSizeAndConstants) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  auto pipeline = MakePipeline(*layout, kAddOne, {{0, 32}, {1, 5}});
  EXPECT_GT(pipeline->creationSeconds(), 0);
  auto buffer = MakeBuffer(std::vector<uint32_t>(128, 0));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *buffer));
  RunOnce(*pipeline, *set, 3);
  const auto values = Read<uint32_t>(*buffer, 128);
  EXPECT_EQ(values[95], 5u);
  EXPECT_EQ(values[96], 0u);
}

TEST_F(VulkanTest, TexelBuffersOfEveryFormat) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer},
                                                       {1, DescriptorKind::TexelBufferUint},
                                                       {2, DescriptorKind::TexelBufferFloat}}));
  auto pipeline = MakePipeline(*layout, R"(
    layout(local_size_x = 1) in;
    layout(binding = 0, std430) buffer Out { uvec4 integers; vec4 floats; };
    layout(binding = 1) uniform usamplerBuffer u;
    layout(binding = 2) uniform samplerBuffer f;
    void main() { integers = texelFetch(u, 0); floats = texelFetch(f, 0); })");
  const uint64_t offset = device_->info().limits.texelBufferOffsetAlignment;
  std::vector<std::byte> raw(offset + 16);
  const uint32_t words[4] = {0x3c003800, 0x40004200, 7, 8};  // halves 0.5, 1, 3, 2
  std::memcpy(raw.data() + offset, words, 16);
  auto data = MakeBuffer(raw);
  auto out = MakeBuffer(32);
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *out));
  const auto run = [&](Format integers, Format floats) {
    Must(set->WriteTexels(1, *data, integers, offset));
    Must(set->WriteTexels(2, *data, floats, offset));
    RunOnce(*pipeline, *set, 1);
    return std::pair(Read<uint32_t>(*out, 4), Read<float>(*out, 4, 16));
  };
  auto [integers, floats] = run(Format::Rgba32Uint, Format::Rgba16Float);
  EXPECT_EQ(integers, (std::vector<uint32_t>{words[0], words[1], 7, 8}));
  EXPECT_EQ(floats, (std::vector<float>{0.5f, 1, 3, 2}));
  std::tie(integers, floats) = run(Format::R32Uint, Format::Rgba8Unorm);
  EXPECT_EQ(integers[0], words[0]);
  EXPECT_FLOAT_EQ(floats[1], 0x38 / 255.0f);
  std::tie(integers, floats) = run(Format::R32Uint, Format::R32Float);
  float expected = 0;
  std::memcpy(&expected, words, 4);
  EXPECT_EQ(floats[0], expected);
  std::tie(integers, floats) = run(Format::R32Uint, Format::Rgba32Float);
  EXPECT_EQ(floats[0], expected);
}

TEST_F(VulkanTest, UnwrittenBindingsReadZeros) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer},
                                                       {1, DescriptorKind::TexelBufferUint},
                                                       {2, DescriptorKind::TexelBufferFloat},
                                                       {3, DescriptorKind::StorageBuffer},
                                                       {4, DescriptorKind::UniformBuffer}}));
  auto pipeline = MakePipeline(*layout, R"(
    layout(local_size_x = 1) in;
    layout(binding = 0, std430) buffer Out { uint result; };
    layout(binding = 1) uniform usamplerBuffer u;
    layout(binding = 2) uniform samplerBuffer f;
    layout(binding = 3, std430) readonly buffer In { uint value; };
    layout(binding = 4) uniform Block { uint block; };
    void main() { result = texelFetch(u, 0).x + uint(texelFetch(f, 0).x) + value + block; })");
  auto out = MakeBuffer(std::vector<uint32_t>{99});
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *out));
  RunOnce(*pipeline, *set, 1);
  EXPECT_EQ(Read<uint32_t>(*out, 1)[0], 0u);
}

TEST_F(VulkanTest, WrongBindingsAreErrors) {
  EXPECT_FALSE(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}, {0, DescriptorKind::StorageBuffer}}).ok());
  EXPECT_FALSE(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer, 1u << 30}}).ok());
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}, {1, DescriptorKind::TexelBufferUint}}));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  auto buffer = MakeBuffer(256);
  EXPECT_FALSE(set->Write(1, *buffer).ok());
  EXPECT_FALSE(set->Write(7, *buffer).ok());
  EXPECT_FALSE(set->Write(0, *buffer, 512).ok());
  EXPECT_FALSE(set->Write(0, *buffer, 0, 512).ok());
  EXPECT_FALSE(set->WriteTexels(0, *buffer, Format::R32Uint).ok());
  EXPECT_FALSE(set->WriteTexels(1, *buffer, Format::R32Float).ok());
}

TEST_F(VulkanTest, ABindingPastTheDevicesRangeIsAnError) {
  const uint64_t limit = device_->info().limits.maxStorageBufferRange;
  if (limit > 1u << 28) return;  // too big to allocate in a test: the check is the same one
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  auto buffer = MakeBuffer(limit + 16, "huge");
  const Status whole = set->Write(0, *buffer);
  ASSERT_FALSE(whole.ok());
  EXPECT_NE(whole.error().message.find("'huge'"), std::string::npos);
  Must(set->Write(0, *buffer, 0, limit));
}

TEST_F(VulkanTest, WhatIsNotSpirvIsAnError) {
  auto layout = Must(PipelineLayout::Create(*device_, {}));
  const std::vector<uint32_t> words = {1, 2, 3, 4, 5, 6};
  const auto pipeline = ComputePipeline::Create(*device_, *layout, {words, "main", {}, "broken kernel"});
  ASSERT_FALSE(pipeline.ok());
  EXPECT_NE(pipeline.error().message.find("broken kernel"), std::string::npos);
  EXPECT_FALSE(ComputePipeline::Create(*device_, *layout, {}).ok());
}

TEST_F(VulkanTest, PipelinesAreMadeInParallel) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  const std::vector<uint32_t> spirv = Glsl(kAddOne);
  std::vector<std::thread> threads;
  std::vector<std::unique_ptr<ComputePipeline>> pipelines(8);
  for (uint32_t i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      auto made = ComputePipeline::Create(*device_, *layout, {spirv, "main", {{0, 8}, {1, i}}, "parallel"});
      if (made) pipelines[i] = std::move(*made);
    });
  }
  for (std::thread& thread : threads) thread.join();
  auto buffer = MakeBuffer(std::vector<uint32_t>(8, 0));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *buffer));
  for (const auto& pipeline : pipelines) {
    ASSERT_NE(pipeline, nullptr);
    RunOnce(*pipeline, *set, 1);
  }
  EXPECT_EQ(Read<uint32_t>(*buffer, 8), std::vector<uint32_t>(8, 28));
}

// A queue in small: one kernel counts, the next takes its size from the count.
TEST_F(VulkanTest, IndirectDispatchTakesItsSizeFromAKernel) {
  auto layout = Must(
      PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}, {1, DescriptorKind::StorageBuffer}}));
  auto produce = MakePipeline(*layout, R"(
    layout(local_size_x = 64) in;
    layout(binding = 1, std430) buffer Arguments { uint x, y, z; } arguments[1];
    layout(push_constant) uniform Push { uint every; };
    void main() { if (gl_GlobalInvocationID.x % every == 0) atomicAdd(arguments[0].x, 1); })");
  auto consume = MakePipeline(*layout, R"(
    layout(local_size_x = 1) in;
    layout(binding = 0, std430) buffer Values { uint count; };
    void main() { atomicAdd(count, 1); })");
  auto values = MakeBuffer(std::vector<uint32_t>(4, 0));
  auto arguments = MakeBuffer(64);
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *values));
  Must(set->Write(1, *arguments));
  auto stream = Must(CommandStream::Create(*device_));
  uint32_t total = 0;
  for (const uint32_t every : {1u, 3u, 1000u}) {
    Must(stream->Begin());
    const uint32_t start[3] = {0, 1, 1};
    stream->Update(*arguments, 0, std::as_bytes(std::span(start)));
    stream->BindSet(*set);
    stream->PushConstants(BytesOf(every));
    stream->Barrier();
    stream->BindPipeline(*produce);
    stream->Dispatch(10);
    stream->Barrier();
    stream->BindPipeline(*consume);
    stream->DispatchIndirect(*arguments, 0);
    stream->Barrier();
    stream->Fill(*arguments, 0, 4, 0);
    stream->Barrier();
    stream->DispatchIndirect(*arguments, 0);  // empty
    EXPECT_TRUE(Must(stream->Wait(Must(stream->Submit()))));
    total += (640 + every - 1) / every;
    EXPECT_EQ(Read<uint32_t>(*values, 1)[0], total);
  }
}

TEST_F(VulkanTest, BarriersOrderDispatchesAndSubmissions) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  auto pipeline = MakePipeline(*layout, kAddOne, {{0, 64}});
  auto buffer = MakeBuffer(std::vector<uint32_t>(4096, 0));
  auto copy = MakeBuffer(4096 * 4);
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *buffer));
  auto stream = Must(CommandStream::Create(*device_, {2, 0, "ordered"}));
  for (int submission = 0; submission < 10; ++submission) {
    EXPECT_TRUE(Must(stream->Wait(stream->nextFreeAt())));
    Must(stream->Begin());
    stream->BindSet(*set);
    stream->BindPipeline(*pipeline);
    for (int i = 0; i < 10; ++i) {
      stream->Dispatch(64);
      stream->Barrier();
    }
    EXPECT_EQ(stream->Timestamp(), CommandStream::kNoTimestamp);
    if (submission == 9) stream->Copy(*buffer, 0, *copy, 0, 4096 * 4);
    EXPECT_EQ(Must(stream->Submit()), static_cast<uint64_t>(submission + 1));
  }
  EXPECT_EQ(Read<uint32_t>(*copy, 4096), std::vector<uint32_t>(4096, 100));
  EXPECT_EQ(Must(stream->Completed()), 10u);
}

TEST_F(VulkanTest, TimestampsGrowAndAreKeptPerSubmission) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  auto pipeline = MakePipeline(*layout, kAddOne, {{0, 64}});
  auto buffer = MakeBuffer(std::vector<uint32_t>(1 << 18, 0));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *buffer));
  auto stream = Must(CommandStream::Create(*device_, {2, 8, "timed"}));
  uint64_t values[3] = {};
  for (uint64_t& value : values) {
    EXPECT_TRUE(Must(stream->Wait(stream->nextFreeAt())));
    Must(stream->Begin());
    stream->BeginLabel("timed work");
    stream->BindSet(*set);
    stream->BindPipeline(*pipeline);
    for (uint32_t i = 0; i < 8; ++i) {
      EXPECT_EQ(stream->Timestamp(), i);
      stream->Dispatch(4096);
      stream->Barrier();
    }
    EXPECT_EQ(stream->Timestamp(), CommandStream::kNoTimestamp);
    stream->EndLabel();
    value = Must(stream->Submit());
  }
  EXPECT_TRUE(Must(stream->Wait(values[2])));
  EXPECT_FALSE(stream->ReadTimestamps(values[0], {}).ok());  // its slot was used again
  double last = 0;
  for (const uint64_t value : {values[1], values[2]}) {
    double times[16];
    ASSERT_EQ(Must(stream->ReadTimestamps(value, times)), 8u);
    for (int i = 0; i < 8; ++i) {
      EXPECT_GT(times[i], last) << i;
      last = times[i];
    }
    EXPECT_LT(times[7] - times[0], 60e9);
  }
}

TEST_F(VulkanTest, AFullRingRefusesAndWaitTimesOut) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  auto pipeline = MakePipeline(*layout, R"(
    layout(local_size_x = 64) in;
    layout(binding = 0) buffer Values { uint values[]; };
    void main() {
      uint x = gl_GlobalInvocationID.x;
      for (int i = 0; i < 20000; ++i) x = x * 1664525u + 1013904223u;
      values[gl_GlobalInvocationID.x % 64] = x;
    })");
  auto buffer = MakeBuffer(256);
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *buffer));
  auto stream = Must(CommandStream::Create(*device_, {1, 0, "ring"}));
  Must(stream->Begin());
  stream->BindSet(*set);
  stream->BindPipeline(*pipeline);
  stream->Dispatch(1 << 9);
  const uint64_t value = Must(stream->Submit());
  EXPECT_FALSE(Must(stream->Wait(value, 0)));
  EXPECT_EQ(stream->nextFreeAt(), value);
  EXPECT_FALSE(stream->Begin().ok());
  EXPECT_TRUE(Must(stream->Wait(value)));
  Must(stream->Begin());
  Must(stream->Submit());
}

TEST_F(VulkanTest, SixtyFourBitAtomicsAdd) {
  auto layout = Must(PipelineLayout::Create(*device_, {{0, DescriptorKind::StorageBuffer}}));
  auto pipeline = MakePipeline(*layout, R"(
    #extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
    #extension GL_EXT_shader_atomic_int64 : require
    #extension GL_EXT_scalar_block_layout : require
    layout(local_size_x = 64) in;
    layout(binding = 0, scalar) buffer Sums { uint odd; uint pad; int64_t sum; };
    void main() { atomicAdd(sum, int64_t(gl_GlobalInvocationID.x) * 0x100000001l); })");
  auto buffer = MakeBuffer(std::vector<uint64_t>(2, 0));
  auto set = Must(DescriptorSet::Create(*device_, *layout));
  Must(set->Write(0, *buffer));
  RunOnce(*pipeline, *set, 100);
  EXPECT_EQ(Read<uint64_t>(*buffer, 1, 8)[0], uint64_t{6400} * 6399 / 2 * 0x100000001ull);
}

}  // namespace
}  // namespace wavefront::vulkan
