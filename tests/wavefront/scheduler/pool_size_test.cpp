// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/pool_size.h"

#include <gtest/gtest.h>

namespace wavefront {
namespace {

using vulkan::DeviceType;

uint32_t Software(std::size_t buckets, bool interactive = false) {
  return DefaultPoolSize(DeviceType::Cpu, ExecutionMode::Wavefront, buckets, interactive);
}

TEST(PoolSize, GrowsWithTheKernelsOnSoftwareDevices) {
  EXPECT_EQ(Software(0), 65536u);
  EXPECT_EQ(Software(32), 65536u);
  EXPECT_EQ(Software(33), 131072u);
  EXPECT_EQ(Software(100), 262144u);
  EXPECT_EQ(Software(100000), 262144u) << "memory is bounded";
}

TEST(PoolSize, StaysSmallWhereEditsWaitForIterations) { EXPECT_EQ(Software(100, true), 65536u); }

TEST(PoolSize, DoesNotAskForKernelsElsewhere) {
  EXPECT_EQ(DefaultPoolSize(DeviceType::Discrete, ExecutionMode::Wavefront, 100, false), 1u << 20);
  EXPECT_EQ(DefaultPoolSize(DeviceType::Cpu, ExecutionMode::Megakernel, 100, false), 4096u);
  EXPECT_EQ(DefaultPoolSize(DeviceType::Discrete, ExecutionMode::Megakernel, 100, false), 1u << 18);
}

}  // namespace
}  // namespace wavefront
