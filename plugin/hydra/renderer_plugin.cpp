// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/renderer_plugin.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/envSetting.h>
#include <pxr/base/tf/getenv.h>
#include <pxr/imaging/hd/rendererPluginRegistry.h>

#include "plugin/hydra/render_delegate.h"
#include "plugin/hydra/resources.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_REGISTRY_FUNCTION(TfType) { HdRendererPluginRegistry::Define<HdWavefrontRendererPlugin>(); }

HdRenderDelegate* HdWavefrontRendererPlugin::CreateRenderDelegate() { return CreateRenderDelegate({}); }

HdRenderDelegate* HdWavefrontRendererPlugin::CreateRenderDelegate(const HdRenderSettingsMap& settingsMap) {
  auto core = hydra::CreateCore(settingsMap);
  if (!core) {
    TF_RUNTIME_ERROR("hdWavefront cannot be used: %s", core.error().message.c_str());
    return nullptr;
  }
  auto* made = new hydra::RenderDelegate(std::move(core).value(), settingsMap);
  made->param().CaptureTo(hydra::CaptureFile());
  return made;
}

void HdWavefrontRendererPlugin::DeleteRenderDelegate(HdRenderDelegate* renderDelegate) { delete renderDelegate; }

#if HDWAVEFRONT_HAS_CREATE_ARGS
bool HdWavefrontRendererPlugin::IsSupported(const HdRendererCreateArgs&, std::string*) const { return true; }
#else
bool HdWavefrontRendererPlugin::IsSupported(bool) const { return true; }
#endif

PXR_NAMESPACE_CLOSE_SCOPE
