// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Stand-ins for what lies below the delegate: a renderer that keeps what it is told and refuses unknown ids, and a
// generator whose kernels are tiny.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "delegate/render_delegate.h"

namespace delegate_test {

class FakeRenderer : public wavefront::Renderer {
 public:
  std::map<uint32_t, wavefront::MeshData> meshes;
  std::map<uint32_t, wavefront::InstanceData> instances;
  std::map<uint32_t, wavefront::LightData> lights;
  std::map<uint32_t, wavefront::TextureData> textures;
  std::map<uint32_t, wavefront::MaterialData> materials;
  std::map<std::string, wavefront::MaterialKernelData> kernels;
  std::optional<wavefront::CameraData> camera;
  std::optional<wavefront::RenderSettings> settings;
  uint32_t defaultMaterial = wavefront::kInvalidId;
  std::set<std::string> failedKernels;
  uint64_t edits = 0;  // calls that change something
  int stops = 0;

  const wavefront::InstanceData& InstancesOf(const std::string& path) const {
    for (const auto& [id, data] : instances)
      if (data.path == path) return data;
    ADD_FAILURE() << "no instances of " << path;
    static const wavefront::InstanceData none;
    return none;
  }
  const wavefront::MaterialData* MaterialOf(const std::string& path) const {
    for (const auto& [id, data] : materials)
      if (data.path == path) return &data;
    return nullptr;
  }

  wavefront::MeshId CreateMesh(wavefront::MeshData m) override { return Add(meshes, std::move(m)); }
  void SetMesh(wavefront::MeshId id, wavefront::MeshData m) override { Set(meshes, id, std::move(m)); }
  void DestroyMesh(wavefront::MeshId id) override {
    Remove(meshes, id);
    for (const auto& [group, data] : instances)
      EXPECT_NE(data.mesh, id) << data.path << " uses a mesh that is destroyed";
  }
  wavefront::InstanceGroupId CreateInstances(wavefront::InstanceData d) override {
    Check(d);
    return Add(instances, std::move(d));
  }
  void SetInstances(wavefront::InstanceGroupId id, wavefront::InstanceData d) override {
    Check(d);
    Set(instances, id, std::move(d));
  }
  void DestroyInstances(wavefront::InstanceGroupId id) override { Remove(instances, id); }
  wavefront::LightId CreateLight(wavefront::LightData d) override { return Add(lights, std::move(d)); }
  void SetLight(wavefront::LightId id, wavefront::LightData d) override { Set(lights, id, std::move(d)); }
  void DestroyLight(wavefront::LightId id) override { Remove(lights, id); }
  wavefront::TextureId CreateTexture(wavefront::TextureData d) override { return Add(textures, std::move(d)); }
  void DestroyTexture(wavefront::TextureId id) override { Remove(textures, id); }
  wavefront::TextureId CreateTextureTiles(std::vector<wavefront::TextureTile> tiles) override {
    const auto id = CreateTexture({"tiles", 1, 1, wavefront::TexelFormat::Rgba8Unorm, std::vector<uint8_t>(4)});
    tileSets[id] = std::move(tiles);
    return id;
  }
  std::map<wavefront::TextureId, std::vector<wavefront::TextureTile>> tileSets;
  std::vector<wavefront::TextureId> CoarseTextures(uint64_t textureMemory) override {
    return textureMemory == 0 || textureMemory > coarseBelow ? coarse : std::vector<wavefront::TextureId>();
  }
  std::vector<wavefront::TextureId> coarse;  // given where there is more memory than `coarseBelow`
  uint64_t coarseBelow = 0;
  void RegisterKernel(wavefront::MaterialKernelData k) override {
    ++edits;
    const wavefront::KernelCode code = k.compile(wavefront::KernelEntry::Surface);
    EXPECT_TRUE(code.spirv.empty() != code.error.empty());
    if (code.spirv.empty()) failedKernels.insert(k.key);
    EXPECT_TRUE(kernels.emplace(k.key, k).second) << "kernel registered twice";
  }
  void SetMegakernelLinker(wavefront::MegakernelLinker linker) override { megakernelLinker = std::move(linker); }
  wavefront::MegakernelLinker megakernelLinker;
  bool HasKernel(const std::string& key) const override { return kernels.count(key) > 0; }
  wavefront::MaterialId CreateMaterial(wavefront::MaterialData d) override {
    EXPECT_TRUE(HasKernel(d.kernelKey));
    return Add(materials, std::move(d));
  }
  void SetMaterial(wavefront::MaterialId id, wavefront::MaterialData d) override {
    EXPECT_TRUE(HasKernel(d.kernelKey));
    Set(materials, id, std::move(d));
  }
  void DestroyMaterial(wavefront::MaterialId id) override {
    Remove(materials, id);
    for (const auto& [group, data] : instances)
      for (uint32_t bound : data.materials) EXPECT_NE(bound, id) << data.path << " wears a material that is destroyed";
  }
  void SetDefaultMaterial(wavefront::MaterialId id) override {
    EXPECT_TRUE(materials.count(id));
    defaultMaterial = id;
  }
  void SetCamera(const wavefront::CameraData& c) override {
    ++edits;
    camera = c;
  }
  void SetRenderSettings(const wavefront::RenderSettings& s) override {
    ++edits;
    settings = s;
  }
  wavefront::Status Commit() override {
    if (edits != committed_) ++version_;
    committed_ = edits;
    return {};
  }
  uint64_t version() const override { return version_; }
  wavefront::Status Start() override { return {}; }
  void Pause() override {}
  void Resume() override {}
  void Stop() override { ++stops; }
  bool WaitUntilDone(double) override { return true; }
  wavefront::Status status() const override { return {}; }
  wavefront::Progress progress() const override { return {}; }
  bool IsConverged() const override { return true; }
  wavefront::Result<wavefront::AovImage> Map(wavefront::Aov) override { return wavefront::Error{"no image"}; }
  wavefront::Result<std::vector<wavefront::AovImage>> Map(std::span<const wavefront::Aov>) override {
    return wavefront::Error{"no image"};
  }
  wavefront::Result<wavefront::RawFilm> ReadFilm() override { return wavefront::Error{"no film"}; }
  wavefront::RenderStats stats() const override { return {}; }
  wavefront::Status RunColorKernel(std::span<const uint32_t> spirv, const std::vector<ColorLut>& luts,
                                   std::span<float>, uint32_t, uint32_t) override {
    colorKernelWords = spirv.size();
    colorLuts = luts;
    return {};
  }
  size_t colorKernelWords = 0;
  std::vector<ColorLut> colorLuts;

 private:
  template <typename T>
  uint32_t Add(std::map<uint32_t, T>& all, T value) {
    ++edits;
    all.emplace(next_, std::move(value));
    return next_++;
  }
  template <typename T>
  void Set(std::map<uint32_t, T>& all, uint32_t id, T value) {
    ++edits;
    ASSERT_TRUE(all.count(id)) << "unknown id " << id;
    all[id] = std::move(value);
  }
  template <typename T>
  void Remove(std::map<uint32_t, T>& all, uint32_t id) {
    ++edits;
    EXPECT_EQ(all.erase(id), 1u) << "unknown id " << id;
  }
  void Check(const wavefront::InstanceData& d) {
    EXPECT_TRUE(meshes.count(d.mesh)) << d.path;
    EXPECT_EQ(d.instanceIds.size(), d.transforms.size());
    EXPECT_FALSE(d.transforms.empty());
    for (uint32_t id : d.materials) EXPECT_TRUE(id == wavefront::kInvalidId || materials.count(id)) << d.path;
  }
  uint32_t next_ = 1;
  uint64_t version_ = 0, committed_ = 0;
};

// One kernel for each surface identifier; parameters: "value" of the surface node, and one texel per "file".
// Identifiers that begin with "unknown" are not supported; those that begin with "frame" ask for the frame.
class FakeGenerator : public materialgen::Generator {
 public:
  bool Supports(const materialgen::MaterialNetwork& network, std::string* unsupported) const override {
    for (const materialgen::Node& node : network.nodes)
      if (node.identifier.starts_with("unknown")) {
        *unsupported = node.path;
        return false;
      }
    return true;
  }
  materialgen::CompiledMaterial Generate(const materialgen::MaterialNetwork& network,
                                         const materialgen::MessageSink&, const materialgen::GenerateOptions&) override {
    materialgen::CompiledMaterial material;
    for (const materialgen::Node& node : network.nodes) {
      if (node.path == network.surfaceNode) {
        material.kernel = Kernel(node.identifier);
        float value = 0;
        if (const auto found = node.parameters.find("value"); found != node.parameters.end())
          value = std::get<float>(found->second);
        material.parameters = {value, 0, 0, 0};
      }
    }
    for (const materialgen::Node& node : network.nodes)
      if (const auto found = node.parameters.find("file"); found != node.parameters.end()) {
        materialgen::TextureRequest request;
        request.file = std::get<materialgen::AssetValue>(found->second);
        request.offset = static_cast<uint32_t>(material.parameters.size());
        request.node = node.path;
        if (const auto space = node.parameters.find("sourceColorSpace"); space != node.parameters.end())
          request.sourceColorSpace = std::get<std::string>(space->second);
        material.parameters.insert(material.parameters.end(), {std::bit_cast<float>(0xffffffffu), 0, 0, 0});
        material.textures.push_back(request);
      }
    return material;
  }
  // The node's "value" displaces; 0: nothing does.
  materialgen::CompiledMaterial GenerateDisplacement(const materialgen::MaterialNetwork& network,
                                                     const materialgen::MessageSink&) override {
    materialgen::CompiledMaterial material;
    for (const materialgen::Node& node : network.nodes) {
      const auto found = node.parameters.find("value");
      if (node.path != network.displacementNode || found == node.parameters.end()) continue;
      const float value = std::get<float>(found->second);
      if (value == 0) continue;
      auto source = std::make_shared<materialgen::KernelSource>();
      source->key = "displacement of " + node.identifier;
      source->displacement = "#version 460\nlayout(local_size_x = 1) in;\nvoid main() {}\n";
      material.kernel = source;
      material.parameters = {value, 0, 0, 0};
    }
    return material;
  }
  materialgen::CompiledMaterial GenerateDefault(bool isOpaque) override {
    materialgen::CompiledMaterial material;
    material.kernel = Kernel(isOpaque ? "default" : "default with opacity");
    material.parameters = {1, 1, 1, 1};
    return material;
  }

 private:
  static std::shared_ptr<const materialgen::KernelSource> Kernel(const std::string& key) {
    auto source = std::make_shared<materialgen::KernelSource>();
    source->key = key;
    source->surface = key == "broken" ? "nonsense" : "#version 460\nlayout(local_size_x = 1) in;\nvoid main() {}\n";
    if (key.starts_with("frame")) source->surface += "// frameNumber()\n";
    return source;
  }
};

// A delegate over the fakes, with a camera and a size.
struct Fixture {
  FakeRenderer* renderer;
  std::unique_ptr<delegate::RenderDelegate> delegate;

  Fixture() {
    auto fake = std::make_unique<FakeRenderer>();
    renderer = fake.get();
    delegate = std::make_unique<delegate::RenderDelegate>(std::move(fake), std::make_unique<FakeGenerator>(),
                                                          std::make_shared<delegate::DiagnosticLog>(), 2);
    delegate->Sync("/camera", delegate::CameraUpdate{delegate::CameraParams(), std::nullopt});
    delegate::RenderPassUpdate pass;
    pass.camera = "/camera";
    pass.width = 64;
    pass.height = 48;
    EXPECT_TRUE(delegate->SetRenderPass(pass).ok());
  }
  void Commit() {
    const auto status = delegate->CommitResources();
    EXPECT_TRUE(status.ok()) << status.error().message;
  }
  // Codes of the diagnostics so far.
  std::multiset<std::string> Codes() const {
    std::multiset<std::string> codes;
    for (const auto& d : delegate->diagnostics()) codes.insert(d.code);
    return codes;
  }
};

inline delegate::MeshUpdate Quad() {
  delegate::MeshUpdate update;
  update.topology.emplace();
  update.topology->scheme = "none";
  update.topology->faceVertexCounts = {4};
  update.topology->faceVertexIndices = {0, 1, 2, 3};
  update.points = {{0, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
  return update;
}

inline materialgen::MaterialNetwork Network(const std::string& path, const std::string& identifier, float value = 0,
                                            const std::string& file = "") {
  materialgen::MaterialNetwork network;
  network.path = path;
  network.surfaceNode = path + "/surface";
  network.surfaceOutput = "surface";
  network.nodes.push_back({path + "/surface", identifier, {{"value", value}}});
  if (!file.empty())
    network.nodes.push_back({path + "/texture", "UsdUVTexture", {{"file", materialgen::AssetValue{file, file, ""}}}});
  return network;
}

inline wavefront::Matrix4d Translation(double x, double y, double z) {
  wavefront::Matrix4d m;
  m.m[3] = {x, y, z, 1};
  return m;
}

inline wavefront::Matrix4d Scaling(double x, double y, double z) {
  wavefront::Matrix4d m;
  m.m[0][0] = x;
  m.m[1][1] = y;
  m.m[2][2] = z;
  return m;
}

}  // namespace delegate_test
