// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// OpenColorIO on the colour AOV: the device's picture against the library's own CPU processor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pxr/usd/sdf/assetPath.h>

#include <bit>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "plugin/hydra/color_output.h"
#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/snapshot.h"
#include "tests/delegate/fakes.h"

#ifdef HDWAVEFRONT_OPENCOLORIO
#include <OpenColorIO/OpenColorIO.h>
namespace ocio = OCIO_NAMESPACE;
#endif

namespace hydra {
namespace {

using testing::HasSubstr;

// Straight colours from black to far above white, on the axes and off them, each with a few alphas.
std::vector<float> StraightColors() {
  std::vector<float> rgba;
  for (const float alpha : {1.0f, 0.25f})
    for (const float r : {0.0f, 0.01f, 0.18f, 1.0f, 20.0f})
      for (const float g : {0.0f, 0.3f, 4.0f})
        for (const float b : {0.0f, 0.05f, 0.9f}) rgba.insert(rgba.end(), {r, g, b, alpha});
  return rgba;
}

wavefront::AovImage Premultiplied(const std::vector<float>& rgba) {
  wavefront::AovImage image{wavefront::Aov::Color, static_cast<uint32_t>(rgba.size() / 4), 1, 4, {}};
  for (size_t i = 0; i < rgba.size(); ++i)
    image.bits.push_back(std::bit_cast<uint32_t>(i % 4 == 3 ? rgba[i] : rgba[i] * rgba[i | 3]));
  return image;
}

std::unique_ptr<wavefront::Renderer> MakeRenderer() {
  auto renderer = wavefront::Renderer::Create({});
  EXPECT_TRUE(renderer) << (renderer ? "" : renderer.error().message);
  return renderer ? std::move(renderer).value() : nullptr;
}

ColorSettings With(const char* config, const char* display = "", const char* view = "",
                   const char* space = "lin_rec709") {
  return {config, display, view, space};
}

TEST(ColorSettings, KeysOfHydraGiveThem) {
  const auto with = [](const char* key, const VtValue& value) { return WithColorSetting(TfToken(key), value, {}); };
  EXPECT_EQ(with("wavefront:ocio", VtValue(std::string("a.ocio")))->config, "a.ocio");
  EXPECT_EQ(with("wavefront:ocio", VtValue(SdfAssetPath("a.ocio", "/b/a.ocio")))->config, "/b/a.ocio");
  EXPECT_EQ(with("wavefront:ocio", VtValue(true))->config, "1");
  for (const VtValue& off : {VtValue(false), VtValue(0), VtValue(std::string("0")), VtValue(std::string())})
    EXPECT_EQ(with("wavefront:ocio", off)->config, "");
  EXPECT_EQ(with("wavefront:ocioView", VtValue(TfToken("Raw")))->view, "Raw");
  EXPECT_EQ(with("wavefront:ocioDisplay", VtValue(TfToken("sRGB")))->display, "sRGB");
  EXPECT_EQ(with("wavefront:renderingColorSpace", VtValue(TfToken()))->renderingSpace, "lin_rec709");
  EXPECT_FALSE(with("ocio", VtValue(true)));  // Hydra's own namespace is not ours
  EXPECT_FALSE(with("wavefront:samples", VtValue(4)));
}

TEST(ColorOutput, IsOffUntilASettingAsksForIt) {
  const auto renderer = MakeRenderer();
  ASSERT_TRUE(renderer);
  ColorOutput output;
  wavefront::AovImage image = Premultiplied(StraightColors());
  const auto linear = image.bits;
  EXPECT_TRUE(output.Apply(*renderer, image).ok());
  EXPECT_FALSE(output.Set({}));
  EXPECT_EQ(image.bits, linear);
}

#ifdef HDWAVEFRONT_OPENCOLORIO

void ExpectLikeTheLibrary(ColorOutput& output, const ocio::ConstProcessorRcPtr& processor) {
  const auto renderer = MakeRenderer();
  ASSERT_TRUE(renderer);
  std::vector<float> expected = StraightColors();
  wavefront::AovImage image = Premultiplied(expected);
  const wavefront::Status applied = output.Apply(*renderer, image);
  ASSERT_TRUE(applied.ok()) << applied.error().message;
  ocio::PackedImageDesc pixels(expected.data(), static_cast<long>(expected.size() / 4), 1, 4);
  processor->getDefaultCPUProcessor()->apply(pixels);
  for (size_t i = 0; i < expected.size(); ++i) {
    const float alpha = std::bit_cast<float>(image.bits[i | 3]);
    EXPECT_NEAR(std::bit_cast<float>(image.bits[i]), i % 4 == 3 ? expected[i] : expected[i] * alpha, 1e-3) << i;
  }
}

TEST(ColorOutput, DisplaysAndViewsAreTheLibrarysOwn) {
  const auto config = ocio::Config::CreateFromFile("ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1");
  const char* display = config->getDefaultDisplay();
  ASSERT_GT(config->getNumViews(display), 1);
  for (int i = 0; i < config->getNumViews(display); ++i) {
    const char* view = config->getView(display, i);
    SCOPED_TRACE(view);
    ColorOutput output;
    EXPECT_TRUE(output.Set(With("cg-config-v1.0.0_aces-v1.3_ocio-v2.1", display, view)));
    const auto transform = ocio::DisplayViewTransform::Create();
    transform->setSrc("lin_rec709");
    transform->setDisplay(display);
    transform->setView(view);
    ExpectLikeTheLibrary(output, config->getProcessor(transform));
  }
}

TEST(ColorOutput, RenderingSpaceHasItsMeaning) {
  const auto config = ocio::Config::CreateFromFile("ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1");
  const auto transform = ocio::DisplayViewTransform::Create();
  transform->setSrc("ACEScg");
  transform->setDisplay(config->getDefaultDisplay());
  transform->setView(config->getDefaultView(config->getDefaultDisplay()));
  ColorOutput output;
  output.Set(With("ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1", "", "", "lin_ap1_scene"));  // USD's name
  ExpectLikeTheLibrary(output, config->getProcessor(transform));
}

TEST(ColorOutput, TheBuiltinConfigurationKnowsSpacesThatAnotherDoesNot) {
  const std::string path = testing::TempDir() + "hdwavefront_color_output.ocio";
  std::ofstream(path) << "ocio_profile_version: 2\n"
                         "roles: {aces_interchange: Reference, scene_linear: Work, default: Work}\n"
                         "displays:\n  Screen:\n    - !<View> {name: Plain, colorspace: Work}\n"
                         "colorspaces:\n  - !<ColorSpace> {name: Reference}\n"
                         "  - !<ColorSpace> {name: Work, to_scene_reference: !<BuiltinTransform> "
                         "{style: ACEScg_to_ACES2065-1}}\n";
  ColorOutput output;
  output.Set(With(path.c_str()));
  const auto builtin = ocio::Config::CreateFromFile("ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1");
  ExpectLikeTheLibrary(output, builtin->getProcessor("lin_rec709", "ACEScg"));
  std::remove(path.c_str());
}

// Has a picture of halves; its device doubles what the colour kernel is given.
class HalvesRenderer : public delegate_test::FakeRenderer {
 public:
  static wavefront::AovImage Halves(wavefront::Aov aov) {
    return {aov, 1, 1, 4, std::vector<uint32_t>(4, std::bit_cast<uint32_t>(0.5f))};
  }
  wavefront::Result<wavefront::AovImage> Map(wavefront::Aov aov) override { return Halves(aov); }
  wavefront::Result<std::vector<wavefront::AovImage>> Map(std::span<const wavefront::Aov> aovs) override {
    std::vector<wavefront::AovImage> images;
    for (const wavefront::Aov aov : aovs) images.push_back(Halves(aov));
    return images;
  }
  wavefront::Status RunColorKernel(std::span<const uint32_t>, const std::vector<ColorLut>&, std::span<float> rgba,
                                   uint32_t, uint32_t) override {
    for (float& value : rgba) value *= 2;
    return {};
  }
};

TEST(ColorOutput, ChangedSettingsShowInAWholePictureAndInColorAlone) {
  delegate::RenderDelegate core(std::make_unique<HalvesRenderer>(), std::make_unique<delegate_test::FakeGenerator>(),
                                std::make_shared<delegate::DiagnosticLog>());
  Snapshot snapshot(core);
  const auto red = [&](wavefront::Aov aov, uint64_t shown) {
    const Snapshot::Picture picture = snapshot.Newer(aov, shown);
    EXPECT_EQ(picture.version, snapshot.version());
    return std::bit_cast<float>(picture.image->bits[0]);
  };
  EXPECT_EQ(red(wavefront::Aov::Color, 0), 0.5f);
  const uint64_t linear = snapshot.version();
  EXPECT_TRUE(snapshot.SetColor(With("default")));
  EXPECT_NE(snapshot.version(), linear);  // by which buffers know that what they hold is old
  EXPECT_EQ(red(wavefront::Aov::Color, 0), 1.0f);  // straight 1, doubled, times its alpha of a half
  EXPECT_EQ(red(wavefront::Aov::Albedo, 0), 0.5f);
  EXPECT_FALSE(snapshot.SetColor(With("default")));
  EXPECT_TRUE(snapshot.SetColor({}));
  EXPECT_EQ(red(wavefront::Aov::Color, 0), 0.5f);
}

TEST(ColorOutput, ErrorsNameTheChoicesOnceAndLeaveThePictureLinear) {
  const auto renderer = MakeRenderer();
  ASSERT_TRUE(renderer);
  const auto expectError = [&](const ColorSettings& settings, const char* text) {
    ColorOutput output;
    wavefront::AovImage image = Premultiplied(StraightColors());
    const auto linear = image.bits;
    output.Set(settings);
    const wavefront::Status first = output.Apply(*renderer, image);
    ASSERT_FALSE(first.ok()) << text;
    EXPECT_THAT(first.error().message, HasSubstr(text));
    EXPECT_TRUE(output.Apply(*renderer, image).ok());
    EXPECT_EQ(image.bits, linear);
  };
  const char* config = "cg-config-v1.0.0_aces-v1.3_ocio-v2.1";
  expectError(With("/nowhere/config.ocio"), "/nowhere/config.ocio (named by a render setting) cannot be read");
  expectError(With(config, "Nowhere"), "It has: sRGB - Display");
  expectError(With(config, "", "Nothing"), "ACES 1.0 - SDR Video");
  expectError(With(config, "", "", "lin_nothing"), "'lin_nothing' is neither");
}

#else

TEST(ColorOutput, SaysThatItWasBuiltWithoutTheLibrary) {
  const auto renderer = MakeRenderer();
  ASSERT_TRUE(renderer);
  ColorOutput output;
  wavefront::AovImage image = Premultiplied(StraightColors());
  output.Set(With("default"));
  const wavefront::Status first = output.Apply(*renderer, image);
  ASSERT_FALSE(first.ok());
  EXPECT_THAT(first.error().message, HasSubstr("built without OpenColorIO"));
  EXPECT_TRUE(output.Apply(*renderer, image).ok());
}

#endif

}  // namespace
}  // namespace hydra
