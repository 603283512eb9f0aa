// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_settings.h"

#include <pxr/base/tf/stringUtils.h>

#include "delegate/settings.h"
#include "plugin/hydra/convert_value.h"

namespace hydra {

std::string ToCoreSetting(const TfToken& key) {
  std::string token = key.GetString();
  const std::string prefix = kSettingsNamespace;
  if (TfStringStartsWith(token, prefix)) token = token.substr(prefix.size());
  return delegate::FindRenderSetting(token) ? token : std::string();
}

HdRenderSettingDescriptorList SettingDescriptors() {
  HdRenderSettingDescriptorList descriptors;
  for (const delegate::SettingInfo& info : delegate::RenderSettingInfos())
    descriptors.push_back({std::string(info.token) + ": " + std::string(info.doc),
                           TfToken(kSettingsNamespace + std::string(info.token)), FromSetting(info.defaultValue)});
  return descriptors;
}

}  // namespace hydra
