// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// OpenColorIO on the colour AOV, for hosts that do no colour management of their own: the library's GPU text, run as a
// compute kernel on the renderer's device. Off unless a setting asks for it. Where the plugin was built without
// OpenColorIO, asking for it is an error and the picture stays linear.
#pragma once

#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "delegate/colour/color_kernel.h"

namespace hydra {

struct ColorSettings {
  std::string config;  // a file, or a built-in configuration's name; "": off; "1", "default": $OCIO or the default
  std::string display, view;  // "": the configuration's defaults
  std::string renderingSpace = "lin_rec709";
  bool operator==(const ColorSettings&) const = default;
};

// The settings' tokens, without namespace; each is a string.
struct ColorSettingInfo {
  const char* token;
  std::string ColorSettings::*member;
  const char* doc;
};
std::span<const ColorSettingInfo> ColorSettingInfos();
const ColorSettingInfo* FindColorSetting(const std::string& token);

// Any thread.
class ColorOutput {
 public:
  // True: they differ from the last ones.
  bool Set(const ColorSettings& settings);
  ColorSettings settings() const;

  // The display's colours, still multiplied by alpha, in place. Does nothing where it is off. The first call after Set
  // reads the configuration. An error, told once until the settings change, leaves this and later images linear; it
  // names the choices where a display or a view does not exist.
  wavefront::Status Apply(wavefront::Renderer& renderer, wavefront::AovImage& image);

 private:
  wavefront::Status Prepare();

  mutable std::mutex mutex_;
  ColorSettings settings_;
  bool pending_ = false;
  std::optional<delegate::CompiledColorShader> shader_;  // nothing: off
};

// The library's shader for these settings.
wavefront::Result<delegate::ColorShader> MakeColorShader(const ColorSettings& settings);

}  // namespace hydra
