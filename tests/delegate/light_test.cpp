// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Light conversions against closed forms.
#include "delegate/prims/light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/delegate/fakes.h"

namespace {

using delegate::BlackbodyTemperatureAsRgb;
using delegate::ConvertLight;
using delegate::LightParams;
using delegate::LightSizeFactor;
using delegate_test::Scaling;
constexpr double kPi = std::numbers::pi;

struct Converted {
  std::optional<wavefront::LightData> light;
  std::vector<wavefront::Diagnostic> diagnostics;
};

Converted Convert(const LightParams& params, const wavefront::Matrix4d& transform = {}) {
  Converted result;
  result.light = ConvertLight("/light", params, {{0, transform}},
                              [&](const wavefront::Diagnostic& d) { result.diagnostics.push_back(d); });
  return result;
}

LightParams Light(const char* type) {
  LightParams params;
  params.type = type;
  return params;
}

TEST(Light, RadianceIsIntensityTimesExposureTimesColor) {
  LightParams p = Light("RectLight");
  p.intensity = 3;
  p.exposure = 2;
  p.color = {1, 0.5f, 0.25f};
  const auto light = Convert(p).light;
  ASSERT_TRUE(light);
  EXPECT_FLOAT_EQ(light->radiance.x, 12);
  EXPECT_FLOAT_EQ(light->radiance.y, 6);
  EXPECT_FLOAT_EQ(light->radiance.z, 3);
}

// Values of OpenUSD 26.11's UsdLux.BlackbodyTemperatureAsRgb.
TEST(Light, BlackbodyIsUsdLuxs) {
  const struct {
    float kelvin;
    double r, g, b;
  } cases[] = {{500, 4.3055043, 0.11835831, 0},           {1000, 4.3055043, 0.11835831, 0},
               {1250, 3.688244, 0.30203307, 0},           {1300, 3.5557542, 0.3414378, 0},
               {2000, 2.5205662, 0.64688826, 0.020403985}, {2750, 1.9052743, 0.8111469, 0.20507516},
               {3200, 1.6799053, 0.86596864, 0.32564223}, {5000, 1.2135086, 0.9605443, 0.76214415},
               {5600, 1.132336, 0.97269464, 0.8808064},   {6500, 1.0433334, 0.98362446, 1.0346133},
               {8000, 0.94714785, 0.99180335, 1.236823},  {10000, 0.8718413, 0.9946879, 1.4299959},
               {40000, 0.8718413, 0.9946879, 1.4299959}};
  for (const auto& c : cases) {
    const wavefront::Float3 rgb = BlackbodyTemperatureAsRgb(c.kelvin);
    EXPECT_NEAR(rgb.x, c.r, 3e-6 * c.r) << c.kelvin;
    EXPECT_NEAR(rgb.y, c.g, 3e-6) << c.kelvin;
    EXPECT_NEAR(rgb.z, c.b, 3e-6) << c.kelvin;
  }
  LightParams p = Light("SphereLight");
  p.colorTemperature = 2000;
  EXPECT_FLOAT_EQ(Convert(p).light->radiance.x, 1);  // not enabled
  p.enableColorTemperature = true;
  EXPECT_NEAR(Convert(p).light->radiance.x, 2.5205662, 1e-5);
}

TEST(Light, SizeFactorsAreAreasInTheWorld) {
  LightParams rect = Light("RectLight");
  rect.width = 2;
  rect.height = 3;
  EXPECT_NEAR(LightSizeFactor(rect, Scaling(2, 5, 100)), 60, 1e-12);
  LightParams disk = Light("DiskLight");
  disk.radius = 2;
  EXPECT_NEAR(LightSizeFactor(disk, Scaling(3, 5, 7)), kPi * 4 * 15, 1e-10);
  LightParams sphere = Light("SphereLight");
  sphere.radius = 0.5f;
  EXPECT_NEAR(LightSizeFactor(sphere, Scaling(3, 3, 3)), 4 * kPi * 0.25 * 9, 1e-12);
  LightParams cylinder = Light("CylinderLight");
  cylinder.radius = 0.5f;
  cylinder.length = 4;
  EXPECT_NEAR(LightSizeFactor(cylinder, Scaling(2, 2, 2)), 2 * kPi * 0.5 * 4 * 4, 1e-12);
  EXPECT_NEAR(LightSizeFactor(cylinder, Scaling(5, 2, 2)), 2 * kPi * 0.5 * 4 * 5 * 2, 1e-9);
  EXPECT_EQ(LightSizeFactor(Light("DomeLight"), Scaling(9, 9, 9)), 1);
}

TEST(Light, UnevenlyScaledShapesHaveTheAreaOfEllipsoids) {
  LightParams sphere = Light("SphereLight");
  sphere.radius = 1;
  // Prolate spheroid with semi-axes 1, 1, 2: 2 pi (1 + 2 / e asin e), e^2 = 3/4. Oblate 2, 2, 1 likewise.
  const double e = std::sqrt(0.75);
  EXPECT_NEAR(LightSizeFactor(sphere, Scaling(1, 1, 2)), 2 * kPi * (1 + 2 / e * std::asin(e)), 1e-3);
  EXPECT_NEAR(LightSizeFactor(sphere, Scaling(2, 1, 1)), 2 * kPi * (1 + 2 / e * std::asin(e)), 1e-3);
  const double oblate = 2 * kPi * 4 * (1 + (1 - e * e) / e * std::atanh(e));
  EXPECT_NEAR(LightSizeFactor(sphere, Scaling(2, 2, 1)), oblate, 1e-3);
  // Cylinder whose cross section becomes an ellipse with semi-axes 1 and 2: perimeter 9.688448220547675.
  LightParams cylinder = Light("CylinderLight");
  cylinder.radius = 1;
  EXPECT_NEAR(LightSizeFactor(cylinder, Scaling(1, 1, 2)), 9.688448220547675, 1e-9);
  // A turn changes nothing.
  wavefront::Matrix4d turned = Scaling(1, 1, 2);
  turned.m[0] = {0, 0.6, 0.8, 0};
  turned.m[1] = {0, -0.8, 0.6, 0};
  turned.m[2] = {2, 0, 0, 0};
  EXPECT_NEAR(LightSizeFactor(sphere, turned), 2 * kPi * (1 + 2 / e * std::asin(e)), 1e-3);
}

TEST(Light, NormalizeDividesBySize) {
  LightParams p = Light("RectLight");
  p.intensity = 10;
  p.width = 2;
  p.height = 5;
  p.normalize = true;
  EXPECT_FLOAT_EQ(Convert(p, Scaling(2, 1, 1)).light->radiance.x, 0.5f);
}

// rho E / pi of light-reference.md: 1.925e-5, normalised 0.28648, for rho .18, intensity 5, angle .53.
TEST(Light, DistantIsDividedByItsProjectedSolidAngle) {
  LightParams p = Light("DistantLight");
  p.intensity = 5;
  const double sine = std::sin(0.53 / 2 * kPi / 180);
  EXPECT_NEAR(0.18 * Convert(p).light->radiance.x * sine * sine, 1.925e-5, 1e-8);
  p.normalize = true;
  EXPECT_NEAR(0.18 * Convert(p).light->radiance.x * sine * sine, 0.28648, 1e-5);
  EXPECT_NEAR(Convert(p).light->angle, 0.53 * kPi / 180, 1e-9);
  p.angle = 0;
  EXPECT_FLOAT_EQ(Convert(p).light->radiance.x, 5);
}

TEST(Light, ShapingCountsOnlyWhereApplied) {
  LightParams p = Light("SphereLight");
  EXPECT_GT(Convert(p).light->coneAngle, 3.14);
  p.shaping = delegate::LightShaping();
  p.shaping->coneAngle = 30;
  p.shaping->coneSoftness = 0.25f;
  p.shaping->focus = 2;
  p.shaping->focusTint = {0.1f, 0.2f, 0.3f};
  const auto light = *Convert(p).light;
  EXPECT_NEAR(light.coneAngle, kPi / 6, 1e-6);
  EXPECT_FLOAT_EQ(light.coneSoftness, 0.25f);
  EXPECT_FLOAT_EQ(light.focus, 2);
  EXPECT_FLOAT_EQ(light.focusTint.z, 0.3f);
  p.type = "DistantLight";
  const auto distant = Convert(p);
  EXPECT_GT(distant.light->coneAngle, 3.14);
  EXPECT_EQ(distant.diagnostics.size(), 1u);
}

TEST(Light, DomePoleAxisZTurnsUpToZ) {
  LightParams p = Light("DomeLight");
  p.poleAxis = "Z";
  const auto m = Convert(p).light->transforms[0].value.m;
  // (0, 1, 0) * M = row 1
  EXPECT_DOUBLE_EQ(m[1][2], 1);
  EXPECT_DOUBLE_EQ(m[1][1], 0);
  EXPECT_DOUBLE_EQ(m[2][1], -1);
}

TEST(Light, WhatCannotShineIsSkippedAndSaid) {
  const auto refused = [](const LightParams& p, const wavefront::Matrix4d& m, const char* code) {
    const Converted c = Convert(p, m);
    EXPECT_FALSE(c.light) << code;
    ASSERT_EQ(c.diagnostics.size(), 1u) << code;
    EXPECT_EQ(c.diagnostics[0].code, code);
    EXPECT_EQ(c.diagnostics[0].location, "/light");
  };
  LightParams p = Light("RectLight");
  p.width = 0;
  refused(p, {}, "light-zero-size");
  p = Light("SphereLight");
  p.radius = 0;
  refused(p, {}, "light-zero-size");
  p.treatAsPoint = true;  // without power of its own
  refused(p, {}, "light-zero-size");
  p = Light("RectLight");
  refused(p, Scaling(1, 1, 0), "light-singular-transform");
  refused(p, Scaling(1, std::nan(""), 1), "light-singular-transform");
  p.intensity = std::numeric_limits<float>::infinity();
  refused(p, {}, "light-not-finite");
  p.intensity = 1e30f;
  p.exposure = 100;
  refused(p, {}, "light-not-finite");
  refused(Light("PortalLight"), {}, "light-unknown-type");
}

TEST(Light, PointLightsKeepTheirPower) {
  LightParams p = Light("SphereLight");
  p.radius = 0;
  p.treatAsPoint = p.normalize = true;
  p.intensity = 8;
  const auto light = *Convert(p).light;
  EXPECT_GT(light.radius, 0);
  EXPECT_NEAR(light.radiance.x * 4 * kPi * light.radius * light.radius, 8, 1e-4);
}

TEST(Light, MultipliersOfOneResponseAreReported) {
  LightParams p = Light("RectLight");
  p.diffuse = 0.5f;
  p.specular = 0;
  EXPECT_EQ(Convert(p).diagnostics.size(), 2u);
}

}  // namespace
