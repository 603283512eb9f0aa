// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What an edit of a material compiles, with the real generator: its kernel's key is its topology without lobes of zero
// weight.
#include "tests/delegate/fakes.h"

namespace delegate_test {
namespace {

using delegate::MaterialUpdate;

struct RealGenerator {
  FakeRenderer* renderer;
  std::unique_ptr<delegate::RenderDelegate> delegate;

  RealGenerator() {
    auto fake = std::make_unique<FakeRenderer>();
    renderer = fake.get();
    delegate = std::make_unique<delegate::RenderDelegate>(
        std::move(fake), materialgen::Generator::Create(HDWAVEFRONT_MATERIALX_LIBRARIES, [](const auto&) {}),
        std::make_shared<delegate::DiagnosticLog>(), 2);
    delegate->Sync("/camera", delegate::CameraUpdate{delegate::CameraParams(), std::nullopt});
    delegate::RenderPassUpdate pass;
    pass.camera = "/camera";
    pass.width = pass.height = 16;
    EXPECT_TRUE(delegate->SetRenderPass(pass).ok());
  }
  // Kernels that committing this material asks for.
  uint64_t Compiles(const std::string& path, const std::string& identifier,
                    std::map<std::string, materialgen::Value> values, bool withNoise = false) {
    materialgen::MaterialNetwork network;
    network.path = path;
    network.surfaceNode = path + "/surface";
    network.surfaceOutput = "out";
    network.nodes.push_back({path + "/surface", identifier, std::move(values)});
    if (withNoise) {
      network.nodes.push_back({path + "/noise", "ND_noise3d_float", {}});
      network.connections.push_back({path + "/noise", "out", path + "/surface", "specular_roughness"});
    }
    MaterialUpdate update;
    update.contexts.push_back({"mtlx", network});
    delegate->Sync(path, update);
    const uint64_t before = delegate->counters().kernelsCompiled;
    EXPECT_TRUE(delegate->CommitResources().ok());
    EXPECT_EQ(renderer->kernels.size(), delegate->counters().kernelsCompiled);
    return delegate->counters().kernelsCompiled - before;
  }
  std::string KeyOf(const std::string& path) const {
    const wavefront::MaterialData* data = renderer->MaterialOf(path);
    return data ? data->kernelKey : "";
  }
};

TEST(KernelEdits, ValuesCompileNothingStructureCompilesOne) {
  RealGenerator f;
  const std::string standard = "ND_standard_surface_surfaceshader";
  const std::array<float, 3> red{0.8f, 0.1f, 0.1f}, blue{0.1f, 0.1f, 0.8f};
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}, {"specular_roughness", 0.3f}}), 1u);
  EXPECT_EQ(f.Compiles("/b", standard, {{"base_color", blue}, {"specular_roughness", 0.9f}}), 0u);  // shares it
  EXPECT_EQ(f.KeyOf("/a"), f.KeyOf("/b"));
  // Values, near their ends as well.
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", blue}, {"specular_roughness", 0.01f}}), 0u);
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}, {"specular_roughness", 1.0f}, {"specular_IOR", 1.7f}}), 0u);
  const std::string plain = f.KeyOf("/a");
  // Lobes that slept wake: one kernel each time, and only the first time.
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}, {"coat", 0.5f}}), 1u);
  EXPECT_NE(f.KeyOf("/a"), plain);
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}, {"coat", 0.2f}, {"coat_roughness", 0.4f}}), 0u);
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}}), 0u);
  EXPECT_EQ(f.KeyOf("/a"), plain);
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}, {"coat", 0.7f}}), 0u);
  // The graph: that one kernel.
  EXPECT_EQ(f.Compiles("/a", standard, {{"base_color", red}}, true), 1u);
  EXPECT_EQ(f.KeyOf("/b"), plain);
}

// Many constant UsdPreviewSurface materials: three topologies at most (opaque, cut out, metal), whatever their number.
TEST(KernelEdits, PreviewSurfacesShareByTopology) {
  RealGenerator f;
  for (int i = 0; i < 100; ++i) {
    const float v = 0.1f + 0.008f * static_cast<float>(i);
    f.Compiles("/m" + std::to_string(i), "UsdPreviewSurface",
               {{"diffuseColor", std::array<float, 3>{v, 1 - v, 0.5f}}, {"roughness", v}, {"metallic", i % 2 ? 0.0f : 1.0f}});
  }
  EXPECT_EQ(f.renderer->materials.size(), 100u);
  EXPECT_LE(f.delegate->counters().kernelsCompiled, 2u);
}

}  // namespace
}  // namespace delegate_test
