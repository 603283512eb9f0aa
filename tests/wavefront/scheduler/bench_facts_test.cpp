// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the benchmark asks of the core besides times: state that a kernel moves, and what copying reaches.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "wavefront/renderer.h"
#include "wavefront/scheduler/kernel_spirv.h"
#include "wavefront/scheduler/state_traffic.h"

namespace wavefront {
namespace {

void Add(std::vector<uint32_t>& module, uint32_t op, std::initializer_list<uint32_t> operands) {
  module.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
  module.insert(module.end(), operands);
}

// main (10) loads a word of one element, stores it and calls f (20) twice; f fetches one texel and stores one element. Variable 1 is
// path state as it is written (binding 1), 2 as it is read (binding 2), 3 another storage buffer.
std::vector<uint32_t> Module() {
  std::vector<uint32_t> m = {0x07230203, 0x00010300, 0, 100, 0};
  Add(m, 15, {5, 10, 0x6e69616d, 0});
  Add(m, 71, {1, 33, 1});
  Add(m, 71, {2, 33, 2});
  Add(m, 71, {3, 33, 3});
  Add(m, 54, {90, 20, 0, 91});
  Add(m, 248, {60});
  Add(m, 61, {92, 30, 2});
  Add(m, 95, {94, 36, 30, 40});
  Add(m, 65, {93, 31, 1, 40});
  Add(m, 62, {31, 30});
  Add(m, 65, {93, 32, 3, 40});
  Add(m, 62, {32, 30});  // not path state
  Add(m, 56, {});
  Add(m, 54, {90, 10, 0, 91});
  Add(m, 248, {61});
  Add(m, 57, {90, 33, 20});
  Add(m, 57, {90, 34, 20});
  Add(m, 65, {93, 35, 1, 41, 40, 42});
  Add(m, 61, {92, 37, 35});
  Add(m, 62, {35, 37});
  Add(m, 56, {});
  Add(m, 54, {90, 50, 0, 91});  // nobody calls it
  Add(m, 248, {62});
  Add(m, 61, {92, 51, 2});
  Add(m, 95, {94, 52, 51, 40});
  Add(m, 56, {});
  return m;
}

TEST(StateTraffic, CountsPlacesThroughCalls) {
  const StateTraffic traffic = StateTrafficOf(Module());
  EXPECT_EQ(traffic.bytesRead, 2u * 16 + 4);
  EXPECT_EQ(traffic.bytesWritten, 2u * 16 + 4);
}

// main: a loop (header 70, body 71, its end 72, behind it 73) whose body loads once; then, by a condition, one load (74)
// or two stores (75); then, by a constant (96) that is false, three stores (77) or nothing; then one store (78).
std::vector<uint32_t> Branches(bool specialized) {
  std::vector<uint32_t> m = {0x07230203, 0x00010300, 0, 200, 0};
  Add(m, 15, {5, 10, 0x6e69616d, 0});
  Add(m, 71, {1, 33, 1});
  Add(m, 71, {2, 33, 2});
  if (specialized) Add(m, 71, {96, 1, 1007});
  Add(m, specialized ? 49 : 42, {95, 96});  // false
  const auto load = [&] { Add(m, 95, {94, 36, 30, 40}); };
  const auto store = [&] { Add(m, 65, {93, 31, 1, 40}); Add(m, 62, {31, 30}); };
  Add(m, 54, {90, 10, 0, 91});
  Add(m, 248, {69});
  Add(m, 61, {92, 30, 2});  // the texel view, once for all: it moves nothing
  Add(m, 249, {70});
  Add(m, 248, {70});
  Add(m, 246, {73, 72, 0});
  Add(m, 249, {71});
  Add(m, 248, {71});
  load();
  Add(m, 250, {97, 72, 73});
  Add(m, 248, {72});
  Add(m, 249, {70});
  Add(m, 248, {73});
  Add(m, 250, {97, 74, 75});
  Add(m, 248, {74});
  load();
  Add(m, 249, {76});
  Add(m, 248, {75});
  store();
  store();
  Add(m, 249, {76});
  Add(m, 248, {76});
  Add(m, 250, {96, 77, 78});
  Add(m, 248, {77});
  for (int i = 0; i < 3; ++i) store();
  Add(m, 249, {78});
  Add(m, 248, {78});
  store();
  Add(m, 253, {});
  Add(m, 56, {});
  return m;
}

TEST(StateTraffic, IsThatOfTheWayWithMost) {
  for (const bool specialized : {false, true}) {
    const StateTraffic traffic = StateTrafficOf(Branches(specialized));
    EXPECT_EQ(traffic.bytesRead, 1u * 16);     // the loop's; not that of the other branch
    EXPECT_EQ(traffic.bytesWritten, 3u * 16);  // two of that branch, and the last; not what a constant rules out
  }
  const std::pair<uint32_t, uint32_t> other(1008, 1), yes(1007, 1);
  EXPECT_EQ(StateTrafficOf(Branches(true), {&other, 1}).bytesWritten, 3u * 16);
  EXPECT_EQ(StateTrafficOf(Branches(true), {&yes, 1}).bytesWritten, 6u * 16);
}

TEST(StateTraffic, BrokenModulesHaveNone) {
  std::vector<uint32_t> module = Module();
  module[5] = 0;  // an instruction without words
  EXPECT_EQ(StateTrafficOf(module).bytesRead, 0u);
  EXPECT_EQ(StateTrafficOf({}).bytesWritten, 0u);
}

TEST(StateTraffic, IsSeenInTheKernels) {
  // A new path's state is written, none is read; a ray reads where it begins, and writes what it found.
  const StateTraffic newPath = StateTrafficOf(KernelSpirv("new_path")), ray = StateTrafficOf(KernelSpirv("extension_ray"));
  EXPECT_GE(newPath.bytesWritten, 4u * 16);
  EXPECT_GE(ray.bytesRead, 2u * 16);
  EXPECT_EQ(ray.bytesWritten, 16u + 4);  // the hit, and its distance
  EXPECT_LE(ray.bytesRead + ray.bytesWritten, 128u);
}

TEST(CopyBandwidth, IsMeasuredOnTheDeviceThatIsChosen) {
  auto measured = MeasureCopyBandwidth("");
  ASSERT_TRUE(measured) << measured.error().message;
  EXPECT_GT(measured.value().bytesPerSecond, 0.0);
  EXPECT_FALSE(measured.value().driver.empty());
  auto unknown = MeasureCopyBandwidth("no device has this name");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("no device has this name"), std::string::npos) << unknown.error().message;
}

}  // namespace
}  // namespace wavefront
