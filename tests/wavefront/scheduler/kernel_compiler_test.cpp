// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Work that the compiler's threads share with the thread that waits for it.
#include "wavefront/scheduler/kernel_compiler.h"

#include <future>

#include "tests/wavefront/vulkan/fixture.h"

namespace wavefront {
namespace {

TEST(KernelCompiler, CacheJobsAreTakenBackOrDone) {
  auto device = vulkan::Must(vulkan::Device::Create({}));
  auto layout = vulkan::Must(vulkan::PipelineLayout::Create(*device, {{0, vulkan::DescriptorKind::StorageBuffer}}));
  const auto spirv = vulkan::Glsl("layout(local_size_x = 1) in; layout(binding = 0) buffer B { uint b[]; }; void main() { b[0] = 7u; }");
  const vulkan::PipelineDesc desc{spirv, "main", {}, "cache job"};
  KernelCompiler compiler(*device, *layout, 1);
  if (compiler.driverCompile() != vulkan::DriverCompile::AtDispatchCached) GTEST_SKIP() << "this driver compiles elsewhere";

  // While its only thread is at a material, nobody begins them: they come back, once.
  std::promise<void> begun, go;
  compiler.Enqueue({{0, "material", [&] {
                       begun.set_value();
                       go.get_future().wait();
                       return KernelCode{{}, "on purpose", 0, false};
                     }}});
  begun.get_future().wait();
  compiler.EnqueueFirst({{1, &desc}, {2, &desc}});
  EXPECT_TRUE(compiler.TakeBack(2));
  EXPECT_FALSE(compiler.TakeBack(2));
  EXPECT_FALSE(compiler.TakeBack(3));
  // The other is done before the next material begins.
  std::promise<bool> left;
  compiler.Enqueue({{1, "next material", [&] {
                       left.set_value(compiler.TakeBack(1));
                       return KernelCode{{}, "on purpose", 0, false};
                     }}});
  go.set_value();
  compiler.WaitForCacheJobs();
  EXPECT_FALSE(compiler.TakeBack(1));
  EXPECT_FALSE(left.get_future().get());
}

// The layer looks devices up in a table that it does not lock: a device of a thread's own that is validated too makes any
// call of another thread crash, now and then. Two instances are alive: the one with the layer, and one without.
TEST(KernelCompiler, DevicesOfItsThreadsAreNotValidated) {
  vulkan::DeviceOptions options;
  options.validation = true;
  auto device = vulkan::Must(vulkan::Device::Create(options));
  auto layout = vulkan::Must(vulkan::PipelineLayout::Create(*device, {{0, vulkan::DescriptorKind::StorageBuffer}}));
  const auto spirv = vulkan::Glsl("layout(local_size_x = 1) in; layout(binding = 0) buffer B { uint b[]; }; void main() { b[0] = 9u; }");
  const int64_t before = vulkan::LiveHandles()["Instance"];
  std::promise<int64_t> during;
  KernelCompiler compiler(*device, *layout, 1);
  if (compiler.driverCompile() != vulkan::DriverCompile::AtDispatchCached) GTEST_SKIP() << "this driver compiles elsewhere";
  compiler.Enqueue({{0, "first", [&] { return KernelCode{spirv, "", 0, false}; }},
                    {1, "second", [&] {  // the thread's device is alive since the first
                       during.set_value(vulkan::LiveHandles()["Instance"]);
                       return KernelCode{{}, "on purpose", 0, false};
                     }}});
  EXPECT_EQ(during.get_future().get(), before + 1);
}

}  // namespace
}  // namespace wavefront
