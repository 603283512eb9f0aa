// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_settings.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <iterator>
#include <set>

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

IncludedPurposes ToIncludedPurposes(const VtArray<TfToken>& purposes) {
  IncludedPurposes result;
  std::set<std::string> tags{HdRenderTagTokens->geometry.GetString()};
  for (const TfToken& purpose : purposes) {
    if (purpose == TfToken("default")) continue;
    if (purpose == HdRenderTagTokens->render || purpose == HdRenderTagTokens->proxy || purpose == HdRenderTagTokens->guide)
      tags.insert(purpose.GetString());
    else
      result.unknown.push_back(purpose.GetString());
  }
  result.renderTags.assign(tags.begin(), tags.end());
  result.areFallback = purposes.empty() || purposes == VtArray<TfToken>{TfToken("default"), HdRenderTagTokens->render};
  return result;
}

std::vector<std::string> DrawnTags(std::vector<std::string> ofHost, const IncludedPurposes& included) {
  std::sort(ofHost.begin(), ofHost.end());
  if (included.areFallback) return ofHost;
  if (ofHost.empty()) return included.renderTags;
  std::vector<std::string> both;
  std::set_intersection(ofHost.begin(), ofHost.end(), included.renderTags.begin(), included.renderTags.end(), std::back_inserter(both));
  if (both.empty()) both.push_back(HdRenderTagTokens->hidden.GetString());  // no tag at all would be every tag
  return both;
}

TfToken ToBindingPurpose(const VtArray<TfToken>& purposes) {
  for (const TfToken& purpose : purposes)
    if (!purpose.IsEmpty()) return purpose;
  return {};
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
