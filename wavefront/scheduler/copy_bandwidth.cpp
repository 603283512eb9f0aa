// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>
#include <array>

#include "wavefront/renderer.h"
#include "wavefront/vulkan/command_stream.h"

namespace wavefront {
namespace {

constexpr uint64_t kBytes = 64ull << 20;  // more than a processor's caches, or an L2, hold
constexpr int kTries = 8;

Result<double> SecondsOfCopy(vulkan::CommandStream& stream, const vulkan::Buffer& from, const vulkan::Buffer& to) {
  if (auto free = stream.Wait(stream.nextFreeAt()); !free) return free.error();
  if (Status s = stream.Begin(); !s) return s.error();
  stream.Timestamp();
  stream.Copy(from, 0, to, 0, kBytes);
  stream.Barrier();
  stream.Timestamp();
  auto value = stream.Submit();
  if (!value) return value.error();
  if (auto done = stream.Wait(value.value()); !done) return done.error();
  std::array<double, 2> times{};
  auto count = stream.ReadTimestamps(value.value(), times);
  if (!count) return count.error();
  if (count.value() < times.size()) return Error{"The device gives no timestamps."};
  return (times[1] - times[0]) * 1e-9;
}

}  // namespace

Result<DeviceBandwidth> MeasureCopyBandwidth(const std::string& selector) {
  vulkan::DeviceOptions options;
  options.selector = selector;
  auto device = vulkan::Device::Create(options);
  if (!device) return device.error();
  std::array<std::unique_ptr<vulkan::Buffer>, 2> buffers;
  for (auto& buffer : buffers) {
    auto made = vulkan::Buffer::Create(*device.value(), {kBytes, vulkan::MemoryKind::Other, vulkan::MemoryLocation::DeviceLocal, "bandwidth"});
    if (!made) return made.error();
    buffer = std::move(made).value();
  }
  auto stream = vulkan::CommandStream::Create(*device.value());
  if (!stream) return stream.error();
  const vulkan::DeviceInfo& info = device.value()->info();
  DeviceBandwidth result{info.name, info.driverName + " " + info.driverVersion, std::string(vulkan::DeviceTypeName(info.type)), 0};
  for (int i = 0; i < kTries; ++i) {
    auto seconds = SecondsOfCopy(*stream.value(), *buffers[0], *buffers[1]);
    if (!seconds) return seconds.error();
    if (seconds.value() > 0) result.bytesPerSecond = std::max(result.bytesPerSecond, 2.0 * kBytes / seconds.value());
  }
  return result;
}

}  // namespace wavefront
