// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What stands beside plugInfo.json, and the host-neutral delegate made from it.
#pragma once

#include <memory>
#include <string>

#include <pxr/imaging/hd/renderDelegate.h>

#include "delegate/render_delegate.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// The folder of the plugin's resources (plugInfo.json's ResourcePath), found through Plug.
std::string ResourcePath();

// Where HDWAVEFRONT_CAPTURE has what the core is told written instead of rendered (delegate/capture); empty: nowhere.
std::string CaptureFile();

// HDWAVEFRONT_DEVICE and HDWAVEFRONT_VALIDATION count as everywhere; HDWAVEFRONT_MATERIALX names MaterialX's libraries
// where they are not the plugin's own. threadLimit is read from the settings.
wavefront::Result<std::unique_ptr<delegate::RenderDelegate>> CreateCore(const HdRenderSettingsMap& settings);

}  // namespace hydra
