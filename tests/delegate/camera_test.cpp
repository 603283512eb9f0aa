// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Camera windows by hand, and against GfCamera's numbers.
#include "delegate/prims/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "delegate/prims/matrix.h"
#include "tests/delegate/fakes.h"

namespace {

using delegate::CameraParams;
using delegate::ConformPolicy;

wavefront::CameraData Convert(const CameraParams& params, double aspect, ConformPolicy policy, int* told = nullptr,
                              const wavefront::Matrix4d& transform = {}) {
  int count = 0;
  auto camera = delegate::ConvertCamera("/camera", params, {{0, transform}}, aspect, policy,
                                        [&](const wavefront::Diagnostic&) { ++count; });
  if (told) *told = count;
  return camera;
}

CameraParams Square() {
  CameraParams p;
  p.horizontalAperture = 20;
  p.verticalAperture = 10;
  p.focalLength = 40;
  return p;
}

void ExpectWindow(const wavefront::CameraData& c, double l, double r, double b, double t) {
  EXPECT_NEAR(c.left, l, 1e-6);
  EXPECT_NEAR(c.right, r, 1e-6);
  EXPECT_NEAR(c.bottom, b, 1e-6);
  EXPECT_NEAR(c.top, t, 1e-6);
}

TEST(Camera, WindowIsApertureOverFocalLength) {
  ExpectWindow(Convert(Square(), 2, ConformPolicy::Fit), -0.25, 0.25, -0.125, 0.125);
}

TEST(Camera, OffsetsShiftTheWindow) {
  CameraParams p = Square();
  p.horizontalApertureOffset = 4;
  p.verticalApertureOffset = -2;
  ExpectWindow(Convert(p, 2, ConformPolicy::Fit), -0.15, 0.35, -0.175, 0.075);
  // Conformed about its own centre.
  ExpectWindow(Convert(p, 1, ConformPolicy::MatchVertically), 0.1 - 0.125, 0.1 + 0.125, -0.175, 0.075);
}

TEST(Camera, PoliciesConformAboutTheCentre) {
  // Window 0.5 x 0.25, aspect 2.
  ExpectWindow(Convert(Square(), 1, ConformPolicy::Fit), -0.25, 0.25, -0.25, 0.25);
  ExpectWindow(Convert(Square(), 4, ConformPolicy::Fit), -0.5, 0.5, -0.125, 0.125);
  ExpectWindow(Convert(Square(), 1, ConformPolicy::Crop), -0.125, 0.125, -0.125, 0.125);
  ExpectWindow(Convert(Square(), 4, ConformPolicy::Crop), -0.25, 0.25, -0.0625, 0.0625);
  ExpectWindow(Convert(Square(), 4, ConformPolicy::MatchHorizontally), -0.25, 0.25, -0.0625, 0.0625);
  ExpectWindow(Convert(Square(), 4, ConformPolicy::MatchVertically), -0.5, 0.5, -0.125, 0.125);
  ExpectWindow(Convert(Square(), 4, ConformPolicy::DontConform), -0.25, 0.25, -0.125, 0.125);
}

TEST(Camera, PolicyNamesOfBothHosts) {
  EXPECT_EQ(delegate::ParseConformPolicy("expandAperture"), ConformPolicy::Fit);
  EXPECT_EQ(delegate::ParseConformPolicy("cropAperture"), ConformPolicy::Crop);
  EXPECT_EQ(delegate::ParseConformPolicy("adjustApertureWidth"), ConformPolicy::MatchVertically);
  EXPECT_EQ(delegate::ParseConformPolicy("adjustApertureHeight"), ConformPolicy::MatchHorizontally);
  EXPECT_EQ(delegate::ParseConformPolicy("adjustPixelAspectRatio"), ConformPolicy::DontConform);
  EXPECT_EQ(delegate::ParseConformPolicy("dontConform"), ConformPolicy::DontConform);
  EXPECT_FALSE(delegate::ParseConformPolicy("stretch"));
}

TEST(Camera, OrthographicApertureIsInTenthsOfASceneUnit) {
  CameraParams p = Square();
  p.projection = "orthographic";
  p.clippingNear = -5;
  const auto camera = Convert(p, 2, ConformPolicy::Fit);
  EXPECT_TRUE(camera.orthographic);
  ExpectWindow(camera, -1, 1, -0.5, 0.5);
  EXPECT_FLOAT_EQ(camera.nearClip, -5);
  p.apertureUnit = 1;  // Hydra's scene units
  ExpectWindow(Convert(p, 2, ConformPolicy::Fit), -10, 10, -5, 5);
}

// As UsdImaging multiplies before Hydra hands a camera over: in double precision 0.2 tenths would be another float.
TEST(Camera, TenthsBecomeSceneUnitsInSinglePrecision) {
  CameraParams p = Square();
  p.projection = "orthographic";
  p.horizontalAperture = p.verticalAperture = 0.2f;
  const auto authored = Convert(p, 1, ConformPolicy::Fit);
  p.horizontalAperture = p.verticalAperture = 0.2f * 0.1f;
  p.apertureUnit = 1;
  const auto scaled = Convert(p, 1, ConformPolicy::Fit);
  EXPECT_EQ(authored.left, scaled.left);
  EXPECT_EQ(authored.top, scaled.top);
  EXPECT_NE(authored.right, 0.01f);  // the case tells the two apart
}

TEST(Camera, WhatMakesNoSenseIsReplacedInTheCamerasUnit) {
  CameraParams p;
  p.horizontalAperture = 0;
  const auto tenths = Convert(p, 1.5, ConformPolicy::Fit);
  p.verticalAperture = 1.52908f;
  p.focalLength = 5;
  p.apertureUnit = 1;
  const auto units = Convert(p, 1.5, ConformPolicy::Fit);
  EXPECT_FLOAT_EQ(tenths.left, units.left);
}

TEST(Camera, LensRadiusIsHalfTheFocalLengthOverFStop) {
  CameraParams p = Square();
  p.fStop = 2;
  p.focusDistance = 7;
  const auto camera = Convert(p, 2, ConformPolicy::Fit);
  EXPECT_FLOAT_EQ(camera.lensRadius, 1);  // 40 mm at cm = 4 units, / (2 * 2)
  EXPECT_FLOAT_EQ(camera.focusDistance, 7);
  p.focusDistance = 0;
  int told = 0;
  EXPECT_EQ(Convert(p, 2, ConformPolicy::Fit, &told).lensRadius, 0);
  EXPECT_EQ(told, 1);
}

TEST(Camera, ExposureIsUsdGeomsLinearScale) {
  CameraParams p;
  p.exposure = 1;
  p.exposureTime = 0.5f;
  p.exposureIso = 400;
  p.exposureFStop = 4;
  p.exposureResponsivity = 8;
  EXPECT_FLOAT_EQ(Convert(p, 1, ConformPolicy::Fit).exposureScale, 2 * 0.5f * 4 * 8 / 16);
  EXPECT_FLOAT_EQ(Convert(CameraParams(), 1, ConformPolicy::Fit).exposureScale, 1);
}

TEST(Camera, NonsenseIsReplacedAndSaid) {
  CameraParams p;
  p.horizontalAperture = 0;
  p.focalLength = std::numeric_limits<float>::quiet_NaN();
  p.clippingFar = -3;
  p.projection = "fisheye";
  int told = 0;
  const auto camera = Convert(p, 1.5, ConformPolicy::Fit, &told, delegate_test::Scaling(1, 0, 1));
  EXPECT_EQ(told, 5);
  EXPECT_TRUE(std::isfinite(camera.left) && camera.right > camera.left && camera.farClip > camera.nearClip);
  EXPECT_DOUBLE_EQ(camera.transforms[0].value.m[1][1], 1);
}

TEST(Camera, MatricesMapTheWindowsCornersToTheCube) {
  CameraParams p = Square();
  p.horizontalApertureOffset = 4;
  p.clippingNear = 2;
  p.clippingFar = 10;
  for (const char* projection : {"perspective", "orthographic"}) {
    p.projection = projection;
    const auto camera = Convert(p, 2, ConformPolicy::Fit, nullptr, delegate_test::Translation(1, 2, 3));
    const auto matrices = delegate::MatricesOf(camera);
    for (double z : {-2.0, -10.0})
      for (int corner = 0; corner < 4; ++corner) {
        const double k = camera.orthographic ? 1 : -z;
        const double x = k * (corner & 1 ? camera.right : camera.left);
        const double y = k * (corner & 2 ? camera.top : camera.bottom);
        const double world[4] = {x + 1, y + 2, z + 3, 1};
        double clip[4] = {0, 0, 0, 0};
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 4; ++i) clip[j] += world[i] * matrices.worldToNdc.m[i][j];
        EXPECT_NEAR(clip[0] / clip[3], corner & 1 ? 1 : -1, 1e-6) << projection;
        EXPECT_NEAR(clip[1] / clip[3], corner & 2 ? 1 : -1, 1e-6);
        EXPECT_NEAR(clip[2] / clip[3], z == -2.0 ? -1 : 1, 1e-6);
      }
  }
}

TEST(Matrix, InverseUndoes) {
  wavefront::Matrix4d m = delegate_test::Scaling(2, -3, 0.5);
  m.m[0] = {0.5, 2, 1, 0};
  m.m[3] = {5, -6, 7, 1};
  const auto product = delegate::Multiply(m, delegate::Inverse(m));
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(product.m[i][j], i == j, 1e-12);
  EXPECT_TRUE(delegate::IsSingular3(delegate_test::Scaling(1, 1, 0)));
  EXPECT_FALSE(delegate::IsSingular3(delegate_test::Scaling(1e-9, 1e-9, 1e-9)));
}

}  // namespace
