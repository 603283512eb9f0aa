// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The command line of wavefront-bench.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "wavefront/base/result.h"

namespace bench {

struct Options {
  std::vector<std::string> files;   // scene files
  std::string sweep;                // a row of Sweeps(); empty: none
  std::vector<uint32_t> points;     // of the sweep, in place of its own
  bool wavefront = true, megakernel = true;
  uint32_t runs = 3;                // of each mode, after one that is not counted
  uint32_t samples = 0, width = 0, height = 0;  // 0: the scene's
  double seconds = -1;              // that a render shall take; 0: as long as the scene's samples do; -1: not said
  std::vector<uint32_t> pools;      // 0: what suits the device
  std::string device;
  bool rays = false;                // cast rays instead of rendering
  bool validate = false, compare = false, quick = false, listDevices = false, help = false;
  std::string json, image, write;   // files; empty: none
};

wavefront::Result<Options> ParseOptions(std::span<const char* const> arguments);
std::string Usage();

}  // namespace bench
