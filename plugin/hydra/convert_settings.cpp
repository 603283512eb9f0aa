// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_settings.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/usd/sdf/assetPath.h>

#include "delegate/settings.h"
#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

const ColorSettingInfo* FindColor(const TfToken& key) {
  const std::string prefix(kSettingsNamespace);
  const std::string& name = key.GetString();
  return name.starts_with(prefix) ? FindColorSetting(name.substr(prefix.size())) : nullptr;
}

std::string ToText(const VtValue& value) {
  if (value.IsHolding<SdfAssetPath>())
    if (const std::string& resolved = value.UncheckedGet<SdfAssetPath>().GetResolvedPath(); !resolved.empty())
      return resolved;
  if (const auto number = ToNumber(value)) return *number != 0 ? "1" : "";
  if (const auto flag = ToBool(value)) return *flag ? "1" : "";
  return ToString(value);
}

}  // namespace

std::string ToCoreSetting(const TfToken& key) {
  std::string token = key.GetString();
  const std::string prefix = kSettingsNamespace;
  if (TfStringStartsWith(token, prefix)) token = token.substr(prefix.size());
  return delegate::FindRenderSetting(token) ? token : std::string();
}

std::optional<ColorSettings> WithColorSetting(const TfToken& key, const VtValue& value, ColorSettings settings) {
  const ColorSettingInfo* info = FindColor(key);
  if (!info) return std::nullopt;
  std::string text = ToText(value);
  if (info->member == &ColorSettings::config && (text == "0" || text == "false" || text == "off")) text.clear();
  if (info->member == &ColorSettings::renderingSpace && text.empty()) text = ColorSettings().renderingSpace;
  settings.*(info->member) = std::move(text);
  return settings;
}

bool IsOwnSetting(const TfToken& key) { return FindColor(key) || !ToCoreSetting(key).empty(); }

HdRenderSettingDescriptorList SettingDescriptors() {
  HdRenderSettingDescriptorList descriptors;
  for (const delegate::SettingInfo& info : delegate::RenderSettingInfos())
    descriptors.push_back({std::string(info.token) + ": " + std::string(info.doc),
                           TfToken(kSettingsNamespace + std::string(info.token)), FromSetting(info.defaultValue)});
  for (const ColorSettingInfo& info : ColorSettingInfos())
    descriptors.push_back({std::string(info.token) + ": " + info.doc,
                           TfToken(std::string(kSettingsNamespace) + info.token),
                           VtValue(ColorSettings().*(info.member))});
  return descriptors;
}

}  // namespace hydra
