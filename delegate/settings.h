// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render settings: the rows of settings.def and their values.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/renderer.h"

namespace delegate {

enum class SettingType { Int, Float, Bool, Token };
using SettingValue = std::variant<bool, int64_t, double, std::string>;

struct SettingInfo {
  std::string_view token;
  SettingType type;
  SettingValue defaultValue;
  double minimum, maximum;           // 0 for a Token
  std::string_view choices;          // of a Token, with | between them; else empty
  std::string_view doc;
};
std::span<const SettingInfo> RenderSettingInfos();
std::vector<std::string> ChoicesOf(const SettingInfo& info);
const SettingInfo* FindRenderSetting(std::string_view token);  // aliases included; null: unknown

// The values, by row. Not thread-safe.
class SettingValues {
 public:
  SettingValues();
  // True if the value changed. An error for an unknown token, another type, or a value out of range; a whole float is
  // taken for an int, an int for a float, 0 and 1 for a bool. A token is one of its row's choices.
  wavefront::Result<bool> Set(std::string_view token, const SettingValue& value);
  wavefront::Result<SettingValue> Get(std::string_view token) const;
  int64_t Int(std::string_view token) const;  // of a token that exists
  bool Bool(std::string_view token) const;
  const std::string& Token(std::string_view token) const;
  // Copies all that the core knows; size and AOVs stay.
  void FillInto(wavefront::RenderSettings& settings) const;

 private:
  std::vector<SettingValue> values_;
};

}  // namespace delegate
