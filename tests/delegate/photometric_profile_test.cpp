// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// IES files: what is read of good ones, and what bad ones say.
#include "delegate/photometric_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "wavefront/base/half.h"

namespace delegate {
namespace {

std::string File(const std::string& counts, const std::string& values, const std::string& tilt = "NONE") {
  return "IESNA:LM-63-2002\r\n[TEST] none\r\nTILT=" + tilt + "\r\n1 -1 2.0 " + counts + " 1 2 0 0 0\r\n1.0 1.0 0\r\n" + values;
}

PhotometricProfile Parsed(const std::string& text) {
  auto result = ParsePhotometricProfile(text);
  EXPECT_TRUE(result.ok()) << result.error().message;
  return result.ok() ? *result : PhotometricProfile{{0}, {0}, {0}};
}

TEST(PhotometricProfile, ReadsAnglesValuesAndTheMultiplier) {
  const PhotometricProfile p = Parsed(File("3 1", "0 45,90\n0\n10 20 0"));
  EXPECT_EQ(p.vertical, (std::vector<float>{0, 45, 90}));
  EXPECT_FLOAT_EQ(p.At(0, 123), 20);
  EXPECT_FLOAT_EQ(p.At(22.5f, -7), 30);
  EXPECT_FLOAT_EQ(p.At(67.5f, 359), 20);
  EXPECT_FLOAT_EQ(p.At(100, 0), 0) << "beyond its angles";
  const std::string tilted = "IESNA91\nTILT=INCLUDE\n1\n2\n0 90\n1 0.5\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1 1\n";
  EXPECT_FLOAT_EQ(Parsed(tilted).At(45, 0), 1);
}

TEST(PhotometricProfile, MirrorsWhatTheFileLeavesOut) {
  const PhotometricProfile quarter = Parsed(File("2 2", "0 90 0 90 1 1 3 3"));
  for (float h : {30.0f, 150.0f, 210.0f, 330.0f, -30.0f, 390.0f}) EXPECT_NEAR(quarter.At(10, h), 2 + 4.0f / 3, 1e-5f) << h;
  const PhotometricProfile half = Parsed(File("2 3", "0 90 0 90 180 1 1 2 2 5 5"));
  EXPECT_FLOAT_EQ(half.At(0, 135), 7);
  EXPECT_FLOAT_EQ(half.At(0, 225), 7);
  const PhotometricProfile front = Parsed(File("2 3", "0 90 90 180 270 1 1 2 2 5 5"));
  EXPECT_FLOAT_EQ(front.At(0, 45), front.At(0, 135));
  EXPECT_FLOAT_EQ(front.At(0, 315), front.At(0, 225));
  const PhotometricProfile whole = Parsed(File("2 5", "0 90 0 90 180 270 360 1 1 2 2 3 3 4 4 1 1"));
  EXPECT_FLOAT_EQ(whole.At(0, 315), 5);
  EXPECT_FLOAT_EQ(whole.At(0, 405), 3);
}

TEST(PhotometricProfile, BadFilesSayWhatIsWrong) {
  const auto error = [](const std::string& text) {
    const auto result = ParsePhotometricProfile(text);
    return result.ok() ? std::string("no error") : result.error().message;
  };
  const auto says = [&](const std::string& text, const char* part) {
    EXPECT_NE(error(text).find(part), std::string::npos) << error(text);
  };
  says("", "TILT");
  says("IESNA91\nTILT=NONE\n1 2 3", "thirteen");
  says(File("2 1", "0 90 0 1"), "before its last");
  says(File("2 1", "0 90 0 1 x"), "before its last");
  says(File("2 1", "0 90 0 1 nan"), "before its last");
  says(File("2 1", "90 0 0 1 1"), "ascend");
  says(File("2 1", "0 90 0 1 -1"), "below zero");
  says(File("0 1", ""), "0 vertical");
  says(File("1e9 1", ""), "vertical");
  says(File("1e30 -1e30", ""), "angles");
  says("IESNA91\nTILT=INCLUDE\n1\n1e20\n", "tilts");
  says("TILT=NONE\n1 -1 1 2 1 2 2 0 0 0\n1 1 0\n0 90\n0\n1 1\n", "type B");
  EXPECT_FALSE(ReadPhotometricProfile("/no/such.ies").ok());
  EXPECT_TRUE(IsPhotometricProfile("/a/b.IES"));
  EXPECT_FALSE(IsPhotometricProfile("ies"));
}

// The emittance is that of a surface without profile, whatever the lamp measures.
TEST(PhotometricProfile, EmitsWhatTheColourSays) {
  auto texture = EmissionTexture(Parsed(File("3 2", "0 30 90 0 90 700 700 0 100 900 0")));
  ASSERT_TRUE(texture.ok());
  const double degree = 3.14159265358979 / 180;
  double flux = 0;
  for (uint32_t y = 0; y < texture->height; ++y) {
    for (uint32_t x = 0; x < texture->width; ++x) {
      uint16_t half = 0;
      std::memcpy(&half, &texture->texels[(size_t(y) * texture->width + x) * 8], 2);
      const double angle = 0.5 * degree * y;
      flux += wavefront::HalfToFloat(half) * std::cos(angle) * std::sin(angle) * 0.5 * degree * 360 * degree / texture->width;
    }
  }
  EXPECT_NEAR(flux, 3.14159265, 2e-3);
  EXPECT_FALSE(EmissionTexture(Parsed(File("2 1", "91 180 0 1 1"))).ok()) << "it shines backwards only";
}

}  // namespace
}  // namespace delegate
