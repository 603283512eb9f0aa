// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// OpenEXR files with any number of float channels; Hio writes four at most.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/types.h"

namespace hydra {

struct ExrImage {
  uint32_t width = 0, height = 0;
  int x = 0, y = 0;                        // the data window's left column and upper row in the display window
  uint32_t fullWidth = 0, fullHeight = 0;  // of the display window; 0: the image's
  std::vector<std::pair<std::string, std::vector<float>>> channels;  // width * height values, row 0 at the top
  float pixelAspectRatio = 1;
  std::vector<std::pair<std::string, std::string>> text;
  std::vector<std::pair<std::string, wavefront::Matrix4d>> matrices;
};

// Single-part, scanline, not compressed, 32-bit float (OpenEXR's "File Layout"). Written beside and renamed.
wavefront::Status WriteExr(const std::string& path, ExrImage image);

}  // namespace hydra
