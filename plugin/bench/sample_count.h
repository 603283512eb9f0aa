// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// How many samples a render needs whose time says something: the pool is full for nearly all of it, and it is longer than what
// the host and the clock add.
#pragma once

#include <cstdint>
#include <span>

namespace bench {

constexpr uint32_t kRefills = 16;            // paths of a render, in pools: at the start and at the end the pool is not full
constexpr double kLongest = 5;               // times the seconds that were asked for
constexpr uint32_t kMostSamples = 1u << 16;  // of what is chosen here

// A variant, from a short render.
struct Probe {
  uint32_t poolSize = 0;
  double secondsPerSample = 0;  // of the whole image
};

// At least `least`; as many as fill each variant's pool kRefills times and take its render `seconds`, but no more than take
// the slowest kLongest times that.
uint32_t SamplesFor(uint32_t least, uint64_t pixels, double seconds, std::span<const Probe> probes);

}  // namespace bench
