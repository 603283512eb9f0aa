// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/photometric_profile.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>

#include "wavefront/base/half.h"

namespace delegate {
namespace {

// Files have a few thousand values; beyond these it is no profile.
constexpr size_t kMaxAngles = 10000, kMaxValues = 4'000'000, kMaxBytes = 64u << 20;
// Texels stand at whole and half degrees, where files have their values (pattern.glsl reads them so).
constexpr uint32_t kColumns = 360, kRows = 181;

// Numbers one by one; separated by blanks, line ends or commas.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}

  bool Next(double* value) {
    while (at_ != end_ && (std::strchr(" \t\r\n,", *at_) || *at_ == '\0')) ++at_;
    if (at_ != end_ && *at_ == '+') ++at_;
    const auto [next, error] = std::from_chars(at_, end_, *value);
    if (error != std::errc() || !std::isfinite(*value)) return false;
    at_ = next;
    return true;
  }
  bool Next(std::vector<float>* values, size_t count) {
    values->resize(count);
    for (float& value : *values) {
      double number = 0;
      if (!Next(&number)) return false;
      value = float(number);
    }
    return true;
  }

 private:
  const char *at_, *end_;
};

wavefront::Error Bad(const std::string& what) { return wavefront::Error{"it is no IES profile that can be used: " + what}; }

// The line that begins with TILT=, and what follows it.
bool SplitAtTilt(std::string_view text, std::string_view* tilt, std::string_view* rest) {
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    at = end + 1;
    if (line.substr(0, 5) != "TILT=") continue;
    *tilt = line.substr(5);
    *rest = at < text.size() ? text.substr(at) : std::string_view();
    return true;
  }
  return false;
}

// The place of `x` between ascending `values`: index and fraction. False outside.
bool Locate(const std::vector<float>& values, float x, size_t* index, float* fraction) {
  if (values.empty() || x < values.front() || x > values.back()) return false;
  const size_t after = size_t(std::upper_bound(values.begin(), values.end(), x) - values.begin());
  *index = after == 0 ? 0 : after - 1;
  const float step = after < values.size() ? values[after] - values[*index] : 0;
  *fraction = step > 0 ? (x - values[*index]) / step : 0;
  return true;
}

}  // namespace

float PhotometricProfile::At(float verticalDegrees, float horizontalDegrees) const {
  float h = std::fmod(horizontalDegrees, 360.0f);
  if (h < 0) h += 360;
  const float first = horizontal.front(), last = horizontal.back();
  if (first == 90 && last == 270) {  // the halves mirror each other at the plane of 90 and 270
    if (h < 90) h = 180 - h;
    if (h > 270) h = 540 - h;
  } else if (last <= 180 && horizontal.size() > 1) {
    if (h > 180) h = 360 - h;
    if (last <= 90 && h > 90) h = 180 - h;
  }
  size_t v = 0, row = 0;
  float along = 0, across = 0;
  if (!Locate(vertical, verticalDegrees, &v, &along)) return 0;
  if (horizontal.size() > 1 && !Locate(horizontal, std::clamp(h, first, last), &row, &across)) return 0;
  const auto value = [&](size_t r) {
    const float* c = &candela[r * vertical.size()];
    return c[v] + (c[std::min(v + 1, vertical.size() - 1)] - c[v]) * along;
  };
  const float a = value(row), b = value(std::min(row + 1, horizontal.size() - 1));
  return a + (b - a) * across;
}

bool IsPhotometricProfile(std::string_view path) {
  if (path.size() < 4) return false;
  std::string end(path.substr(path.size() - 4));
  for (char& c : end) c = char(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c);
  return end == ".ies";
}

wavefront::Result<PhotometricProfile> ParsePhotometricProfile(std::string_view text) {
  std::string_view tilt, rest;
  if (!SplitAtTilt(text, &tilt, &rest)) return Bad("it has no line TILT=.");
  Numbers numbers(rest);
  if (tilt == "INCLUDE") {
    // How a lamp dims when it hangs tilted: it hangs here as it was measured.
    double geometry = 0, count = 0;
    std::vector<float> skipped;
    if (!numbers.Next(&geometry) || !numbers.Next(&count) || !(count >= 0 && count <= kMaxAngles) ||
        !numbers.Next(&skipped, 2 * size_t(count)))
      return Bad("its table of tilts is broken.");
  }
  // Lamps, lumens, multiplier, angles, type, unit, width, length, height; ballast factor, reserved, watts.
  double head[13];
  for (double& value : head) {
    if (!numbers.Next(&value)) return Bad("its thirteen numbers after TILT= are not all there.");
  }
  const double rows = head[4], columns = head[3], scale = head[2];
  if (!(columns >= 1 && columns <= kMaxAngles && rows >= 1 && rows <= kMaxAngles && columns * rows <= double(kMaxValues)))
    return Bad("it counts " + std::to_string(long(columns)) + " vertical and " + std::to_string(long(rows)) +
               " horizontal angles.");
  if (head[5] != 1) return Bad("its photometry is of type " + std::string(head[5] == 2 ? "B" : "A") + ", only C is read.");
  PhotometricProfile profile;
  if (!numbers.Next(&profile.vertical, size_t(columns)) || !numbers.Next(&profile.horizontal, size_t(rows)) ||
      !numbers.Next(&profile.candela, size_t(columns) * size_t(rows)))
    return Bad("it ends before its last value.");
  for (const auto* angles : {&profile.vertical, &profile.horizontal}) {
    if (!std::is_sorted(angles->begin(), angles->end()) || angles->front() < 0 || angles->back() > 360)
      return Bad("its angles do not ascend from 0 to 360.");
  }
  for (float& value : profile.candela) {
    value = float(value * scale);
    if (!(value >= 0) || !std::isfinite(value)) return Bad("it holds intensities below zero or beyond all bounds.");
  }
  return profile;
}

wavefront::Result<PhotometricProfile> ReadPhotometricProfile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return wavefront::Error{"it cannot be opened."};
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (text.size() > kMaxBytes) return Bad("it has more than 64 MiB.");
  return ParsePhotometricProfile(text);
}

wavefront::Result<wavefront::TextureData> EmissionTexture(const PhotometricProfile& profile) {
  constexpr double kPi = std::numbers::pi;
  double flux = 0;  // of a surface whose radiance is the profile: the integral of it times the cosine
  constexpr int kSteps = 360;
  for (int y = 0; y < kSteps; ++y) {
    const double from = std::cos(0.5 * kPi * y / kSteps), to = std::cos(0.5 * kPi * (y + 1) / kSteps);
    double around = 0;
    for (int x = 0; x < kSteps; ++x) around += profile.At(90.0f * (float(y) + 0.5f) / kSteps, float(x) + 0.5f);
    flux += around / kSteps * kPi * (from * from - to * to);
  }
  if (!(flux > 0)) return Bad("it sends no light forward.");
  wavefront::TextureData data;
  data.width = kColumns;
  data.height = kRows;
  data.format = wavefront::TexelFormat::Rgba16Float;
  data.texels.resize(size_t(kColumns) * kRows * 8);
  for (uint32_t y = 0; y < kRows; ++y) {
    for (uint32_t x = 0; x < kColumns; ++x) {
      const double value = profile.At(90.0f * float(y) / (kRows - 1), 360.0f * float(x) / kColumns) * kPi / flux;
      const uint16_t half = wavefront::FloatToHalf(float(std::min(value, 65000.0)));
      const uint16_t texel[4] = {half, half, half, wavefront::FloatToHalf(1)};
      std::memcpy(&data.texels[(size_t(y) * kColumns + x) * 8], texel, 8);
    }
  }
  return data;
}

}  // namespace delegate
