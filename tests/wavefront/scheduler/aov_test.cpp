// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// AOVs in closed form, pixel by pixel: primvars by name in every rate, the normal in camera space, ids for picking.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

float At(const AovImage& image, uint32_t x, uint32_t y, uint32_t c) {
  return std::bit_cast<float>(image.bits[(static_cast<std::size_t>(y) * image.width + x) * image.components + c]);
}

void AskFor(World& world, const std::vector<std::string>& tokens) {
  auto selection = SelectAovs(tokens);
  ASSERT_TRUE(selection.ok()) << selection.error().message;
  world.settings.aovs = selection.value().aovs;
  world.settings.primvarAovs = selection.value().primvars;
}

// A plane that leans away, and on it primvars that say again what other AOVs of the same first sample say.
TEST(Aovs, PrimvarsAreTheFirstSamplesValues) {
  World world;
  MeshData lean = Quad();
  for (Float3& p : lean.positions) p = {4 * p.x, 4 * p.y, -1 - p.y};
  lean.faceIds = {7, 3};
  PrimvarData depth{"viewDepth", Interpolation::Vertex, 1, {}, {}};
  PrimvarData st{"st", Interpolation::FaceVarying, 2, {0, 0, 1, 0, 1, 1, 0, 1}, {0, 1, 2, 0, 2, 3}};
  PrimvarData perFace{"tint", Interpolation::Uniform, 3, std::vector<float>(24, 0.0f), {}};
  for (std::size_t f : {3, 7})
    for (std::size_t c = 0; c < 3; ++c) perFace.values[3 * f + c] = static_cast<float>(f) + 0.25f * static_cast<float>(c);
  for (const Float3& p : lean.positions) depth.values.push_back(4 - p.z);  // the camera stands at z = 4
  lean.primvars = {depth, st, perFace};
  world.Instance("/lean", world.renderer->CreateMesh(lean), world.Material(MakeMaterial("lambert", {1, 1, 1})), {Matrix4d{}});
  AskFor(world, {"cameraDepth", "elementId", "primvars:viewDepth", "primvars:st", "primvars:nowhere", "primvars:tint"});
  const RawFilm film = world.Render();
  const auto image = [&](const std::string& token) {
    const auto aov = FindAov(token, film.primvarAovs);
    EXPECT_TRUE(aov) << token;
    return ResolveFilm(film, *aov);
  };
  const AovImage z = image("cameraDepth"), element = image("elementId"), again = image("primvars:viewDepth"), uv = image("primvars:st"),
                 nowhere = image("primvars:nowhere"), tint = image("primvars:tint");
  EXPECT_EQ(again.components, 3u);
  std::array<int, 8> seen{};
  for (uint32_t y = 0; y < z.height; ++y) {
    for (uint32_t x = 0; x < z.width; ++x) {
      SCOPED_TRACE("pixel " + std::to_string(x) + ", " + std::to_string(y));
      const float t = At(z, x, y, 0);
      for (uint32_t c = 0; c < 3; ++c) ASSERT_NEAR(At(again, x, y, c), t, 2e-5f * t) << "a float repeats";
      // Where the ray through (x, y) of the image meets the plane, within the pixel.
      const float v = At(uv, x, y, 1), u = At(uv, x, y, 0);
      ASSERT_NEAR(v, ((t - 5) / 1 + 1) / 2, 1e-4f) << "v follows the depth";
      const float screen = (static_cast<float>(x) + 0.5f) / 40.0f * (4.0f / 3) - 2.0f / 3;
      ASSERT_NEAR((u * 2 - 1) * 4, screen * t, 0.52f * (4.0f / 3) / 40 * t);
      ASSERT_EQ(At(uv, x, y, 2), 0.0f);
      const uint32_t face = element.bits[y * z.width + x];
      ASSERT_TRUE(face == 3 || face == 7);
      ++seen[face];
      for (uint32_t c = 0; c < 3; ++c) {
        ASSERT_FLOAT_EQ(At(tint, x, y, c), static_cast<float>(face) + 0.25f * static_cast<float>(c));
        ASSERT_EQ(At(nowhere, x, y, c), 0.0f);
      }
    }
  }
  EXPECT_GT(seen[3], 100);
  EXPECT_GT(seen[7], 100);
}

// What an instancer says counts before the mesh's own, for AOVs as for materials; asking for another name is an edit.
TEST(Aovs, PrimvarsOfInstancesAndAnotherName) {
  World world;
  MeshData quad = Quad();
  quad.primvars = {{"a", Interpolation::Constant, 3, {1, 2, 3}, {}}, {"b", Interpolation::Constant, 3, {4, 5, 6}, {}}};
  InstanceData data;
  data.path = "/quads";
  data.mesh = world.renderer->CreateMesh(quad);
  data.materials = {world.Material(MakeMaterial("lambert", {1, 1, 1}))};
  data.transforms = {{{0, Moved(-1, 0, 0)}}, {{0, Moved(1, 0, 0)}}};
  data.instancePrimvars = {{"a", Interpolation::Instance, 3, {7, 8, 9, 10, 11, 12}, {}}};
  world.renderer->CreateInstances(data);
  AskFor(world, {"primvars:a"});
  RawFilm film = world.Render();
  AovImage a = ResolveFilm(film, Aov::Primvar0);
  for (uint32_t c = 0; c < 3; ++c) {
    EXPECT_EQ(At(a, 15, 15, c), 7.0f + static_cast<float>(c));
    EXPECT_EQ(At(a, 25, 15, c), 10.0f + static_cast<float>(c));
    EXPECT_EQ(At(a, 20, 0, c), 0.0f) << "a miss";
  }
  const uint64_t version = world.renderer->version();
  ASSERT_TRUE(world.Commit().ok());
  EXPECT_EQ(world.renderer->version(), version) << "the same names";
  AskFor(world, {"primvars:b"});
  film = world.Render();
  EXPECT_EQ(At(ResolveFilm(film, Aov::Primvar0), 15, 15, 0), 4.0f);
  auto live = world.renderer->Map(Aov::Primvar0);
  ASSERT_TRUE(live.ok());
  EXPECT_EQ(live.value().bits, ResolveFilm(film, Aov::Primvar0).bits);
}

TEST(Aovs, NeyeIsTheNormalAsTheCameraSeesIt) {
  World world;
  world.Instance("/quad", world.renderer->CreateMesh(Quad()), world.Material(MakeMaterial("lambert", {1, 1, 1})), {Scaled(3, 3, 3)});
  AskFor(world, {"normal", "Neye"});
  // The camera is turned by 30 degrees about +Y, stands at (2, 0, 4) and is scaled: lengths are none of a normal's business.
  const double c = std::sqrt(0.75), s = 0.5;
  Matrix4d turned;
  turned.m = {{{2 * c, 0, 2 * -s, 0}, {0, 2, 0, 0}, {2 * s, 0, 2 * c, 0}, {2, 0, 4, 1}}};
  world.camera.transforms = {{0, turned}};
  const RawFilm film = world.Render();
  const AovImage eye = ResolveFilm(film, Aov::Neye), normal = ResolveFilm(film, Aov::Normal);
  EXPECT_NEAR(At(normal, 20, 15, 2), 1, 1e-6);
  EXPECT_NEAR(At(eye, 20, 15, 0), -s, 1e-6);
  EXPECT_NEAR(At(eye, 20, 15, 1), 0, 1e-6);
  EXPECT_NEAR(At(eye, 20, 15, 2), c, 1e-6);
}

// Picking: what a host numbered comes back where it is seen, also 2^24 - 1, Hydra's largest.
TEST(Aovs, IdsComeBackAsTheHostGaveThem) {
  World world;
  const MeshId quad = world.renderer->CreateMesh(Quad());
  InstanceData data;
  data.mesh = quad;
  data.materials = {world.Material(MakeMaterial("lambert", {1, 1, 1}))};
  data.path = "/a";
  data.transforms = {{{0, Moved(-1, 0, 0)}}};
  data.primId = (1 << 24) - 1;
  data.instanceIds = {-1};
  world.renderer->CreateInstances(data);
  data.path = "/b";
  data.transforms = {{{0, Moved(1, 0, 0)}}};
  data.primId = 5;
  data.instanceIds = {41};
  world.renderer->CreateInstances(data);
  AskFor(world, {"primId", "instanceId", "depth"});
  world.camera.nearClip = 1;
  world.camera.farClip = 9;
  const RawFilm film = world.Render();
  const AovImage prim = ResolveFilm(film, Aov::PrimId), instance = ResolveFilm(film, Aov::InstanceId), depth = ResolveFilm(film, Aov::Depth);
  const auto id = [](const AovImage& image, uint32_t x) { return static_cast<int32_t>(image.bits[15 * 40 + x]); };
  EXPECT_EQ(id(prim, 15), (1 << 24) - 1);
  EXPECT_EQ(id(instance, 15), -1);
  EXPECT_EQ(id(prim, 25), 5);
  EXPECT_EQ(id(instance, 25), 41);
  EXPECT_EQ(static_cast<int32_t>(prim.bits[20]), -1);
  EXPECT_EQ(At(depth, 20, 0, 0), 1.0f);
  EXPECT_NEAR(At(depth, 15, 15, 0), 9.0 * (4 - 1) / (4 * (9 - 1)), 1e-6);
}

TEST(Aovs, TokensAndSlots) {
  const auto chosen = SelectAovs(std::vector<std::string>{"primvars:st", "normal", "primvars:b", "primvars:st", "color"});
  ASSERT_TRUE(chosen.ok());
  EXPECT_EQ(chosen.value().aovs, (std::vector<Aov>{Aov::Primvar0, Aov::Normal, Aov::Primvar1, Aov::Color}));
  EXPECT_EQ(chosen.value().primvars, (std::vector<std::string>{"st", "b"}));
  EXPECT_EQ(FindAov("primvars:b", chosen.value().primvars), Aov::Primvar1);
  EXPECT_FALSE(FindAov("primvars:c", chosen.value().primvars));
  for (const char* wrong : {"primvars:", "primvars:#0x", "beauty", "normals"}) {
    const bool isPrimvar = std::string(wrong) == "primvars:#0x";  // a name like any other
    EXPECT_EQ(SelectAovs(std::vector<std::string>{wrong}).ok(), isPrimvar) << wrong;
  }
  const auto tooMany = SelectAovs(std::vector<std::string>{"primvars:a", "primvars:b", "primvars:c", "primvars:d", "primvars:e"});
  ASSERT_FALSE(tooMany.ok());
  EXPECT_NE(tooMany.error().message.find("primvars:e"), std::string::npos);
  // A name without its AOV, or the other way round, is no render.
  World world;
  world.settings.primvarAovs = {"st"};
  EXPECT_FALSE(world.Commit().ok());
  world.settings.aovs = {Aov::Primvar0, Aov::Primvar1};
  EXPECT_FALSE(world.Commit().ok());
  world.settings.aovs = {Aov::Primvar0};
  EXPECT_TRUE(world.Commit().ok());
}

}  // namespace
}  // namespace wavefront
