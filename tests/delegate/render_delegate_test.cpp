// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the delegate tells the renderer: only what changed, in order of path, with nothing left dangling.
#include "delegate/render_delegate.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <thread>

#include "tests/delegate/fakes.h"

namespace {

using delegate::MaterialUpdate;
using delegate::MeshUpdate;
using delegate_test::Fixture;
using delegate_test::Network;
using delegate_test::Quad;
using delegate_test::Translation;
using wavefront::kInvalidId;

MaterialUpdate Universal(materialgen::MaterialNetwork network) { return {{{"", std::move(network)}}}; }

delegate::ImplicitUpdate Sphere(double radius) {
  delegate::ImplicitUpdate update;
  update.shape.emplace();
  update.shape->radius = radius;
  return update;
}

TEST(RenderDelegate, EqualValuesMarkNothingDirty) {
  Fixture f;
  const auto populate = [&] {
    MeshUpdate mesh = Quad();
    mesh.transforms = {{0, Translation(1, 2, 3)}};
    mesh.material = "/material";
    mesh.primvars = {{"st", "vertex", 2, {0, 0, 1, 0, 1, 1, 0, std::nanf("")}, {}}};  // a NaN equals itself
    f.delegate->Sync("/mesh", mesh);
    f.delegate->Sync("/sphere", Sphere(1));
    f.delegate->Sync("/material", Universal(Network("/material", "surface", 1)));
    delegate::LightUpdate light;
    light.params = delegate::LightParams();
    light.transforms = {{0, Translation(0, 5, 0)}};
    f.delegate->Sync("/light", light);
    f.delegate->Sync("/camera", delegate::CameraUpdate{delegate::CameraParams(), {{{0, Translation(0, 0, 9)}}}});
    f.Commit();
  };
  populate();
  const uint64_t version = f.delegate->version(), edits = f.renderer->edits;
  EXPECT_EQ(f.renderer->instances.size(), 2u);
  populate();
  EXPECT_EQ(f.renderer->edits, edits);
  EXPECT_EQ(f.delegate->version(), version);
  const auto counters = f.delegate->counters();
  EXPECT_EQ(counters.meshesBuilt, 2u);
  EXPECT_EQ(counters.materialsGenerated, 1u);
  EXPECT_EQ(counters.camerasUploaded, 1u);
}

TEST(RenderDelegate, AnEditDoesOnlyItsOwnWork) {
  Fixture f;
  MeshUpdate mesh = Quad();
  mesh.material = "/material";
  f.delegate->Sync("/mesh", mesh);
  f.delegate->Sync("/material", Universal(Network("/material", "surface", 1)));
  f.Commit();
  const auto before = f.delegate->counters();

  MeshUpdate moved;
  moved.transforms = {{0, Translation(4, 0, 0)}};
  f.delegate->Sync("/mesh", moved);
  f.Commit();
  auto after = f.delegate->counters();
  EXPECT_EQ(after.meshesBuilt, before.meshesBuilt);
  EXPECT_EQ(after.instancesUploaded, before.instancesUploaded + 1);
  EXPECT_EQ(f.renderer->InstancesOf("/mesh").transforms[0][0].value.m[3][0], 4);

  f.delegate->Sync("/material", Universal(Network("/material", "surface", 2)));  // a value
  f.Commit();
  after = f.delegate->counters();
  EXPECT_EQ(after.kernelsCompiled, before.kernelsCompiled);
  EXPECT_EQ(after.materialsUploaded, before.materialsUploaded + 1);
  EXPECT_EQ(after.instancesUploaded, before.instancesUploaded + 1);
  EXPECT_EQ(f.renderer->MaterialOf("/material")->parameters[0].x, 2);

  MeshUpdate deformed;
  deformed.points = {{0, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}};
  f.delegate->Sync("/mesh", deformed);
  f.Commit();
  after = f.delegate->counters();
  EXPECT_EQ(after.meshesBuilt, before.meshesBuilt + 1);
  EXPECT_EQ(after.instancesUploaded, before.instancesUploaded + 1);
  EXPECT_EQ(f.renderer->meshes.begin()->second.positions[0].z, 1);

  f.delegate->Sync("/camera", delegate::CameraUpdate{std::nullopt, {{{0, Translation(1, 1, 1)}}}});
  f.Commit();
  EXPECT_EQ(f.delegate->counters().camerasUploaded, before.camerasUploaded + 1);
  EXPECT_EQ(f.delegate->counters().meshesBuilt, after.meshesBuilt);
}

TEST(RenderDelegate, MaterialsOfOneTopologyShareAKernel) {
  Fixture f;
  for (int i = 0; i < 50; ++i) {
    const std::string path = "/m" + std::to_string(i);
    f.delegate->Sync(path, Universal(Network(path, i % 2 ? "odd" : "even", static_cast<float>(i))));
  }
  f.Commit();
  EXPECT_EQ(f.delegate->counters().kernelsCompiled, 2u);  // nobody wears a default
  EXPECT_EQ(f.renderer->materials.size(), 50u);
  ASSERT_EQ(f.delegate->kernelUses().size(), 2u);
}

TEST(RenderDelegate, DefaultsAreMadeWhenWornFirst) {
  Fixture f;
  MeshUpdate mesh = Quad();
  f.delegate->Sync("/plain", mesh);
  f.Commit();
  EXPECT_EQ(f.delegate->counters().kernelsCompiled, 1u);
  ASSERT_NE(f.renderer->defaultMaterial, kInvalidId);
  EXPECT_EQ(f.renderer->InstancesOf("/plain").materials[0], kInvalidId);  // the core's own
  mesh.primvars = {{"displayOpacity", "constant", 1, {0.5f}, {}}};
  f.delegate->Sync("/plain", mesh);
  f.Commit();
  EXPECT_EQ(f.delegate->counters().kernelsCompiled, 2u);
  const uint32_t worn = f.renderer->InstancesOf("/plain").materials[0];
  EXPECT_EQ(f.renderer->materials.at(worn).kernelKey, "default with opacity");
  mesh.primvars = std::vector<delegate::PrimvarInput>();
  f.delegate->Sync("/plain", mesh);
  f.Commit();
  EXPECT_EQ(f.renderer->InstancesOf("/plain").materials[0], kInvalidId);
}

TEST(RenderDelegate, ContextsAreTriedOwnFirstThenMaterialXThenUniversal) {
  Fixture f;
  const auto kernelOf = [&](MaterialUpdate update) {
    f.delegate->Sync("/m", std::move(update));
    f.Commit();
    return f.renderer->MaterialOf("/m")->kernelKey;
  };
  const auto own = Network("/m", "own"), mtlx = Network("/m", "mtlx"), universal = Network("/m", "universal");
  EXPECT_EQ(kernelOf({{{"", universal}, {"mtlx", mtlx}, {"wavefront", own}}}), "own");
  EXPECT_EQ(kernelOf({{{"", universal}, {"mtlx", mtlx}}}), "mtlx");
  EXPECT_EQ(kernelOf({{{"", universal}}}), "universal");
  EXPECT_TRUE(f.delegate->diagnostics().empty());
  EXPECT_EQ(kernelOf({{{"", universal}, {"mtlx", Network("/m", "unknown node")}}}), "universal");
  ASSERT_EQ(f.delegate->diagnostics().size(), 1u);
  EXPECT_EQ(f.delegate->diagnostics()[0].code, "material-context-passed-over");
  EXPECT_EQ(f.delegate->diagnostics()[0].location, "/m/surface");
  // Nothing is supported: the first, whose unknown parts are visible.
  EXPECT_EQ(kernelOf({{{"", Network("/m", "unknown b")}, {"mtlx", Network("/m", "unknown a")}}}), "unknown a");
}

TEST(RenderDelegate, MaterialsThatAreNotThereShowTheDefault) {
  Fixture f;
  MeshUpdate mesh = Quad();
  mesh.topology->subsets = {{"/mesh/a", {0}}, {"/mesh/b", {}}, {"/mesh/c", {}}};
  mesh.material = "/good";
  mesh.subsetMaterials = {"/nowhere", ""};
  f.delegate->Sync("/mesh", mesh);
  f.delegate->Sync("/good", Universal(Network("/good", "surface")));
  f.delegate->Sync("/empty", MaterialUpdate());
  f.delegate->Sync("/broken", Universal(Network("/broken", "broken")));
  f.Commit();
  const auto& bound = f.renderer->InstancesOf("/mesh").materials;
  ASSERT_EQ(bound.size(), 4u);
  EXPECT_NE(bound[0], kInvalidId);
  EXPECT_EQ(bound[1], kInvalidId);  // missing
  EXPECT_EQ(bound[2], bound[0]);    // a subset without a binding wears the mesh's
  EXPECT_EQ(bound[3], bound[0]);
  const auto codes = f.Codes();
  EXPECT_EQ(codes.count("material-missing"), 1u);
  EXPECT_EQ(codes.count("material-no-surface"), 1u);
  EXPECT_NE(f.renderer->MaterialOf("/broken"), nullptr);  // the core finds out, and shows magenta
  EXPECT_EQ(f.renderer->failedKernels, std::set<std::string>{"broken"});

  f.delegate->DestroySprim("/good");
  f.Commit();
  EXPECT_EQ(f.renderer->InstancesOf("/mesh").materials[0], kInvalidId);
  f.delegate->Sync("/good", Universal(Network("/good", "surface")));
  f.Commit();
  EXPECT_NE(f.renderer->InstancesOf("/mesh").materials[0], kInvalidId);
  ASSERT_TRUE(f.delegate->SetRenderSetting("enableSceneMaterials", false).ok());
  f.Commit();
  EXPECT_EQ(f.renderer->InstancesOf("/mesh").materials[0], kInvalidId);
}

TEST(RenderDelegate, VisibilityAndRenderTagsDecideWhatIsDrawn) {
  Fixture f;
  for (const char* tag : {"geometry", "proxy", "render", "guide"}) {
    MeshUpdate mesh = Quad();
    mesh.renderTag = tag;
    f.delegate->Sync(std::string("/") + tag, mesh);
  }
  f.Commit();
  EXPECT_EQ(f.renderer->instances.size(), 2u);  // geometry, render
  EXPECT_EQ(f.delegate->counters().meshesBuilt, 2u);  // what is not drawn is not built
  delegate::RenderPassUpdate pass;
  pass.renderTags = {"geometry", "guide"};
  ASSERT_TRUE(f.delegate->SetRenderPass(pass).ok());
  f.Commit();
  f.renderer->InstancesOf("/guide");
  EXPECT_EQ(f.renderer->instances.size(), 2u);
  MeshUpdate hidden;
  hidden.visible = false;
  f.delegate->Sync("/guide", hidden);
  f.Commit();
  EXPECT_EQ(f.renderer->instances.size(), 1u);
  hidden.visible = true;
  f.delegate->Sync("/guide", hidden);
  f.Commit();
  EXPECT_EQ(f.renderer->instances.size(), 2u);
  pass.renderTags = std::vector<std::string>();  // Hydra: an empty set filters nothing (Blender passes it)
  ASSERT_TRUE(f.delegate->SetRenderPass(pass).ok());
  f.Commit();
  EXPECT_EQ(f.renderer->instances.size(), 4u);
}

TEST(RenderDelegate, InstancesOfAPrototypeShareItsMesh) {
  Fixture f;
  delegate::InstancerUpdate instancer;
  instancer.positions = {{0, {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}}}};
  instancer.protoIndices = {{0, 1, 0}};
  instancer.primvars = {{"displayColor", "instance", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {}},
                        {"own", "constant", 1, {5}, {}}};
  f.delegate->Sync("/points", instancer);
  MeshUpdate mesh = Quad();
  mesh.instancer = "/points";
  mesh.prototype = 0;
  mesh.primvars = {{"own", "constant", 1, {6}, {}}};
  mesh.transforms = {{0, Translation(0, 1, 0)}};
  f.delegate->Sync("/points/proto", mesh);
  f.Commit();
  const auto& data = f.renderer->InstancesOf("/points/proto");
  ASSERT_EQ(data.transforms.size(), 2u);
  EXPECT_EQ(data.instanceIds, (std::vector<int32_t>{0, 2}));
  EXPECT_EQ(data.transforms[1][0].value.m[3], (std::array<double, 4>{3, 1, 0, 1}));
  ASSERT_EQ(data.instancePrimvars.size(), 1u);  // the prim's own wins over the instancer's
  EXPECT_EQ(data.instancePrimvars[0].values, (std::vector<float>{1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(f.renderer->meshes.size(), 1u);

  delegate::InstancerUpdate moved;
  moved.transform = {{0, Translation(0, 0, 7)}};
  f.delegate->Sync("/points", moved);
  f.Commit();
  EXPECT_EQ(f.renderer->InstancesOf("/points/proto").transforms[0][0].value.m[3][2], 7);
  EXPECT_EQ(f.delegate->counters().meshesBuilt, 1u);
  f.delegate->DestroyInstancer("/points");
  f.Commit();
  EXPECT_TRUE(f.renderer->instances.empty());
  EXPECT_EQ(f.Codes().count("instancer-missing"), 1u);
}

TEST(RenderDelegate, LightsAreRepeatedByInstancersAndSwitchedOff) {
  Fixture f;
  delegate::InstancerUpdate instancer;
  instancer.transforms = {{0, {Translation(1, 0, 0), Translation(2, 0, 0)}}};
  f.delegate->Sync("/lamps", instancer);
  delegate::LightUpdate light;
  light.params.emplace();
  light.instancer = "/lamps";
  f.delegate->Sync("/lamps/bulb", light);
  f.Commit();
  ASSERT_EQ(f.renderer->lights.size(), 2u);
  EXPECT_EQ(f.renderer->lights.begin()->second.path, "/lamps/bulb[0]");
  light.visible = false;
  f.delegate->Sync("/lamps/bulb", light);
  f.Commit();
  EXPECT_TRUE(f.renderer->lights.empty());
  light.visible = true;
  f.delegate->Sync("/lamps/bulb", light);
  ASSERT_TRUE(f.delegate->SetRenderSetting("enableSceneLights", false).ok());
  f.Commit();
  EXPECT_TRUE(f.renderer->lights.empty());
  ASSERT_TRUE(f.delegate->SetRenderSetting("enableSceneLights", true).ok());
  f.Commit();
  EXPECT_EQ(f.renderer->lights.size(), 2u);
}

TEST(RenderDelegate, EqualImplicitShapesAreOneMesh) {
  Fixture f;
  for (int i = 0; i < 10; ++i) {
    delegate::ImplicitUpdate sphere = Sphere(i < 9 ? 1 : 2);
    sphere.primvars = {{"displayColor", "constant", 3, {0, 0, static_cast<float>(i)}, {}}};
    f.delegate->Sync("/s" + std::to_string(i), sphere);
  }
  f.delegate->Sync("/bad", Sphere(0));
  f.Commit();
  EXPECT_EQ(f.renderer->meshes.size(), 2u);
  EXPECT_EQ(f.renderer->instances.size(), 10u);
  EXPECT_EQ(f.renderer->InstancesOf("/s4").instancePrimvars[0].values[2], 4);
  EXPECT_EQ(f.delegate->diagnostics().size(), 1u);
  f.delegate->Sync("/s9", Sphere(1));
  f.Commit();
  EXPECT_EQ(f.renderer->meshes.size(), 1u);
  for (int i = 0; i < 10; ++i) f.delegate->DestroyRprim("/s" + std::to_string(i));
  f.Commit();
  EXPECT_TRUE(f.renderer->meshes.empty());
}

TEST(RenderDelegate, ABrokenMeshDrawsNothingAndTheRestGoesOn) {
  Fixture f;
  MeshUpdate broken = Quad();
  broken.topology->faceVertexIndices = {0, 1, 2, 77};
  f.delegate->Sync("/broken", broken);
  f.delegate->Sync("/good", Quad());
  MeshUpdate nowhere = Quad();
  nowhere.transforms = {{0, Translation(std::nan(""), 0, 0)}};
  f.delegate->Sync("/nowhere", nowhere);
  f.Commit();
  EXPECT_EQ(f.renderer->instances.size(), 1u);
  EXPECT_GE(f.delegate->diagnostics().size(), 2u);
  f.delegate->Sync("/broken", Quad());  // mended
  f.Commit();
  EXPECT_EQ(f.renderer->instances.size(), 2u);
}

// Two hosts that sync in different orders, and from several threads, say the same to the core.
TEST(RenderDelegate, ArrivalOrderDoesNotShow) {
  const auto scene = [](Fixture& f, unsigned seed) {
    std::vector<int> order(40);
    for (int i = 0; i < 40; ++i) order[static_cast<size_t>(i)] = i;
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    const auto sync = [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        const int i = order[static_cast<size_t>(k)];
        const std::string name = std::to_string(i);
        MeshUpdate mesh = Quad();
        mesh.transforms = {{0, Translation(i, 0, 0)}};
        mesh.material = "/m" + name;
        mesh.primId = i;
        f.delegate->Sync("/q" + name, mesh);
        f.delegate->Sync("/m" + name, Universal(Network("/m" + name, "surface", static_cast<float>(i))));
      }
    };
    std::thread other(sync, 0, 20);
    sync(20, 40);
    other.join();
    f.Commit();
  };
  Fixture a, b;
  scene(a, 1);
  scene(b, 2);
  ASSERT_EQ(a.renderer->instances.size(), 40u);
  for (auto i = a.renderer->instances.begin(), j = b.renderer->instances.begin(); i != a.renderer->instances.end();
       ++i, ++j) {
    EXPECT_EQ(i->first, j->first);
    EXPECT_EQ(i->second.path, j->second.path);
    EXPECT_EQ(i->second.materials, j->second.materials);
    EXPECT_EQ(i->second.mesh, j->second.mesh);
  }
}

// Random edits end in the same scene as a fresh delegate that is told the last state only.
TEST(RenderDelegate, RandomEditsEqualAFreshScene) {
  std::mt19937 random(11);
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  Fixture f;
  std::map<std::string, MeshUpdate> meshes;
  std::map<std::string, float> materials;
  for (int step = 0; step < 300; ++step) {
    const std::string mesh = "/q" + std::to_string(pick(6)), material = "/m" + std::to_string(pick(4));
    switch (pick(5)) {
      case 0: {
        MeshUpdate update = Quad();
        update.transforms = {{0, Translation(pick(3), 0, 0)}};
        update.material = material;
        update.visible = pick(4) != 0;
        f.delegate->Sync(mesh, update);
        meshes[mesh] = update;
        break;
      }
      case 1:
        f.delegate->DestroyRprim(mesh);
        meshes.erase(mesh);
        break;
      case 2: {
        const auto value = static_cast<float>(pick(3));
        f.delegate->Sync(material, Universal(Network(material, value > 1 ? "other" : "surface", value)));
        materials[material] = value;
        break;
      }
      case 3:
        f.delegate->DestroySprim(material);
        materials.erase(material);
        break;
      default: f.Commit();
    }
  }
  f.Commit();
  Fixture fresh;
  for (const auto& [path, update] : meshes) fresh.delegate->Sync(path, update);
  for (const auto& [path, value] : materials)
    fresh.delegate->Sync(path, Universal(Network(path, value > 1 ? "other" : "surface", value)));
  fresh.Commit();
  const auto describe = [](const delegate_test::FakeRenderer& r) {
    std::map<std::string, std::tuple<double, std::string, float, size_t>> scene;
    for (const auto& [id, data] : r.instances) {
      const uint32_t bound = data.materials[0];
      const auto material = r.materials.find(bound);
      scene[data.path] = {data.transforms[0][0].value.m[3][0],
                          material == r.materials.end() ? "" : material->second.path + material->second.kernelKey,
                          material == r.materials.end() ? 0 : material->second.parameters[0].x,
                          r.meshes.at(data.mesh).triangles.size()};
    }
    return scene;
  };
  EXPECT_EQ(describe(*f.renderer), describe(*fresh.renderer));
  EXPECT_LE(f.renderer->meshes.size(), meshes.size());  // what was hidden stays ready, what was destroyed is gone
  EXPECT_EQ(f.renderer->materials.size(), fresh.renderer->materials.size());
}

TEST(RenderDelegate, WhatCannotBeRenderedIsAnError) {
  Fixture f;
  delegate::RenderPassUpdate pass;
  pass.width = 0;
  EXPECT_FALSE(f.delegate->SetRenderPass(pass).ok());
  pass.width = 70000;
  EXPECT_FALSE(f.delegate->SetRenderPass(pass).ok());
  pass.width.reset();
  pass.pixelAspectRatio = std::nan("");
  EXPECT_FALSE(f.delegate->SetRenderPass(pass).ok());
  pass.pixelAspectRatio.reset();
  pass.camera = "/nowhere";
  ASSERT_TRUE(f.delegate->SetRenderPass(pass).ok());
  const auto status = f.delegate->CommitResources();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("/nowhere"), std::string::npos);
  EXPECT_FALSE(f.delegate->CreateRprim("basisCurves", "/c").ok());
  EXPECT_FALSE(f.delegate->CreateSprim("portalLight", "/p").ok());
  EXPECT_TRUE(f.delegate->CreateSprim("domeLight", "/d").ok());
}

}  // namespace
