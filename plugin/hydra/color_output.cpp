// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/color_output.h"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

namespace hydra {

std::span<const ColorSettingInfo> ColorSettingInfos() {
  static constexpr std::array<ColorSettingInfo, 4> infos{{
      {"ocio", &ColorSettings::config,
       "OpenColorIO on the colour AOV: a configuration's file or built-in name, default ($OCIO, else the built-in ACES "
       "one), or nothing for linear colours, as hosts with their own colour management want them"},
      {"ocioDisplay", &ColorSettings::display, "display of the OpenColorIO configuration; nothing: its default"},
      {"ocioView", &ColorSettings::view, "view of the OpenColorIO display; nothing: its default"},
      {"renderingColorSpace", &ColorSettings::renderingSpace,
       "what the linear colours of the scene mean to OpenColorIO, by a colour space's name"},
  }};
  return infos;
}

const ColorSettingInfo* FindColorSetting(const std::string& token) {
  const auto infos = ColorSettingInfos();
  const auto found = std::find_if(infos.begin(), infos.end(), [&](const auto& info) { return info.token == token; });
  return found == infos.end() ? nullptr : &*found;
}

bool ColorOutput::Set(const ColorSettings& settings) {
  std::lock_guard lock(mutex_);
  if (settings == settings_) return false;
  settings_ = settings;
  shader_.reset();
  pending_ = true;
  return true;
}

ColorSettings ColorOutput::settings() const {
  std::lock_guard lock(mutex_);
  return settings_;
}

wavefront::Status ColorOutput::Prepare() {
  pending_ = false;
  if (settings_.config.empty()) return {};
  auto text = MakeColorShader(settings_);
  if (!text) return text.error();
  auto compiled = delegate::CompileColorShader(text.value());
  if (!compiled) return compiled.error();
  shader_ = std::move(compiled).value();
  return {};
}

wavefront::Status ColorOutput::Apply(wavefront::Renderer& renderer, wavefront::AovImage& image) {
  std::lock_guard lock(mutex_);
  if (pending_)
    if (const wavefront::Status prepared = Prepare(); !prepared) return prepared;
  if (!shader_ || image.components != 4 || image.bits.empty()) return {};
  // Curves and tables are for the colour of what is seen, whatever part of the pixel it covers.
  std::vector<float> rgba(image.bits.size());
  for (size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = std::bit_cast<float>(image.bits[i + 3]);
    for (size_t c = 0; c < 3; ++c) {
      const float premultiplied = std::bit_cast<float>(image.bits[i + c]);
      rgba[i + c] = alpha > 0 ? premultiplied / alpha : premultiplied;
    }
    rgba[i + 3] = alpha;
  }
  const wavefront::Status run = delegate::RunColorShader(renderer, *shader_, rgba, image.width, image.height);
  if (!run) {
    shader_.reset();  // told once
    return run;
  }
  for (size_t i = 0; i < rgba.size(); i += 4)
    for (size_t c = 0; c < 3; ++c)
      image.bits[i + c] = std::bit_cast<uint32_t>(rgba[i + c] * std::bit_cast<float>(image.bits[i + 3]));
  return {};
}

}  // namespace hydra
