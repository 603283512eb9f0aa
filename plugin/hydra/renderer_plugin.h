// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What Hydra loads by plugInfo.json: makes render delegates.
#pragma once

#include <string>

#include "plugin/hydra/hd_compat.h"

PXR_NAMESPACE_OPEN_SCOPE

// The class's name is the renderer's id: hosts name it in settings and in Blender's bl_delegate_id.
class HdWavefrontRendererPlugin final : public HdRendererPlugin {
 public:
  HdWavefrontRendererPlugin() = default;

  // Null where no device can be used or resources are missing; the reason is posted as a TF_RUNTIME_ERROR.
  HdRenderDelegate* CreateRenderDelegate() override;
  HdRenderDelegate* CreateRenderDelegate(const HdRenderSettingsMap& settingsMap) override;
  void DeleteRenderDelegate(HdRenderDelegate* renderDelegate) override;

  // Hosts ask often: answers without touching a device. The renderer brings its own, whatever the host's GPU setting.
#if HDWAVEFRONT_HAS_CREATE_ARGS
  bool IsSupported(const HdRendererCreateArgs& args, std::string* reasonWhyNot = nullptr) const override;
#else
  bool IsSupported(bool gpuEnabled = true) const override;
#endif
};

PXR_NAMESPACE_CLOSE_SCOPE
