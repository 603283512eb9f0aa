// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/settings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "wavefront/base/check.h"

namespace delegate {
namespace {

template <SettingType type, typename T>
SettingValue MakeValue(T value) {
  if constexpr (type == SettingType::Int) return static_cast<int64_t>(value);
  if constexpr (type == SettingType::Float) return static_cast<double>(value);
  if constexpr (type == SettingType::Bool) return static_cast<bool>(value);
  if constexpr (type == SettingType::Token) return std::string(value);
}

template <typename T>
double Limit(T value) {
  if constexpr (std::is_arithmetic_v<T>) return static_cast<double>(value);
  else return 0;
}
template <typename T>
std::string_view Choices(T value) {
  if constexpr (std::is_arithmetic_v<T>) return {};
  else return value;
}

const SettingInfo kInfos[] = {
#define DELEGATE_SETTING(token, type, defaultValue, minimum, maximum, doc)                                         \
  {#token, SettingType::type, MakeValue<SettingType::type>(defaultValue), Limit(minimum), Limit(maximum),          \
   Choices(minimum), doc},
#include "delegate/settings.def"
#undef DELEGATE_SETTING
};

// Hydra's own names for the same thing.
constexpr std::array<std::pair<std::string_view, std::string_view>, 1> kAliases{
    {{"convergedSamplesPerPixel", "samples"}}};

// The value in the row's type, if it has one.
std::optional<SettingValue> Convert(const SettingInfo& info, const SettingValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (info.type == SettingType::Token) {
    const std::vector<std::string> choices = ChoicesOf(info);
    if (!text || std::find(choices.begin(), choices.end(), *text) == choices.end()) return std::nullopt;
    return value;
  }
  if (text) return std::nullopt;
  const double number = std::visit(
      [](const auto& v) {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(v)>>) return static_cast<double>(v);
        return 0.0;
      },
      value);
  if (!(number >= info.minimum && number <= info.maximum)) return std::nullopt;
  const bool whole = number == std::floor(number);
  switch (info.type) {
    case SettingType::Bool:
      if (!whole) return std::nullopt;
      return number != 0;
    case SettingType::Int:
      if (!whole || std::holds_alternative<bool>(value)) return std::nullopt;
      return static_cast<int64_t>(number);
    case SettingType::Float:
      if (std::holds_alternative<bool>(value)) return std::nullopt;
      return number;
    case SettingType::Token: break;
  }
  return std::nullopt;
}

std::string Expected(const SettingInfo& info) {
  const auto show = [](double v) {
    return std::abs(v) < 1e15 && v == std::floor(v) ? std::to_string(static_cast<int64_t>(v)) : std::to_string(v);
  };
  if (info.type == SettingType::Bool) return "true or false";
  if (info.type == SettingType::Token) {
    std::string all;
    for (const std::string& choice : ChoicesOf(info)) all += (all.empty() ? "" : " or ") + choice;
    return all;
  }
  return std::string(info.type == SettingType::Int ? "a whole number" : "a number") + " from " + show(info.minimum) +
         " to " + (info.maximum >= 1e30 ? "1e30" : show(info.maximum));
}

}  // namespace

std::span<const SettingInfo> RenderSettingInfos() { return kInfos; }

const SettingInfo* FindRenderSetting(std::string_view token) {
  for (const auto& [alias, name] : kAliases)
    if (token == alias) token = name;
  for (const SettingInfo& info : kInfos)
    if (info.token == token) return &info;
  return nullptr;
}

std::vector<std::string> ChoicesOf(const SettingInfo& info) {
  std::vector<std::string> choices;
  for (std::string_view left = info.choices; !left.empty();) {
    const size_t end = std::min(left.find('|'), left.size());
    choices.emplace_back(left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  return choices;
}

SettingValues::SettingValues() {
  for (const SettingInfo& info : kInfos) values_.push_back(info.defaultValue);
}

wavefront::Result<bool> SettingValues::Set(std::string_view token, const SettingValue& value) {
  const SettingInfo* info = FindRenderSetting(token);
  if (!info) return wavefront::Error{"There is no render setting \"" + std::string(token) + "\"."};
  const std::optional<SettingValue> converted = Convert(*info, value);
  if (!converted)
    return wavefront::Error{"Render setting " + std::string(info->token) + " wants " + Expected(*info) + "."};
  SettingValue& current = values_[static_cast<size_t>(info - kInfos)];
  if (current == *converted) return false;
  current = *converted;
  return true;
}

wavefront::Result<SettingValue> SettingValues::Get(std::string_view token) const {
  const SettingInfo* info = FindRenderSetting(token);
  if (!info) return wavefront::Error{"There is no render setting \"" + std::string(token) + "\"."};
  return values_[static_cast<size_t>(info - kInfos)];
}

int64_t SettingValues::Int(std::string_view token) const {
  auto value = Get(token);
  WAVEFRONT_CHECK(value.ok(), "no setting %s", std::string(token).c_str());
  return std::get<int64_t>(value.value());
}

bool SettingValues::Bool(std::string_view token) const {
  auto value = Get(token);
  WAVEFRONT_CHECK(value.ok(), "no setting %s", std::string(token).c_str());
  return std::get<bool>(value.value());
}

const std::string& SettingValues::Token(std::string_view token) const {
  const SettingInfo* info = FindRenderSetting(token);
  WAVEFRONT_CHECK(info, "no setting %s", std::string(token).c_str());
  return std::get<std::string>(values_[static_cast<size_t>(info - kInfos)]);
}

void SettingValues::FillInto(wavefront::RenderSettings& settings) const {
  const auto number = [this](std::string_view token) { return static_cast<uint32_t>(Int(token)); };
  settings.firstSample = number("firstSample");
  settings.samples = number("samples");
  settings.maxBounces = number("maxBounces");
  settings.rouletteBounce = number("rouletteBounce");
  settings.maxTransparency = number("maxTransparency");
  settings.seed = number("seed");
  const std::string lightSampling = Token("lightSampling");
  settings.lightSampling = lightSampling == "tree"    ? wavefront::LightSampling::Tree
                           : lightSampling == "power" ? wavefront::LightSampling::Power
                                                      : wavefront::LightSampling::Auto;
  settings.executionMode = Token("executionMode") == "megakernel" ? wavefront::ExecutionMode::Megakernel
                                                                  : wavefront::ExecutionMode::Wavefront;
  settings.poolSize = number("poolSize");
  settings.samplesPerBatch = number("samplesPerBatch");
  const auto real = [this](std::string_view token) { return static_cast<float>(std::get<double>(Get(token).value())); };
  settings.frame = real("frame");
  settings.time = real("time");
  settings.textureMemory = static_cast<uint64_t>(Int("textureMemory")) << 20;
  settings.radianceClamp = real("radianceClamp");
  settings.cameraVisibleDome = Bool("domeLightCameraVisibility");
  settings.shadows = Bool("enableShadows");
  settings.interactive = Bool("enableInteractive");
}

}  // namespace delegate
