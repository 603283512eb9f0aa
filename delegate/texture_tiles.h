// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Files of an image that is cut into tiles: patterns with <UDIM> (1001 + column + 10 * row) or <UVTILE> (u1_v1 ...).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace delegate {

bool IsTilePattern(const std::string& path);
// The tiles that exist as plain files, by UDIM number, 1001 to 9999, ascending.
std::vector<std::pair<uint32_t, std::string>> FindTiles(const std::string& pattern);
// Tiles between the outermost ones of `tiles` that are not among them, as text for a diagnostic; empty: none.
std::string MissingTiles(const std::vector<std::pair<uint32_t, std::string>>& tiles);

}  // namespace delegate
