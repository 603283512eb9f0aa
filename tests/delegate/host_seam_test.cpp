// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What hosts of Hydra need of the delegate besides prims: whether a Sync changed anything, data windows, and instances
// told by prototype.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "delegate/render_delegate.h"
#include "tests/delegate/fakes.h"

namespace {

using delegate::CameraUpdate;
using delegate::DataWindow;
using delegate::InstancerState;
using delegate::LightUpdate;
using delegate::MeshUpdate;
using delegate_test::Fixture;
using delegate_test::Network;
using delegate_test::Quad;
using delegate_test::Translation;

const wavefront::DiagnosticSink kQuiet = [](const wavefront::Diagnostic&) {};

InstancerState Row(size_t count) {
  InstancerState s;
  s.path = "/row";
  s.positions.emplace_back();
  for (size_t i = 0; i < count; ++i) s.positions[0].value.push_back({static_cast<float>(i), 0, 0});
  return s;
}

TEST(RenderDelegate, SyncTellsWhetherThereIsSomethingToCommit) {
  Fixture f;
  MeshUpdate mesh = Quad();
  mesh.material = "/material";
  LightUpdate light;
  light.params.emplace();
  const delegate::MaterialUpdate material{{{"", Network("/material", "surface", 1)}}};
  delegate::InstancerUpdate instancer;
  instancer.positions = {{0, {{1, 2, 3}}}};
  const CameraUpdate camera{delegate::CameraParams(), {{{0, Translation(0, 0, 9)}}}};
  const auto syncAll = [&] {
    return std::vector<bool>{f.delegate->Sync("/mesh", mesh), f.delegate->Sync("/light", light),
                             f.delegate->Sync("/material", material), f.delegate->Sync("/instancer", instancer),
                             f.delegate->Sync("/camera", camera)};
  };
  EXPECT_THAT(syncAll(), testing::Each(true));
  f.delegate->PendingTextures();
  f.Commit();
  EXPECT_THAT(syncAll(), testing::Each(false));
  light.params->intensity = 2;
  EXPECT_TRUE(f.delegate->Sync("/light", light));
  EXPECT_TRUE(f.delegate->Sync("/light", light));  // not committed yet
  f.delegate->PendingTextures();
  f.Commit();
  EXPECT_FALSE(f.delegate->Sync("/light", light));
}

TEST(CropWindow, KeepsThePartOfTheWindow) {
  wavefront::CameraData camera;
  camera.left = -2;
  camera.right = 2;
  camera.bottom = -1;
  camera.top = 1;
  delegate::CropWindow({0.25, 0.5, 0.5, 1}, camera);
  EXPECT_FLOAT_EQ(camera.left, -1);
  EXPECT_FLOAT_EQ(camera.right, 0);
  EXPECT_FLOAT_EQ(camera.bottom, 0);
  EXPECT_FLOAT_EQ(camera.top, 1);
}

TEST(CropWindow, TheWholeChangesNoBit) {
  wavefront::CameraData camera;
  camera.left = -0.1f;
  camera.right = 0.3f;
  delegate::CropWindow(DataWindow(), camera);
  EXPECT_EQ(camera.left, -0.1f);
  EXPECT_EQ(camera.right, 0.3f);
}

TEST(ComposeInstances, DrawsWhatIsToldByPrototype) {
  InstancerState s = Row(5);
  s.prototypeInstances = {{0, {4, 1}}, {1, {1, 2, 3}}};
  s.protoIndices = {7, 7, 7, 7, 7};  // does not count
  s.invisibleIds = {1};              // neither
  const auto places = [&](int32_t prototype) {
    const auto flat = delegate::ComposeInstances({&s}, {prototype}, 1, kQuiet);
    std::vector<double> xs;
    for (const wavefront::Matrix4d& m : flat.transforms[0].value) xs.push_back(m.m[3][0]);
    return xs;
  };
  EXPECT_THAT(places(0), testing::ElementsAre(1, 4));
  EXPECT_THAT(places(1), testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(delegate::ComposeInstances({&s}, {2}, 1, kQuiet).indices, testing::IsEmpty());
}

TEST(ComposeInstances, IdsCountInTheHostsListOfThePrototypesInstances) {
  InstancerState inner = Row(5), outer = Row(3);
  inner.prototypeInstances = {{0, {4, 1}}, {1, {1, 2, 3}}};
  EXPECT_THAT(delegate::ComposeInstances({&inner}, {0}, 1, kQuiet).indices, testing::ElementsAre(1, 0));
  EXPECT_THAT(delegate::ComposeInstances({&inner}, {1}, 1, kQuiet).indices, testing::ElementsAre(0, 1, 2));
  // Nested: the inner place, plus the inner list's length times the outer place.
  outer.prototypeInstances = {{0, {0, 2}}};
  EXPECT_THAT(delegate::ComposeInstances({&inner, &outer}, {1, 0}, 1, kQuiet).indices,
              testing::ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(ComposeInstances, LeavesOutInstancesThatDoNotExistAndSaysSo) {
  InstancerState s = Row(2);
  s.prototypeInstances = {{0, {-1, 0, 1, 2}}};
  std::vector<std::string> codes;
  const auto flat = delegate::ComposeInstances(
      {&s}, {0}, 1, [&](const wavefront::Diagnostic& d) { codes.push_back(d.code); });
  EXPECT_THAT(flat.indices, testing::ElementsAre(1, 2));
  EXPECT_THAT(codes, testing::ElementsAre("instancer-bad-index"));
}

}  // namespace
