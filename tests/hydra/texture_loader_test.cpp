// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Images through Hio are the texels that the Python host makes of the same file (tests/python/test_textures.py).
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pxr/base/gf/half.h>
#include <pxr/imaging/hio/image.h>
#include <pxr/usd/sdf/layer.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>

#include "plugin/hydra/load_textures.h"
#include "plugin/hydra/texture_loader.h"
#include "tests/delegate/fakes.h"

namespace hydra {
namespace {

// Every byte, in a file that is gone when the test ends.
class BytesFile {
 public:
  BytesFile() {
    std::vector<uint8_t> bytes(256 * 3);
    for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(i / 3);
    HioImage::StorageSpec spec;
    spec.width = 256;
    spec.height = spec.depth = 1;
    spec.format = HioFormatUNorm8Vec3;
    spec.data = bytes.data();
    const auto image = HioImage::OpenForWriting(path());
    written_ = image && image->Write(spec);
  }
  ~BytesFile() { std::filesystem::remove(path()); }
  bool written() const { return written_; }
  std::string path() const { return (std::filesystem::temp_directory_path() / "hdwavefront_ramp.png").string(); }

 private:
  bool written_ = false;
};

// The same formula stands in the Python host's test.
float Linear(int byte, const std::string& space) {
  const double v = byte / 255.0f;
  if (space == "g22_rec709") return static_cast<float>(std::pow(v, 2.2));
  if (space == "g18_rec709") return static_cast<float>(std::pow(v, 1.8));
  const double end = 0.055 / 1.4;
  const double slope = std::pow((end + 0.055) / 1.055, 2.4) / end;
  return static_cast<float>(v <= end ? v * slope : std::pow((v + 0.055) / 1.055, 2.4));
}

TEST(TextureLoader, EveryByteBecomesTheHalfThatThePythonHostMakesOfIt) {
  const BytesFile ramp;
  ASSERT_TRUE(ramp.written());
  for (const std::string space : {"sRGB", "g22_rec709", "g18_rec709"}) {
    delegate::TextureKey key;
    key.resolvedPath = ramp.path();
    key.colorSpace = space;
    key.isColor = true;
    const auto decoded = DecodeTexture(key.resolvedPath);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    auto texture = decoded.value()(key);
    ASSERT_TRUE(texture.ok()) << texture.error().message;
    ASSERT_EQ(texture->format, wavefront::TexelFormat::Rgba16Float);
    ASSERT_EQ(texture->texels.size(), 256u * 8);
    for (int byte = 0; byte < 256; ++byte) {
      uint16_t texel[4];
      std::memcpy(texel, &texture->texels[static_cast<size_t>(byte) * 8], sizeof texel);
      EXPECT_EQ(texel[0], GfHalf(Linear(byte, space)).bits()) << space << " " << byte;
      EXPECT_EQ(texel[2], texel[0]);
      EXPECT_EQ(texel[3], GfHalf(1.0f).bits());
    }
  }
}

// Colour spaces, tiles, plain paths and links: what is asked for in a commit shares the decodes of its files.
TEST(TextureLoader, EachFileIsDecodedOnceForAllThatIsMadeOfIt) {
  const auto root = std::filesystem::temp_directory_path() / "hdwavefront_once";
  std::filesystem::remove_all(root);
  std::filesystem::create_directories(root);
  const BytesFile ramp;
  ASSERT_TRUE(ramp.written());
  for (const char* name : {"t.1001.png", "t.1002.png"}) std::filesystem::copy_file(ramp.path(), root / name);
  std::filesystem::create_symlink(root / "t.1002.png", root / "linked.png");
  delegate_test::Fixture f;
  f.delegate->SetUnconvertedColorSpaces(UnconvertedSpaces());
  int materials = 0;
  const auto ask = [&](const std::string& file, const std::string& space) {
    const std::string path = "/m" + std::to_string(materials++);
    auto network = delegate_test::Network(path, "surface", 0, (root / file).string());
    network.nodes[1].parameters["sourceColorSpace"] = space;
    f.delegate->Sync(path, delegate::MaterialUpdate{{{"", std::move(network)}}});
    return path;
  };
  ask("t.1001.png", "auto");
  const std::string srgb = ask("t.1001.png", "sRGB"), raw = ask("t.1001.png", "raw");
  const std::string tiles = ask("t.<UDIM>.png", "sRGB");
  ask("t.<UDIM>.png", "raw");
  ask("linked.png", "raw");
  std::mutex mutex;
  std::multiset<std::string> decoded;
  const auto load = [&] {
    LoadTextures(
        *f.delegate,
        [&](const std::string& path) {
          std::lock_guard lock(mutex);
          decoded.insert(std::filesystem::canonical(path).filename().string());
          return DecodeTexture(path);
        },
        [](wavefront::Severity, const char*, const std::string&, const std::string& text) { ADD_FAILURE() << text; });
    f.Commit();
  };
  load();
  EXPECT_THAT(decoded, testing::ElementsAre("t.1001.png", "t.1002.png"));
  EXPECT_EQ(f.delegate->counters().imagesDecoded, 2u);
  EXPECT_EQ(f.delegate->counters().texturesUploaded, 8u);
  const auto idOf = [&](const std::string& path) {
    return std::bit_cast<uint32_t>(f.renderer->MaterialOf(path)->parameters[1].x);
  };
  EXPECT_EQ(f.renderer->textures[idOf(raw)].format, wavefront::TexelFormat::Rgba8Unorm);
  EXPECT_EQ(f.renderer->textures[idOf(srgb)].format, wavefront::TexelFormat::Rgba16Float);
  const auto& set = f.renderer->tileSets[idOf(tiles)];
  ASSERT_EQ(set.size(), 2u);
  EXPECT_EQ(f.renderer->textures[set[0].texture].texels, f.renderer->textures[idOf(srgb)].texels);
  EXPECT_FALSE(f.renderer->textures[idOf(srgb)].texels.empty());
  // Nothing is kept: what is asked for later decodes again.
  ask("t.1001.png", "g22_rec709");
  load();
  EXPECT_EQ(decoded.count("t.1001.png"), 2u);
  EXPECT_EQ(decoded.count("t.1002.png"), 1u);
  std::filesystem::remove_all(root);
}

// Scene-index mode hands relative patterns over as they are authored.
TEST(TextureLoader, TilesOfARelativePatternLieBesideALayer) {
  const auto root = std::filesystem::temp_directory_path() / "hdwavefront_tiles";
  std::filesystem::remove_all(root);
  std::vector<SdfLayerRefPtr> layers;
  for (const char* folder : {"shot", "asset", "other"}) {
    std::filesystem::create_directories(root / folder / "maps");
    layers.push_back(SdfLayer::CreateNew((root / folder / "layer.usda").string()));
    ASSERT_TRUE(layers.back());
  }
  const auto anchored = [] { return AnchoredPatterns("./maps/wood.<UDIM>.png"); };
  const auto pattern = [&](const char* folder) { return (root / folder / "maps" / "wood.<UDIM>.png").string(); };
  EXPECT_THAT(anchored(), testing::IsEmpty());
  std::ofstream(root / "asset" / "maps" / "wood.1001.png");
  EXPECT_THAT(anchored(), testing::ElementsAre(pattern("asset")));
  std::ofstream(root / "other" / "maps" / "wood.1002.png");
  EXPECT_THAT(anchored(), testing::ElementsAre(pattern("asset"), pattern("other")));
  layers.erase(layers.begin() + 1);  // a layer that nobody holds
  EXPECT_THAT(anchored(), testing::ElementsAre(pattern("other")));
  layers.clear();
  std::filesystem::remove_all(root);
}

}  // namespace
}  // namespace hydra
