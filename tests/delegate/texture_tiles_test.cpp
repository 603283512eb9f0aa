// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/texture_tiles.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace delegate {
namespace {

struct Folder {
  std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "texture_tiles_test";
  Folder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::vector<uint32_t> Tiles(const std::string& pattern) const {
    std::vector<uint32_t> numbers;
    for (const auto& [number, file] : FindTiles((path / pattern).string())) numbers.push_back(number);
    return numbers;
  }
};

TEST(TextureTiles, FilesOfAPatternAreFoundByTheirNumbers) {
  const Folder folder;
  for (const char* name : {"t.1001.png", "t.1012.png", "t.101.png", "t.10011.png", "t.0999.png", "x1003.png",
                           "t.1002.exr", "s_u1_v1.png", "s_u2_v2.png", "s_u11_v1.png", "s_u0_v1.png", "s_u1_v0.png"})
    std::ofstream(folder.path / name) << "x";
  EXPECT_EQ(folder.Tiles("t.<UDIM>.png"), (std::vector<uint32_t>{1001, 1012}));
  EXPECT_EQ(FindTiles((folder.path / "t.<UDIM>.png").string())[1].second, (folder.path / "t.1012.png").string());
  EXPECT_EQ(folder.Tiles("s_<UVTILE>.png"), (std::vector<uint32_t>{1001, 1012}));
  EXPECT_TRUE(folder.Tiles("gone/t.<UDIM>.png").empty());
  EXPECT_TRUE(IsTilePattern("a/t.<UDIM>.png") && IsTilePattern("t<UVTILE>") && !IsTilePattern("t.1001.png"));
}

TEST(TextureTiles, WhatIsMissingBetweenTilesIsNamed) {
  EXPECT_EQ(MissingTiles({}), "");
  EXPECT_EQ(MissingTiles({{1003, ""}}), "");
  EXPECT_EQ(MissingTiles({{1001, ""}, {1003, ""}, {1011, ""}}), "1002, 1012, 1013");
  EXPECT_EQ(MissingTiles({{1001, ""}, {9999, ""}}), "1002, 1003, 1004, 1005, 1006, 1007, 1008, 1009, and more");
}

}  // namespace
}  // namespace delegate
