// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/resources.h"

#include <pxr/base/plug/plugin.h>
#include <pxr/base/plug/registry.h>
#include <pxr/base/tf/getenv.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/renderDelegate.h>

#include <algorithm>

#include "plugin/hydra/convert_value.h"

namespace hydra {

std::string ResourcePath() {
  const PlugPluginPtr plugin = PlugRegistry::GetInstance().GetPluginWithName("hdWavefront");
  return plugin ? plugin->GetResourcePath() : std::string();
}

std::string CaptureFile() { return TfGetenv("HDWAVEFRONT_CAPTURE"); }

wavefront::Result<std::unique_ptr<delegate::RenderDelegate>> CreateCore(const HdRenderSettingsMap& settings) {
  delegate::RenderDelegateOptions options;
  options.materialxLibraries = TfGetenv("HDWAVEFRONT_MATERIALX", TfStringCatPaths(ResourcePath(), "materialx"));
  options.captureOnly = !CaptureFile().empty();
  const auto limit = settings.find(HdRenderSettingsTokens->threadLimit);
  if (limit != settings.end())
    if (const auto threads = ToSetting(limit->second); threads && std::holds_alternative<int64_t>(*threads))
      options.threads = static_cast<uint32_t>(std::clamp<int64_t>(std::get<int64_t>(*threads), 0, 4096));
  return delegate::RenderDelegate::Create(options);
}

}  // namespace hydra
