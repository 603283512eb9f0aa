// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The frame that a host shows reaches the materials that ask for it, and restarts nothing where none does.
#include <gtest/gtest.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/retainedSceneIndex.h>

#include <cmath>

#include "plugin/hydra/host_time.h"
#include "tests/hydra/host.h"

namespace hydra_test {
namespace {

using GlobalValues = std::vector<std::pair<const char*, double>>;

void SetGlobals(const HdRetainedSceneIndexRefPtr& scene, const GlobalValues& values) {
  TfTokenVector names;
  std::vector<HdDataSourceBaseHandle> sources;
  for (const auto& [name, value] : values) {
    names.emplace_back(name);
    sources.push_back(HdRetainedTypedSampledDataSource<double>::New(value));
  }
  scene->AddPrims({{SdfPath::AbsoluteRootPath(), TfToken(),
                    HdRetainedContainerDataSource::New(
                        TfToken("sceneGlobals"),
                        HdRetainedContainerDataSource::New(names.size(), names.data(), sources.data()))}});
}

TEST(HostTime, IsWhatTheSceneGlobalsSay) {
  Host host;
  EXPECT_FALSE(hydra::ReadHostTime(*host.index));
  const auto globals = HdRetainedSceneIndex::New();
  host.index->InsertSceneIndex(globals, SdfPath::AbsoluteRootPath(), /*needsPrefixing=*/false);
  const auto after = [&](const GlobalValues& values) {
    SetGlobals(globals, values);
    return hydra::ReadHostTime(*host.index);
  };
  EXPECT_FALSE(after({{"other", 3}}));
  EXPECT_FALSE(after({{"currentFrame", std::nan("")}}));  // the default time
  EXPECT_EQ(after({{"currentFrame", 12}}), (hydra::HostTime{12, 0.5}));
  EXPECT_EQ(after({{"currentFrame", 12}, {"timeCodesPerSecond", 48}}), (hydra::HostTime{12, 0.25}));
  EXPECT_EQ(after({{"currentFrame", 12}, {"timeCodesPerSecond", 0}}), (hydra::HostTime{12, 0}));
}

TEST(HostTime, BecomesTheSettingsAndRestartsWhatAsksForThem) {
  delegate_test::EditScript script(5);
  Host host;
  const auto globals = HdRetainedSceneIndex::New();
  host.index->InsertSceneIndex(globals, SdfPath::AbsoluteRootPath(), /*needsPrefixing=*/false);
  script.Populate(host.sink);
  host.Execute(script.scene());
  host.Finish();
  const auto& core = host.renderDelegate.param().core();
  const uint64_t version = core.version();
  const auto shown = [&](double frame) {
    SetGlobals(globals, {{"currentFrame", frame}});
    host.Execute(script.scene());
    EXPECT_EQ(host.renderDelegate.GetRenderSetting(TfToken("wavefront:frame")), VtValue(static_cast<float>(frame)));
    EXPECT_EQ(host.renderDelegate.GetRenderSetting(TfToken("wavefront:time")), VtValue(static_cast<float>(frame / 24)));
    return host.Finish();
  };
  shown(48);
  EXPECT_EQ(core.version(), version);
  EXPECT_TRUE(host.task->IsConverged());

  // Worn by the floor from now on: the frame is its colour.
  const std::string path = "/looks/plain", surface = path + "/surface", frame = path + "/frame";
  delegate_test::ScenePrim material = script.scene().prims.at(path);
  materialgen::MaterialNetwork network;
  network.path = path;
  network.surfaceNode = surface;
  network.surfaceOutput = "surface";
  network.nodes = {{surface, "ND_surface_unlit", {}}, {path + "/mix", "ND_mix_color3", {}}, {frame, "ND_frame_float", {}}};
  network.nodes[1].parameters["fg"] = std::array<float, 3>{0.001f, 0.001f, 0.001f};
  network.connections = {{path + "/mix", "out", surface, "emission_color"}, {frame, "out", path + "/mix", "mix"}};
  material.material = {{{"mtlx", network}}};
  host.sink.Change(path, material, delegate_test::kPartNetwork);
  host.Execute(script.scene());
  host.Finish();
  const uint64_t worn = core.version();
  EXPECT_GT(worn, version);
  const wavefront::RawFilm at49 = shown(49);
  EXPECT_GT(core.version(), worn);
  EXPECT_NE(shown(50).sums, at49.sums);
  EXPECT_EQ(shown(49).sums, at49.sums);
}

}  // namespace
}  // namespace hydra_test
