// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Purposes of RenderSettings prims: what is drawn of the host's render tags, and which material bindings count.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pxr/imaging/hd/renderSettingsSchema.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/retainedSceneIndex.h>

#include <filesystem>

#include "delegate/capture/scene_file.h"
#include "plugin/hydra/convert_settings.h"
#include "tests/hydra/host.h"

namespace hydra_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

VtArray<TfToken> Tokens(const std::vector<std::string>& names) { return VtArray<TfToken>(names.begin(), names.end()); }

TEST(Purposes, BecomeRenderTags) {
  const auto tags = [](const std::vector<std::string>& purposes) { return hydra::ToIncludedPurposes(Tokens(purposes)).renderTags; };
  EXPECT_THAT(tags({"render"}), ElementsAre("geometry", "render"));
  EXPECT_THAT(tags({"proxy", "default", "guide"}), ElementsAre("geometry", "guide", "proxy"));
  EXPECT_FALSE(hydra::ToIncludedPurposes(Tokens({"render"})).areFallback);
  EXPECT_TRUE(hydra::ToIncludedPurposes(Tokens({"default", "render"})).areFallback);
  EXPECT_TRUE(hydra::ToIncludedPurposes({}).areFallback);
  EXPECT_THAT(hydra::ToIncludedPurposes(Tokens({"beauty", "render"})).unknown, ElementsAre("beauty"));
}

TEST(Purposes, NarrowTheHostsTags) {
  const auto drawn = [](const std::vector<std::string>& host, const std::vector<std::string>& purposes) {
    return hydra::DrawnTags(host, hydra::ToIncludedPurposes(Tokens(purposes)));
  };
  EXPECT_THAT(drawn({"proxy", "geometry"}, {"default"}), ElementsAre("geometry"));
  EXPECT_THAT(drawn({"proxy", "geometry"}, {"render"}), ElementsAre("geometry"));
  EXPECT_THAT(drawn({"proxy", "geometry"}, {"proxy", "guide"}), ElementsAre("geometry", "proxy"));
  EXPECT_THAT(drawn({"proxy", "geometry"}, {"default", "render"}), ElementsAre("geometry", "proxy")) << "the fallback is no word";
  EXPECT_THAT(drawn({}, {"proxy"}), ElementsAre("geometry", "proxy")) << "a host without tags draws all";
  EXPECT_THAT(drawn({}, {}), IsEmpty());
  EXPECT_THAT(drawn({"guide"}, {"proxy"}), ElementsAre("hidden")) << "none would be all";
}

TEST(Purposes, OfBindingsAreTheFirstThatIsNamed) {
  EXPECT_EQ(hydra::ToBindingPurpose(Tokens({"", "preview", "full"})), TfToken("preview"));
  EXPECT_EQ(hydra::ToBindingPurpose(Tokens({""})), TfToken());
}

struct SettingsPrim {
  std::vector<std::string> included, bindings;
  bool active = true, ofSceneDelegate = false;
};

// A host without a device, with a box per purpose, and a scene index for what hosts keep there.
struct PurposeHost {
  Host host{delegate_test::MakeRealDelegate(2, /*captureOnly=*/true)};
  HdRetainedSceneIndexRefPtr prims = HdRetainedSceneIndex::New();
  delegate_test::Scene scene = delegate_test::EditScript(3).scene();
  std::string file = (std::filesystem::temp_directory_path() / "hdwavefront_purposes.hdwscene").string();

  PurposeHost() {
    host.renderDelegate.param().CaptureTo(file);
    host.renderDelegate.SetRenderSetting(HdRenderSettingsTokens->enableInteractive, VtValue(false));
    host.index->InsertSceneIndex(prims, SdfPath::AbsoluteRootPath(), /*needsPrefixing=*/false);
    delegate_test::ScenePrim box = scene.prims.at("/world/box");
    for (const char* tag : {"geometry", "render", "proxy"}) {
      box.gprim().renderTag = tag;
      scene.prims[std::string("/") + tag] = box;
    }
    for (const auto& [path, prim] : scene.prims) host.sink.Insert(path, prim);
  }
  ~PurposeHost() { std::filesystem::remove(file); }

  void Set(const SettingsPrim& settings) {
    const auto tokens = [](const std::vector<std::string>& names) {
      return HdRetainedTypedSampledDataSource<VtArray<TfToken>>::New(Tokens(names));
    };
    const auto schema = HdRenderSettingsSchema::Builder()
                            .SetActive(HdRetainedTypedSampledDataSource<bool>::New(settings.active))
                            .SetIncludedPurposes(tokens(settings.included))
                            .SetMaterialBindingPurposes(tokens(settings.bindings))
                            .Build();
    const HdDataSourceBaseHandle sceneDelegate =
        settings.ofSceneDelegate ? HdRetainedTypedSampledDataSource<HdSceneDelegate*>::New(&host.scene) : nullptr;
    // A new prim each time: hd/dirtyBitsTranslator.cpp of 25.02 finds no edit of includedPurposes (it looks for it after
    // namespacedSettings, in a sorted list that it walks once).
    prims->RemovePrims({SdfPath("/settings")});
    prims->AddPrims({{SdfPath("/settings"), HdPrimTypeTokens->renderSettings,
                      HdRetainedContainerDataSource::New(HdRenderSettingsSchema::GetSchemaToken(), schema,
                                                         HdSceneIndexEmulationTokens->sceneDelegate, sceneDelegate)}});
  }

  // Paths of the boxes above that are drawn.
  std::vector<std::string> Drawn() {
    host.Execute(scene);
    EXPECT_FALSE(host.renderDelegate.param().HasFailed());
    const auto captured = delegate::ReadSceneFile(file);
    std::vector<std::string> paths;
    if (!captured) ADD_FAILURE() << captured.error().message;
    else
      for (const auto& [id, instance] : captured.value().instances)
        if (std::ranges::count(instance.path, '/') == 1) paths.push_back(instance.path);
    std::ranges::sort(paths);
    return paths;
  }
};

TEST(Purposes, OfTheActivePrimCountInBatch) {
  PurposeHost host;  // whose task has the tags geometry and render
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry", "/render"));
  host.Set({{"default"}, {}});
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry"));
  host.Set({{"proxy"}, {}});
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry")) << "what the host does not hand over cannot be drawn";
  host.Set({{"default", "render"}, {}});
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry", "/render"));
  host.Set({{"default"}, {}});
  host.host.renderDelegate.SetRenderSetting(HdRenderSettingsTokens->enableInteractive, VtValue(true));
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry", "/render")) << "a viewport has a menu for purposes";
  host.host.renderDelegate.SetRenderSetting(HdRenderSettingsTokens->enableInteractive, VtValue(false));
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry"));
  host.Set({{"default"}, {}, /*active=*/false});
  EXPECT_THAT(host.Drawn(), ElementsAre("/geometry", "/render"));
}

TEST(Purposes, OfBindingsChooseTheMaterialWhereTheHostLeavesTheChoice) {
  PurposeHost host;
  host.Drawn();
  const auto purpose = [&] { return host.host.renderDelegate.GetMaterialBindingPurpose(); };
  EXPECT_EQ(purpose(), HdTokens->full);
  host.Set({{}, {"preview", ""}});
  host.Drawn();
  EXPECT_EQ(purpose(), HdTokens->preview);
  host.Set({{}, {"preview", ""}, /*active=*/false});
  host.Drawn();
  EXPECT_EQ(purpose(), HdTokens->full);
  host.Set({{}, {"preview", ""}, true, /*ofSceneDelegate=*/true});
  host.Drawn();
  EXPECT_EQ(purpose(), HdTokens->full) << "a scene delegate has chosen";
  host.Set({{}, {"preview", ""}});
  host.Drawn();
  EXPECT_EQ(purpose(), HdTokens->preview);  // and the index ends with the prim in it
}

}  // namespace
}  // namespace hydra_test
