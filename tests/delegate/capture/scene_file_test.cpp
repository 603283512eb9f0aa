// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scene files: what is written is what is read, and what is damaged is refused by name.
#include "delegate/capture/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "delegate/capture/compare_scenes.h"
#include "delegate/capture/scene_recorder.h"

namespace {

using namespace delegate;
using namespace wavefront;
using testing::HasSubstr;

// One of everything, and no value that a field has by itself.
CapturedScene FullScene() {
  CapturedScene scene;
  scene.info = {"stage.usda", "1.2.3", "hash"};
  scene.kernels = {{"plain", {"st"}, {"surface text", "", "glow"}, {{{0x07230203, 2, 3, 4, 5}, {}, {0x07230203, 7, 8, 9, 10}}}}};
  scene.textures[0] = {"wood.png", 2, 1, TexelFormat::Rgba8Unorm, {1, 2, 3, 4, 5, 6, 7, 8}};
  scene.textures[3] = {"sky.exr", 1, 1, TexelFormat::Rgba16Float, {1, 2, 3, 4, 5, 6, 7, 8}};
  scene.tiles[4] = {{1001, 0}, {1012, 3}};
  scene.materials[5] = {"/m", "plain", {{1, 2, 3, 4}, {5, 6, 7, 8}}, 3, true};
  scene.defaultMaterial = 5;
  auto displacement = std::make_shared<DisplacementData>();
  displacement->kernelKey = "bumps";
  displacement->spirv = std::make_shared<const std::vector<uint32_t>>(std::vector<uint32_t>{0x07230203, 1, 2, 3, 4});
  displacement->primvars = {"st"};
  displacement->parameters = {{9, 8, 7, 6}};
  MeshData mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.faceIds = {0};
  mesh.materialSlots = {0};
  mesh.primvars = {{"st", Interpolation::FaceVarying, 2, {0, 0, 1, 0}, {0, 1, 1}}, {"tint", Interpolation::Constant, 3, {1, 2, 3}, {}}};
  mesh.doubleSided = false;
  mesh.path = "/mesh";
  mesh.displacements = {nullptr, displacement};
  scene.meshes[7] = mesh;
  mesh.path = "/other";
  scene.meshes[9] = mesh;  // shares the displacement
  InstanceData instances;
  instances.path = "/mesh";
  instances.mesh = 9;
  instances.materials = {5, kInvalidId};
  Matrix4d moved;
  moved.m[3][0] = 0.1;
  instances.transforms = {{{0, {}}, {1, moved}}, {{0, moved}}};
  instances.instanceIds = {4, -1};
  instances.instancePrimvars = {{"shade", Interpolation::Instance, 1, {0.25f, 0.5f}, {}}};
  instances.primId = 12;
  instances.visibility = 5;
  instances.categories = 6;
  scene.instances[2] = instances;
  LightData light;
  light.path = "/light";
  light.type = LightType::Dome;
  light.transforms = {{0.5f, moved}};
  light.radiance = {2, 3, 4};
  light.width = 2; light.height = 3; light.radius = 4; light.length = 5; light.angle = 0.5f;
  light.coneAngle = 1; light.coneSoftness = 0.25f; light.focus = 2; light.focusTint = {1, 0, 1};
  light.texture = 3;
  light.visibleToCamera = light.castsShadows = false;
  light.lightLink = 1; light.shadowLink = 2; light.lightGroup = 3;
  scene.lights[0] = light;
  scene.camera.transforms = {{0, moved}};
  scene.camera.orthographic = true;
  scene.camera.left = -3; scene.camera.right = 4; scene.camera.bottom = -5; scene.camera.top = 6;
  scene.camera.nearClip = 1; scene.camera.farClip = 2;
  scene.camera.clipPlanes = {{1, 0, 0, 2}};
  scene.camera.lensRadius = 0.1f; scene.camera.focusDistance = 3; scene.camera.exposureScale = 4;
  scene.camera.shutterOpen = -0.5f; scene.camera.shutterClose = 0.5f;
  RenderSettings& s = scene.settings;
  s.width = 4; s.height = 3; s.firstSample = 2; s.samples = 5; s.maxBounces = 6; s.rouletteBounce = 7; s.maxTransparency = 8; s.seed = 9;
  s.executionMode = ExecutionMode::Megakernel;
  s.poolSize = 10; s.samplesPerBatch = 11; s.bandRows = 12; s.frame = 13; s.time = 14; s.radianceClamp = 15;
  s.cameraVisibleDome = s.shadows = false;
  s.lightSampling = LightSampling::Tree;
  s.interactive = true;
  s.aovs = {Aov::Color, Aov::Depth, Aov::Primvar0};
  s.primvarAovs = {"st"};
  return scene;
}

// Chunks of a file: where their bytes begin, and how many there are.
struct Chunk {
  std::string name;
  std::size_t begin = 0, size = 0;
};
template <typename T>
T At(const std::vector<std::byte>& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}
std::vector<Chunk> Chunks(const std::vector<std::byte>& bytes) {
  std::vector<Chunk> chunks;
  for (std::size_t at = 40; at < bytes.size();) {
    const char* name = reinterpret_cast<const char*>(bytes.data() + at);
    chunks.push_back({std::string(name, strnlen(name, 8)), at + 24, At<uint64_t>(bytes, at + 8)});
    at = chunks.back().begin + chunks.back().size;
  }
  return chunks;
}
// As if the file had been written like this.
void Sign(std::vector<std::byte>& bytes, const Chunk& chunk) {
  const std::span<const std::byte> all(bytes);
  const uint64_t sum = Checksum(all.subspan(chunk.begin, chunk.size), Checksum(all.subspan(chunk.begin - 24, 16)));
  std::memcpy(bytes.data() + chunk.begin - 8, &sum, sizeof sum);
}
void SignHeader(std::vector<std::byte>& bytes) {
  const uint64_t sum = Checksum(std::span<const std::byte>(bytes).first(32));
  std::memcpy(bytes.data() + 32, &sum, sizeof sum);
}

std::string TroubleWith(const std::vector<std::byte>& bytes) {
  const auto scene = DecodeScene(bytes, "scene.file");
  if (scene) return {};
  EXPECT_THAT(scene.error().message, HasSubstr("scene.file"));
  return scene.error().message;
}

TEST(SceneFile, GivesBackWhatWasWritten) {
  const CapturedScene scene = FullScene();
  ASSERT_TRUE(CheckScene(scene).ok()) << CheckScene(scene).error().message;
  const auto bytes = EncodeScene(scene);
  const auto read = DecodeScene(bytes, "scene.file");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(EncodeScene(read.value()), bytes);
  // One field of each kind, since the same mistake in writing and reading would not show above.
  const CapturedScene& s = read.value();
  EXPECT_EQ(s.info.name, "stage.usda");
  EXPECT_EQ(s.kernels.at(0).spirv[2].at(1), 7u);
  EXPECT_EQ(s.tiles.at(4).at(1).texture, 3u);
  EXPECT_EQ(s.textures.at(3).format, TexelFormat::Rgba16Float);
  EXPECT_EQ(s.materials.at(5).parameters.at(1).w, 8);
  EXPECT_EQ(s.meshes.at(7).primvars.at(0).indices, (std::vector<uint32_t>{0, 1, 1}));
  EXPECT_EQ(s.meshes.at(7).displacements.at(0), nullptr);
  EXPECT_EQ(s.meshes.at(7).displacements.at(1), s.meshes.at(9).displacements.at(1)) << "what meshes share stays shared";
  EXPECT_EQ(s.instances.at(2).transforms.at(0).at(1).value.m[3][0], 0.1);
  EXPECT_EQ(s.lights.at(0).castsShadows, false);
  EXPECT_EQ(s.camera.clipPlanes.at(0).w, 2);
  EXPECT_EQ(s.settings.aovs.at(2), Aov::Primvar0);
}

TEST(SceneFile, RefusesEveryCutOffFile) {
  const auto bytes = EncodeScene(FullScene());
  const auto chunks = Chunks(bytes);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_THAT(TroubleWith(cut), testing::Not(testing::IsEmpty())) << length;
    if (length < 40) continue;
    // A file that was never longer: the chunk that is missing or short is named.
    const uint64_t claimed = length;
    std::memcpy(cut.data() + 16, &claimed, sizeof claimed);
    SignHeader(cut);
    std::string wanted;
    for (const Chunk& chunk : chunks)
      if (wanted.empty() && length < chunk.begin + chunk.size) wanted = chunk.name;
    EXPECT_THAT(TroubleWith(cut), HasSubstr("chunk " + wanted)) << length;
  }
}

TEST(SceneFile, RefusesEveryChangedByte) {
  auto bytes = EncodeScene(FullScene());
  const auto chunks = Chunks(bytes);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const std::byte was = bytes[at];
    for (const unsigned change : {0x01u, 0x80u, 0xffu}) {
      bytes[at] = was ^ std::byte(change);
      const std::string trouble = TroubleWith(bytes);
      EXPECT_FALSE(trouble.empty()) << at;
      for (const Chunk& chunk : chunks)
        if (at >= chunk.begin && at < chunk.begin + chunk.size) {
          EXPECT_THAT(trouble, HasSubstr("chunk " + chunk.name)) << at;
        }
    }
    bytes[at] = was;
  }
}

// Nothing but the checks of lengths, choices and indices stands between these and the core.
TEST(SceneFile, SurvivesNonsenseThatIsSigned) {
  const auto good = EncodeScene(FullScene());
  std::size_t refused = 0, tried = 0;
  for (const Chunk& chunk : Chunks(good))
    for (std::size_t at = chunk.begin; at < chunk.begin + chunk.size; ++at)
      for (const unsigned value : {0x00u, 0x01u, 0x7fu, 0xffu}) {
        auto bytes = good;
        if (bytes[at] == std::byte(value)) continue;
        bytes[at] = std::byte(value);
        Sign(bytes, chunk);
        const auto scene = DecodeScene(bytes, "scene.file");
        ++tried;
        if (scene) {
          EXPECT_TRUE(CheckScene(scene.value()).ok());
        } else {
          ++refused;
          EXPECT_THAT(scene.error().message, HasSubstr("chunk "));
        }
      }
  EXPECT_GT(refused, tried / 10);
}

TEST(SceneFile, AsksForNoMoreMemoryThanTheFileCouldFill) {
  const auto good = EncodeScene(FullScene());
  for (const Chunk& chunk : Chunks(good)) {
    if (chunk.name == "CAMERA" || chunk.name == "SETTINGS") continue;  // they begin with no length
    for (const uint64_t length : {uint64_t{1} << 32, std::numeric_limits<uint64_t>::max(), uint64_t{1} << 61}) {
      auto bytes = good;
      std::memcpy(bytes.data() + chunk.begin, &length, sizeof length);
      Sign(bytes, chunk);
      EXPECT_THAT(TroubleWith(bytes), HasSubstr("chunk " + chunk.name + " makes no sense: a length")) << length;
    }
  }
}

TEST(SceneFile, TellsForeignAndOtherVersionsApart) {
  EXPECT_THAT(TroubleWith({}), HasSubstr("no scene"));
  const std::string png = "\x89PNG\r\n and so on, for long enough to be a header of ours";
  std::vector<std::byte> foreign(png.size());
  std::memcpy(foreign.data(), png.data(), png.size());
  EXPECT_THAT(TroubleWith(foreign), HasSubstr("no scene"));
  const auto good = EncodeScene(FullScene());
  auto newer = good;
  newer[8] = std::byte(kSceneFileVersion + 1);
  SignHeader(newer);
  EXPECT_THAT(TroubleWith(newer), HasSubstr("format 2"));
  auto fields = good;
  fields[24] ^= std::byte(1);
  SignHeader(fields);
  EXPECT_THAT(TroubleWith(fields), HasSubstr("Capture the stage again"));
}

TEST(SceneFile, ReadsAndWritesFiles) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "scene_file_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "a.hdwscene").string();
  ASSERT_TRUE(WriteSceneFile(FullScene(), path).ok());
  const auto read = ReadSceneFile(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().materials.at(5).path, "/m");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1) << "nothing is left beside it";
  for (const std::string& bad : {folder.string(), (folder / "no such").string(), (folder / "no" / "folder").string()}) {
    const auto missing = ReadSceneFile(bad);
    ASSERT_FALSE(missing.ok());
    EXPECT_THAT(missing.error().message, HasSubstr(bad));
  }
  const std::string nowhere = (folder / "no" / "a.hdwscene").string();
  const auto status = WriteSceneFile(FullScene(), nowhere);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr(nowhere));
  // Where the last step fails, nothing is left either.
  std::filesystem::create_directories(folder / "taken" / "inside");
  EXPECT_FALSE(WriteSceneFile(FullScene(), (folder / "taken").string()).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2);
  std::filesystem::remove_all(folder);
}

TEST(CheckScene, NamesWhatTheCoreCouldNotBear) {
  const auto trouble = [](const auto& edit) {
    CapturedScene scene = FullScene();
    edit(scene);
    const Status status = CheckScene(scene);
    return status ? std::string() : status.error().message;
  };
  EXPECT_THAT(trouble([](auto& s) { s.meshes.at(7).triangles[0].y = 3; }), HasSubstr("MESHES"));
  EXPECT_THAT(trouble([](auto& s) { s.meshes.at(7).positions[0].x = std::nanf(""); }), HasSubstr("MESHES"));
  EXPECT_THAT(trouble([](auto& s) { s.meshes.at(7).faceIds.push_back(0); }), HasSubstr("MESHES"));
  EXPECT_THAT(trouble([](auto& s) { s.meshes.at(7).primvars[0].indices[0] = 2; }), HasSubstr("MESHES"));
  EXPECT_THAT(trouble([](auto& s) { s.meshes.at(7).primvars[1].values.pop_back(); }), HasSubstr("MESHES"));
  EXPECT_THAT(trouble([](auto& s) { s.instances.at(2).mesh = 8; }), HasSubstr("INSTANCE"));
  EXPECT_THAT(trouble([](auto& s) { s.instances.at(2).materials[0] = 6; }), HasSubstr("INSTANCE"));
  EXPECT_THAT(trouble([](auto& s) { s.instances.at(2).transforms[1].clear(); }), HasSubstr("INSTANCE"));
  EXPECT_THAT(trouble([](auto& s) { s.materials.at(5).kernelKey = "?"; }), HasSubstr("MATERIAL"));
  EXPECT_THAT(trouble([](auto& s) { s.kernels[0].spirv[0][0] = 0; }), HasSubstr("MATERIAL"));
  EXPECT_THAT(trouble([](auto& s) { s.textures.at(0).width = 3; }), HasSubstr("TEXTURES"));
  EXPECT_THAT(trouble([](auto& s) { s.tiles.at(4)[0].texture = 1; }), HasSubstr("TEXTURES"));
  EXPECT_THAT(trouble([](auto& s) { s.lights.at(0).texture = 1; }), HasSubstr("LIGHTS"));
  EXPECT_THAT(trouble([](auto& s) { s.camera.clipPlanes.resize(7); }), HasSubstr("CAMERA"));
  EXPECT_THAT(trouble([](auto& s) { s.settings.aovs.push_back(Aov::Color); }), HasSubstr("SETTINGS"));
}

TEST(SceneRecorder, HoldsWhatSendSceneSays) {
  SceneRecorder recorder;
  CapturedScene scene = FullScene();
  scene.info.glslHash = IncludedGlslHash();  // a displacement of other GLSL would be refused
  ASSERT_TRUE(SendScene(scene, recorder).ok());
  const CapturedScene got = recorder.Scene();
  // Texture ids are kept, gaps included; others are given anew, in order. What no instance wears is left out.
  EXPECT_EQ(got.textures.size(), 2u);
  EXPECT_EQ(got.textures.at(3).name, "sky.exr");
  EXPECT_EQ(got.tiles.at(4).size(), 2u);
  ASSERT_EQ(got.meshes.size(), 1u);
  EXPECT_EQ(got.meshes.begin()->second.path, "/other");
  const InstanceData& instances = got.instances.begin()->second;
  EXPECT_EQ(instances.mesh, got.meshes.begin()->first);
  ASSERT_EQ(got.materials.size(), 1u);
  EXPECT_EQ(instances.materials, (std::vector<MaterialId>{got.materials.begin()->first, kInvalidId}));
  EXPECT_EQ(got.defaultMaterial, got.materials.begin()->first);
  EXPECT_EQ(got.kernels.at(0).primvars, (std::vector<std::string>{"st"}));
  EXPECT_EQ(recorder.Compile("plain", KernelEntry::Surface).spirv, scene.kernels[0].spirv[0]);
  EXPECT_EQ(got.lights.size(), 1u);
  EXPECT_EQ(got.settings.seed, 9u);
  EXPECT_EQ(got.camera.shutterClose, 0.5f);
}

TEST(SceneRecorder, CompilesAnewWhereTheIncludedGlslIsAnother) {
  SceneRecorder recorder;
  CapturedScene scene = FullScene();
  for (auto& [id, mesh] : scene.meshes) mesh.displacements.clear();
  scene.kernels[0].glsl = {"#version 460\nlayout(local_size_x = 1) in;\nvoid main() {}\n", "", ""};
  ASSERT_TRUE(SendScene(scene, recorder).ok());
  const KernelCode code = recorder.Compile("plain", KernelEntry::Surface);
  EXPECT_NE(code.spirv, scene.kernels[0].spirv[0]);
  EXPECT_GT(code.spirv.size(), 20u) << code.error;
  SceneRecorder other;
  const Status refused = SendScene(FullScene(), other);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("/mesh"));
}

TEST(ShrinkTextures, TakesMeansUntilTheyFit) {
  CapturedScene scene;
  scene.textures[0] = {"a", 4, 2, TexelFormat::Rgba8Unorm, std::vector<uint8_t>(32, 10)};
  for (int c = 0; c < 4; ++c) scene.textures[0].texels[static_cast<std::size_t>(c)] = 50;
  scene.textures[1] = {"b", 2, 2, TexelFormat::Rgba16Float, std::vector<uint8_t>(32)};
  const uint16_t one = 0x3c00;
  std::memcpy(scene.textures[1].texels.data(), &one, 2);
  EXPECT_EQ(ShrinkTextures(scene, 2), 1u);
  EXPECT_EQ(scene.textures[0].width, 2u);
  EXPECT_EQ(scene.textures[0].height, 1u);
  EXPECT_THAT(scene.textures[0].texels, testing::ElementsAre(20, 20, 20, 20, 10, 10, 10, 10));
  EXPECT_EQ(ShrinkTextures(scene, 1), 2u);
  scene.textures[2] = {"c", 1, 2, TexelFormat::Rgba16Unorm, {0, 1, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0}};
  scene.textures[3] = {"d", 1, 2, TexelFormat::Rgba32Float, std::vector<uint8_t>(32)};
  EXPECT_EQ(ShrinkTextures(scene, 1), 2u);
  EXPECT_EQ(scene.textures[2].texels, (std::vector<uint8_t>{0, 2, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(scene.textures[3].texels.size(), 16u);
  uint16_t half;
  std::memcpy(&half, scene.textures[1].texels.data(), 2);
  EXPECT_EQ(half, 0x3400) << "a quarter of one";
}

TEST(CompareScenes, NamesEveryFieldThatDiffers) {
  using testing::ElementsAre;
  const std::pair<void (*)(CapturedScene&), const char*> edits[] = {
      {[](CapturedScene& s) { s.settings.samples = 6; }, "settings.samples: 6 against 5"},
      {[](CapturedScene& s) { s.settings.aovs[1] = Aov::Normal; }, "settings.aovs[1]: "},
      {[](CapturedScene& s) { s.camera.top = std::nextafter(6.0f, 7.0f); }, "camera.top: 6.00000048 against 6"},
      {[](CapturedScene& s) { s.camera.transforms[0].value.m[1][0] = -0.0; }, "camera.transforms[0].value: "},
      {[](CapturedScene& s) { s.textures[0].texels[3] = 9; }, "texture wood.png.texels[3]: 9 against 4"},
      {[](CapturedScene& s) { s.materials[5].parameters[1].w = 9; }, "material /m.parameters[1]: (5, 6, 7, 9) against (5, 6, 7, 8)"},
      {[](CapturedScene& s) { s.meshes[9].positions.push_back({}); }, "mesh /mesh.positions: 4 against 3 elements"},
      {[](CapturedScene& s) { s.meshes[9].primvars[1].values = {7, 2, 8}; }, "mesh /mesh.primvars[1].values[0]: 7 against 1; 2 elements differ"},
      {[](CapturedScene& s) { s.meshes[9].displacements[1] = nullptr; }, "mesh /mesh.displacements[1]: in one only"},
      {[](CapturedScene& s) { s.instances[2].transforms[1][0].value.m[3][0] = 0.2; }, "instances /mesh.transforms[1][0].value: "},
      {[](CapturedScene& s) { s.instances[2].materials[1] = 5; }, "materials of /mesh[1]: \"/m\" against \"\""},
      {[](CapturedScene& s) { s.lights[0].focusTint.y = 1; }, "light /light.focusTint: (1, 1, 1) against (1, 0, 1)"},
      {[](CapturedScene& s) { s.lights[0].texture = 0; }, "texture of /light[0]: \"wood.png\" against \"sky.exr\""}};
  for (const auto& [edit, line] : edits) {
    CapturedScene edited = FullScene();
    edit(edited);
    EXPECT_THAT(CompareScenes(edited, FullScene()), ElementsAre(testing::StartsWith(line)));
  }
  CapturedScene without = FullScene();
  without.lights.clear();
  EXPECT_THAT(CompareScenes(FullScene(), without), ElementsAre("light /light: in the first only", "texture of /light: in the first only"));
  EXPECT_THAT(CompareScenes(without, FullScene()), ElementsAre("light /light: in the second only", "texture of /light: in the second only"));
}

TEST(CompareScenes, IdsAreTheOrderOfArrivalAndDoNotCount) {
  CapturedScene other = FullScene();
  const auto renumber = [](auto& all, uint32_t from, uint32_t to) {
    auto node = all.extract(from);
    node.key() = to;
    all.insert(std::move(node));
  };
  renumber(other.meshes, 9, 1);
  renumber(other.instances, 2, 8);
  renumber(other.lights, 0, 4);
  renumber(other.materials, 5, 1);
  renumber(other.textures, 3, 5);
  other.instances[8].mesh = 1;
  other.instances[8].materials[0] = 1;
  other.lights[4].texture = 5;
  EXPECT_THAT(CompareScenes(other, FullScene()), testing::IsEmpty());
}

}  // namespace
