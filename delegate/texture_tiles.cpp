// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/texture_tiles.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

namespace delegate {
namespace {

constexpr std::string_view kTokens[] = {"<UDIM>", "<UVTILE>"};
constexpr int kMaximumNamed = 8;

// A run of digits at `at`, which moves past it; 0 where there is none or it is too long.
uint32_t Digits(const std::string& text, size_t* at) {
  uint32_t value = 0;
  const size_t begin = *at;
  while (*at < text.size() && std::isdigit(static_cast<unsigned char>(text[*at])) && *at - begin < 5)
    value = value * 10 + static_cast<uint32_t>(text[(*at)++] - '0');
  return value;
}

// The UDIM number that stands for the token; 0: something else does.
uint32_t TileOf(const std::string& text, bool isUdim) {
  size_t at = 0;
  if (isUdim) {
    const uint32_t tile = Digits(text, &at);
    return at == text.size() && at == 4 ? tile : 0;
  }
  if (text.empty() || text[at++] != 'u') return 0;
  const uint32_t u = Digits(text, &at);
  if (text.compare(at, 2, "_v") != 0) return 0;
  at += 2;
  const uint32_t v = Digits(text, &at);
  return at == text.size() && u >= 1 && u <= 10 && v >= 1 ? 1000 + u + 10 * (v - 1) : 0;
}

}  // namespace

bool IsTilePattern(const std::string& path) {
  return std::any_of(std::begin(kTokens), std::end(kTokens),
                     [&](std::string_view token) { return path.find(token) != std::string::npos; });
}

std::vector<std::pair<uint32_t, std::string>> FindTiles(const std::string& pattern) {
  std::vector<std::pair<uint32_t, std::string>> tiles;
  const std::filesystem::path path(pattern);
  const std::string name = path.filename().string();
  for (const std::string_view token : kTokens) {
    const size_t at = name.find(token);
    if (at == std::string::npos) continue;
    const std::string head = name.substr(0, at), tail = name.substr(at + token.size());
    std::error_code error;
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const std::filesystem::directory_iterator end;
    for (std::filesystem::directory_iterator i(folder, error); !error && i != end; i.increment(error)) {
      const std::string file = i->path().filename().string();
      if (file.size() < head.size() + tail.size() || file.compare(0, head.size(), head) != 0 ||
          file.compare(file.size() - tail.size(), tail.size(), tail) != 0)
        continue;
      const uint32_t tile = TileOf(file.substr(head.size(), file.size() - head.size() - tail.size()), token[2] == 'D');
      if (tile >= 1001 && tile <= 9999) tiles.emplace_back(tile, i->path().string());
    }
    break;
  }
  std::sort(tiles.begin(), tiles.end());
  return tiles;
}

std::string MissingTiles(const std::vector<std::pair<uint32_t, std::string>>& tiles) {
  std::set<uint32_t> there, columns, rows;
  for (const auto& [tile, file] : tiles) {
    there.insert(tile);
    columns.insert((tile - 1001) % 10);
    rows.insert((tile - 1001) / 10);
  }
  std::string text;
  if (tiles.empty()) return text;
  int named = 0;
  for (uint32_t row = *rows.begin(); row <= *rows.rbegin(); ++row) {
    for (uint32_t column = *columns.begin(); column <= *columns.rbegin(); ++column) {
      const uint32_t tile = 1001 + column + 10 * row;
      if (there.count(tile)) continue;
      if (++named > kMaximumNamed) return text + ", and more";
      text += (text.empty() ? "" : ", ") + std::to_string(tile);
    }
  }
  return text;
}

}  // namespace delegate
