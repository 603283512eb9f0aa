// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The light tree changes noise, never the picture that it converges to: light samples, bounce rays that find lights, and
// events inside of bodies must agree on how probable each light was.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

// The mixed scene, with a row of small lights and a glowing box more, near enough that bounce rays meet them.
void AddManyLights(World& world) {
  world.AddMixedScene();
  LightData light;
  for (int i = 0; i < 12; ++i) {
    light.path = "/row/" + std::to_string(i);
    light.type = i % 2 == 0 ? LightType::Sphere : LightType::Rect;
    light.radius = 0.12f;
    light.width = light.height = 0.3f;
    light.transforms = {{0, Moved(-1.1 + 0.2 * i, -0.9 + 0.15 * (i % 5), i % 2 == 0 ? 0.2 : 0.9)}};
    light.radiance = {3.0f + static_cast<float>(i), 5, 2};
    world.renderer->CreateLight(light);
  }
  const MaterialId lamp = world.Material(MakeMaterial("emissive", {0.2f, 0.2f, 0.2f}, 1, {6, 3, 2}));
  world.Instance("/glow", world.renderer->CreateMesh(Box()), lamp, {Scaled(0.15, 0.1, 0.2, 0.1, 0.6, -1), Scaled(0.1, 0.1, 0.1, -0.3, 0.2, -1.2)});
}

struct Estimate {
  double mean = 0, error = 0;  // of the image's mean, and its standard error from independent renders
};

std::array<Estimate, 3> Of(LightSampling sampling) {
  World world;
  AddManyLights(world);
  world.settings.lightSampling = sampling;
  world.settings.samples = 128;
  world.settings.aovs = {};
  world.camera.transforms = {{0, Moved(0, 0, 3.4)}};
  constexpr int kRenders = 8;
  std::array<std::array<double, kRenders>, 3> means{};
  for (int i = 0; i < kRenders; ++i) {
    world.settings.seed = 100u * static_cast<uint32_t>(sampling) + static_cast<uint32_t>(i);
    const RawFilm film = world.Render();
    for (uint32_t c = 0; c < 3; ++c) means[c][static_cast<std::size_t>(i)] = MeanColor(film, c);
  }
  std::array<Estimate, 3> out;
  for (std::size_t c = 0; c < 3; ++c) {
    for (double m : means[c]) out[c].mean += m / kRenders;
    for (double m : means[c]) out[c].error += (m - out[c].mean) * (m - out[c].mean) / (kRenders * (kRenders - 1));
    out[c].error = std::sqrt(out[c].error);
  }
  return out;
}

TEST(LightSampling, TreeAndPowerConvergeToOnePicture) {
  const auto power = Of(LightSampling::Power), tree = Of(LightSampling::Tree);
  for (std::size_t c = 0; c < 3; ++c) {
    const double error = std::hypot(power[c].error, tree[c].error);
    EXPECT_NEAR(tree[c].mean, power[c].mean, 5 * error) << c;
    EXPECT_LT(error, 0.004 * power[c].mean) << c;  // or the line above says little
  }
}

TEST(LightSampling, TheSettingRebuildsWhatItNeeds) {
  World world;
  AddManyLights(world);
  world.settings.lightSampling = LightSampling::Power;
  const uint64_t power = HashFilm(world.Render());
  world.settings.lightSampling = LightSampling::Tree;
  const uint64_t tree = HashFilm(world.Render());
  EXPECT_NE(power, tree);
  world.settings.lightSampling = LightSampling::Auto;  // 12 + 2 lights and 26 triangles are more than a handful
  EXPECT_EQ(HashFilm(world.Render()), tree);
  world.settings.lightSampling = LightSampling::Power;
  EXPECT_EQ(HashFilm(world.Render()), power);
  world.settings.lightSampling = LightSampling::Tree;
  world.settings.poolSize = 192;
  EXPECT_EQ(HashFilm(world.Render()), tree);
}

// A wall that reflects half, under a sky of 1: bounce rays find the sky, and nothing is picked. Light without shadows is not
// counted by bounce rays, so there it is: by the light's own wish, and by the setting, which may change.
TEST(LightSampling, ASkyOfOneColourIsFoundByBounceRays) {
  World world;
  const MaterialId wall = world.Material(MakeMaterial("lambert", {0.25f, 0.5f, 0.75f}));
  world.Instance("/wall", world.renderer->CreateMesh(Box()), wall, {Scaled(20, 20, 0.1, 0, 0, -2)});
  LightData sky;
  sky.path = "/sky";
  sky.type = LightType::Dome;
  sky.transforms = {{0, Matrix4d{}}};
  const LightId id = world.renderer->CreateLight(sky);
  world.settings.samples = 64;
  const auto mean = [&] { return MeanColor(world.Render(), 1); };
  EXPECT_NEAR(mean(), 0.5, 1e-4);
  EXPECT_EQ(world.renderer->stats().shadowRays, 0u);
  world.settings.shadows = false;
  EXPECT_NEAR(mean(), 0.5, 0.01);
  world.settings.shadows = true;
  EXPECT_NEAR(mean(), 0.5, 1e-4);
  sky.castsShadows = false;
  world.renderer->SetLight(id, sky);
  EXPECT_NEAR(mean(), 0.5, 0.01);
  // Beside another light all picks are that one's.
  sky.castsShadows = true;
  world.renderer->SetLight(id, sky);
  LightData sun;
  sun.path = "/sun";
  sun.type = LightType::Distant;
  sun.angle = 0.01f;
  sun.transforms = {{0, Matrix4d{}}};  // shines along -Z, at the wall
  sun.radiance = {1000, 1000, 1000};
  world.renderer->CreateLight(sun);
  const double solidAngle = 2 * 3.14159265 * (1 - std::cos(0.005));
  EXPECT_NEAR(mean(), 0.5 + 0.5 / 3.14159265 * 1000 * solidAngle, 1e-3);
}

}  // namespace
}  // namespace wavefront
