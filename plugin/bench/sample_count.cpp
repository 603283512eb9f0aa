// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/sample_count.h"

#include <algorithm>
#include <cmath>

namespace bench {

uint32_t SamplesFor(uint32_t least, uint64_t pixels, double seconds, std::span<const Probe> probes) {
  double wanted = least, most = kMostSamples;
  for (const Probe& probe : probes) {
    const double each = std::max(probe.secondsPerSample, 1e-9);
    wanted = std::max({wanted, std::ceil(double{kRefills} * probe.poolSize / static_cast<double>(std::max<uint64_t>(pixels, 1))), std::ceil(seconds / each)});
    most = std::min(most, std::floor(kLongest * seconds / each));
  }
  return std::max(least, static_cast<uint32_t>(std::min(wanted, most)));
}

}  // namespace bench
