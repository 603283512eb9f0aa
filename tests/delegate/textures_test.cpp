// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Images that materials and lights ask for: each once, tiles of a pattern as one, and what stands in for those that miss.
#include <gtest/gtest.h>

#include <bit>

#include "tests/delegate/fakes.h"

namespace {

using delegate::MaterialUpdate;
using delegate_test::Fixture;
using delegate_test::Network;

MaterialUpdate Universal(materialgen::MaterialNetwork network) { return {{{"", std::move(network)}}}; }

wavefront::TextureData Texel() {
  wavefront::TextureData data;
  data.width = data.height = 1;
  data.texels = {1, 2, 3, 4};
  return data;
}

TEST(Textures, EachImageIsAskedForOnce) {
  Fixture f;
  f.delegate->Sync("/a", Universal(Network("/a", "surface", 0, "/wood.png")));
  f.delegate->Sync("/b", Universal(Network("/b", "surface", 1, "/wood.png")));
  auto data = Network("/c", "surface", 2, "/wood.png");
  data.nodes[1].parameters["sourceColorSpace"] = std::string("raw");
  f.delegate->Sync("/c", Universal(data));
  delegate::LightUpdate dome;
  dome.params.emplace();
  dome.params->type = "DomeLight";
  dome.params->texture = {"sky.exr", "/sky.exr", ""};
  f.delegate->Sync("/dome", dome);
  auto pending = f.delegate->PendingTextures();
  ASSERT_EQ(pending.size(), 3u);
  EXPECT_EQ(pending[0].texture.resolvedPath, "/sky.exr");
  EXPECT_EQ(pending[0].location, "/dome");
  EXPECT_EQ(pending[1].texture.resolvedPath, "/wood.png");
  EXPECT_EQ(pending[1].location, "/a/texture");
  EXPECT_EQ(pending[2].texture.colorSpace, "raw");
  for (const auto& request : pending) ASSERT_TRUE(f.delegate->SetTexture(request.key, Texel()).ok());
  EXPECT_TRUE(f.delegate->PendingTextures().empty());
  f.Commit();
  EXPECT_EQ(f.renderer->textures.size(), 3u);
  const auto idOf = [&](const std::string& path) {
    return std::bit_cast<uint32_t>(f.renderer->MaterialOf(path)->parameters[1].x);
  };
  EXPECT_EQ(idOf("/a"), idOf("/b"));
  EXPECT_NE(idOf("/a"), idOf("/c"));
  EXPECT_TRUE(f.renderer->textures.count(idOf("/a")));
  EXPECT_TRUE(f.renderer->textures.count(f.renderer->lights.begin()->second.texture));

  // An edit of a value keeps the image; the last user gone, it goes.
  f.delegate->Sync("/a", Universal(Network("/a", "surface", 9, "/wood.png")));
  EXPECT_TRUE(f.delegate->PendingTextures().empty());
  f.Commit();
  EXPECT_EQ(f.renderer->textures.size(), 3u);
  for (const char* path : {"/a", "/b", "/dome"}) f.delegate->DestroySprim(path);
  f.Commit();
  EXPECT_EQ(f.renderer->textures.size(), 1u);
  EXPECT_EQ(f.delegate->counters().texturesUploaded, 3u);
}

// What needs no conversion is one image, however it is asked for; what the file decides is another.
TEST(Textures, ColourSpacesThatConvertNothingAreOne) {
  Fixture f;
  f.delegate->SetUnconvertedColorSpaces({"Lin_Rec709", "data"});
  int count = 0;
  std::vector<std::string> paths;
  const auto ask = [&](const std::string& space, bool isColor) {
    paths.push_back("/m" + std::to_string(count++));
    auto network = Network(paths.back(), "surface", 0, "/wood.png");
    network.nodes[1].parameters["file"] = materialgen::AssetValue{"wood.png", "/wood.png", isColor ? space : ""};
    if (!isColor) network.nodes[1].parameters["sourceColorSpace"] = space;
    f.delegate->Sync(paths.back(), Universal(network));
  };
  for (const char* space : {"", "auto", "raw", "RAW", "data", "lin_rec709", "acescg", "sRGB"}) {
    ask(space, true);
    ask(space, false);
  }
  const auto pending = f.delegate->PendingTextures();
  std::vector<std::string> spaces;
  for (const auto& request : pending) {
    spaces.push_back(request.texture.colorSpace);
    EXPECT_EQ(request.texture.isColor, spaces.back() != "raw");
    ASSERT_TRUE(f.delegate->SetTexture(request.key, Texel()).ok());
  }
  EXPECT_EQ(spaces, (std::vector<std::string>{"", "acescg", "raw", "sRGB"}));
  f.Commit();
  EXPECT_EQ(f.renderer->textures.size(), 4u);

  // Users are counted together: the image stays until the last of them is gone.
  const auto gone = [&](size_t from, size_t to) {
    for (size_t i = from; i < to; ++i) f.delegate->DestroySprim(paths[i]);
    f.Commit();
    return f.renderer->textures.size();
  };
  EXPECT_EQ(gone(4, 11), 4u);  // /m11 is left of those that convert nothing
  EXPECT_EQ(gone(11, 12), 3u);
  EXPECT_EQ(gone(0, 4), 2u);
  EXPECT_EQ(gone(12, 16), 0u);
}

// What the core read coarser to fit is asked for again where there is more memory, and drawn as it is until it comes.
TEST(Textures, MoreMemoryAsksAgainForWhatWasReadCoarser) {
  Fixture f;
  f.delegate->Sync("/a", Universal(Network("/a", "surface", 0, "/wood.png")));
  f.delegate->Sync("/b", Universal(Network("/b", "surface", 1, "/iron.png")));
  f.delegate->Sync("/c", Universal(Network("/c", "surface", 2, "/t.<UDIM>.png")));
  ASSERT_TRUE(f.delegate->SetRenderSetting("textureMemory", int64_t{2}).ok());
  for (const auto& request : f.delegate->PendingTextures()) {
    if (request.texture.resolvedPath == "/t.<UDIM>.png")
      ASSERT_TRUE(f.delegate->SetTextureTiles(request.key, {{1001, Texel()}, {1002, Texel()}}).ok());
    else
      ASSERT_TRUE(f.delegate->SetTexture(request.key, Texel()).ok());
  }
  f.Commit();
  const auto idOf = [&](const std::string& path) {
    return std::bit_cast<uint32_t>(f.renderer->MaterialOf(path)->parameters[1].x);
  };
  const uint32_t wood = idOf("/a"), iron = idOf("/b"), set = idOf("/c");
  f.renderer->coarse = {wood, f.renderer->tileSets[set][1].texture};
  f.renderer->coarseBelow = 2 << 20;
  EXPECT_TRUE(f.delegate->PendingTextures().empty());
  ASSERT_TRUE(f.delegate->SetRenderSetting("textureMemory", int64_t{3}).ok());
  auto pending = f.delegate->PendingTextures();
  ASSERT_EQ(pending.size(), 2u);
  EXPECT_EQ(pending[0].texture.resolvedPath, "/t.<UDIM>.png");
  EXPECT_EQ(pending[1].texture.resolvedPath, "/wood.png");
  f.Commit();
  EXPECT_EQ(idOf("/a"), wood);  // nobody answered yet
  ASSERT_TRUE(f.delegate->SetTextureTiles(pending[0].key, {{1001, Texel()}, {1002, Texel()}}).ok());
  ASSERT_TRUE(f.delegate->SetTexture(pending[1].key, Texel()).ok());
  f.renderer->coarse.clear();
  EXPECT_TRUE(f.delegate->PendingTextures().empty());
  f.Commit();
  EXPECT_NE(idOf("/a"), wood);
  EXPECT_EQ(idOf("/b"), iron);
  EXPECT_NE(idOf("/c"), set);
  EXPECT_EQ(f.renderer->textures.size(), 5u);  // two images, two tiles and their set: the coarse ones are gone
}

TEST(Textures, TilesOfAPatternAreOneTexture) {
  Fixture f;
  f.delegate->Sync("/a", Universal(Network("/a", "surface", 0, "/t.<UDIM>.png")));
  delegate::LightUpdate dome;
  dome.params.emplace();
  dome.params->type = "DomeLight";
  dome.params->texture = {"t.<UDIM>.png", "/t.<UDIM>.png", ""};
  f.delegate->Sync("/dome", dome);
  const auto pending = f.delegate->PendingTextures();
  ASSERT_EQ(pending.size(), 1u);
  const uint32_t key = pending[0].key;
  EXPECT_FALSE(f.delegate->SetTextureTiles(key, {}).ok());
  EXPECT_FALSE(f.delegate->SetTextureTiles(key, {{1000, Texel()}}).ok());
  for (int round = 0; round < 2; ++round) {  // the second set replaces the first
    ASSERT_TRUE(f.delegate->SetTextureTiles(key, {{1001, Texel()}, {1012, Texel()}}).ok());
    EXPECT_TRUE(f.delegate->PendingTextures().empty());
    f.Commit();
    EXPECT_EQ(f.renderer->textures.size(), 3u);  // the tiles and the set
    const uint32_t id = std::bit_cast<uint32_t>(f.renderer->MaterialOf("/a")->parameters[1].x);
    ASSERT_TRUE(f.renderer->tileSets.count(id));
    const auto& tiles = f.renderer->tileSets[id];
    ASSERT_EQ(tiles.size(), 2u);
    EXPECT_EQ(tiles[1].udim, 1012u);
    EXPECT_TRUE(f.renderer->textures.count(tiles[1].texture));
  }
  // A light reads no tiles.
  EXPECT_EQ(f.renderer->lights.begin()->second.texture, wavefront::kInvalidId);
  const auto told = f.delegate->diagnostics();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].code, "texture-missing");
  EXPECT_EQ(told[0].location, "/dome");
  f.delegate->DestroySprim("/a");
  f.Commit();
  EXPECT_TRUE(f.renderer->textures.empty());
}

TEST(Textures, MissingImagesLeaveTheFallbackAndSaySo) {
  Fixture f;
  auto unresolved = Network("/a", "surface", 0, "gone.png");
  unresolved.nodes[1].parameters["file"] = materialgen::AssetValue{"gone.png", "", ""};
  f.delegate->Sync("/a", Universal(unresolved));
  f.delegate->Sync("/b", Universal(Network("/b", "surface", 0, "/broken.png")));
  const auto pending = f.delegate->PendingTextures();
  ASSERT_EQ(pending.size(), 1u);
  ASSERT_TRUE(f.delegate->SetTextureMissing(pending[0].key, "it is no image.").ok());
  f.Commit();
  for (const char* path : {"/a", "/b"})
    EXPECT_EQ(std::bit_cast<uint32_t>(f.renderer->MaterialOf(path)->parameters[1].x), 0xffffffffu);
  const auto told = f.delegate->diagnostics();
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0].location, "/a/texture");
  EXPECT_NE(told[0].message.find("gone.png"), std::string::npos);
  EXPECT_EQ(told[1].location, "/b/texture");
  EXPECT_NE(told[1].message.find("it is no image."), std::string::npos);
  EXPECT_FALSE(f.delegate->SetTexture(4711, Texel()).ok());
  wavefront::TextureData wrong = Texel();
  wrong.width = 2;
  EXPECT_FALSE(f.delegate->SetTexture(pending[0].key, wrong).ok());
  // The file is mended later.
  ASSERT_TRUE(f.delegate->SetTexture(pending[0].key, Texel()).ok());
  f.Commit();
  EXPECT_NE(std::bit_cast<uint32_t>(f.renderer->MaterialOf("/b")->parameters[1].x), 0xffffffffu);
}

}  // namespace
