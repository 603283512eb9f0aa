// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render settings: Hydra's descriptors from the core's rows. Pure.
#pragma once

#include <string>

#include <pxr/imaging/hd/renderDelegate.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

inline constexpr const char* kSettingsNamespace = "wavefront:";

// The core's token of a key: "wavefront:samples", or Hydra's own names without the namespace. Empty: none of the
// core's.
std::string ToCoreSetting(const TfToken& key);

HdRenderSettingDescriptorList SettingDescriptors();

}  // namespace hydra
