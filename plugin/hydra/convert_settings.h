// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render settings: Hydra's descriptors from the core's rows, and the colour output's own. Pure.
#pragma once

#include <optional>
#include <string>

#include <pxr/imaging/hd/renderDelegate.h>

#include "plugin/hydra/color_output.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

inline constexpr const char* kSettingsNamespace = "wavefront:";

// The core's token of a key: "wavefront:samples", or Hydra's own names without the namespace. Empty: none of the
// core's.
std::string ToCoreSetting(const TfToken& key);

// The colour settings with the value that a key of theirs is given: a string, a token, an asset, or for wavefront:ocio
// a bool or number too (true: the default configuration). Nothing: not a key of theirs.
std::optional<ColorSettings> WithColorSetting(const TfToken& key, const VtValue& value, ColorSettings settings);

// Keys that reach SetRenderSetting from a RenderSettings prim.
bool IsOwnSetting(const TfToken& key);

HdRenderSettingDescriptorList SettingDescriptors();

// A RenderSettings prim's includedPurposes as render tags, sorted; "default" is always among them.
struct IncludedPurposes {
  std::vector<std::string> renderTags;
  bool areFallback = true;           // none, or the schema's own, which Hydra does not tell from none
  std::vector<std::string> unknown;  // tokens that are no purposes
};
IncludedPurposes ToIncludedPurposes(const VtArray<TfToken>& purposes);

// What is drawn of the render tags of a host's task, sorted: all of them (none named: every tag) where nothing else is said,
// or those that are included too.
std::vector<std::string> DrawnTags(std::vector<std::string> ofHost, const IncludedPurposes& included);

// The purpose of material bindings before those for all purposes (an empty token): the first one that is named.
TfToken ToBindingPurpose(const VtArray<TfToken>& purposes);

}  // namespace hydra
