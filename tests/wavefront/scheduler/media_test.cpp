// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Bodies that scatter light, and random walks below surfaces, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

// A box [-1, 1]^3 scaled, seen head-on from +Z by parallel rays, under a dome of radiance 1.
struct Body {
  World world;
  explicit Body(MaterialData material, const Matrix4d& transform = Matrix4d{}) {
    world.Dome(1);
    world.Instance("/body", world.renderer->CreateMesh(Box()), world.Material(std::move(material)), {transform});
    world.camera.transforms = {{0, Moved(0, 0, 50)}};
    world.camera.orthographic = true;
    world.camera.left = world.camera.bottom = -0.9f;
    world.camera.right = world.camera.top = 0.9f;
    world.settings.maxBounces = 64;
    world.settings.rouletteBounce = 100;
    world.settings.samples = 64;
  }
};

TEST(Media, WhatOnlyScattersReturnsAllLight) {
  // Chromatic, thick in one channel and thin in another, and scattering forwards: 1 in all.
  Body body(MakeMaterial("glass", {}, 1, {}, {}, {0.3f, 1.5f, 6}, 0.6f));
  const RawFilm film = body.world.Render();
  for (uint32_t c = 0; c < 3; ++c) EXPECT_NEAR(MeanColor(film, c), 1, 0.01) << c;
  EXPECT_EQ(body.world.renderer->stats().errorFlags, 0u);
}

TEST(Media, AbsorptionAloneIsBeerLambert) {
  // The same coefficients once with a scattering channel beside: the channels that do not scatter are exact all the same.
  Body body(MakeMaterial("glass", {}, 1, {}, {0.25f, 0.5f, 0}, {0, 0, 2}));
  const RawFilm film = body.world.Render();
  EXPECT_NEAR(MeanColor(film, 0), std::exp(-0.5), 0.01);
  EXPECT_NEAR(MeanColor(film, 1), std::exp(-1.0), 0.01);
  EXPECT_NEAR(MeanColor(film, 2), 1, 0.01);
}

TEST(Media, WaxHasItsColor) {
  // Much thicker than its mean free path: what diffuse light comes back is the colour, whatever the radius.
  Body body(MakeMaterial("wax", {0.2f, 0.5f, 0.9f}, 1, {0.05f, 0.02f, 0.01f}), Scaled(40, 40, 20, 0, 0, -20));
  const RawFilm film = body.world.Render();
  EXPECT_NEAR(MeanColor(film, 0), 0.2, 0.004);
  EXPECT_NEAR(MeanColor(film, 1), 0.5, 0.006);
  EXPECT_NEAR(MeanColor(film, 2), 0.9, 0.012);
  EXPECT_NEAR(MeanColor(film, 3), 1, 1e-6);
  EXPECT_EQ(body.world.renderer->stats().errorFlags, 0u);
}

// A sheet is no body: what enters a walk there, and what enters glass, can leave through nothing else. It is lost, by the
// roulette or by the last event, but the picture ends, and is a picture.
TEST(Media, OpenSheetsLoseWhatEntersThem) {
  for (const char* kernel : {"wax", "glass"}) {
    World world;
    world.Dome(1);
    const bool isWax = kernel[0] == 'w';
    MaterialData material = isWax ? MakeMaterial("wax", {1, 0.9f, 0}, 1, {0.1f, 1e6f, 0})
                                  : MakeMaterial("glass", {}, 1, {}, {0, 0.1f, 1}, {2, 1, 1e-3f}, -0.9f);
    world.Instance("/sheet", world.renderer->CreateMesh(Quad()), world.Material(std::move(material)), {Scaled(1, 1, 1)});
    world.camera.transforms = {{0, Moved(0.1, 0.1, 5)}};
    world.camera.orthographic = true;
    world.camera.left = world.camera.bottom = -0.3f;
    world.camera.right = world.camera.top = 0.3f;
    world.settings.samples = 8;
    const RawFilm film = world.Render();
    for (uint32_t c = 0; c < 3; ++c) {
      const double mean = MeanColor(film, c);
      EXPECT_TRUE(std::isfinite(mean)) << kernel << c;
      EXPECT_GE(mean, 0) << kernel << c;
      EXPECT_LE(mean, 1.01) << kernel << c;
    }
    EXPECT_NEAR(MeanColor(film, 3), 1, 1e-6);
  }
}

}  // namespace
}  // namespace wavefront
