// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// UsdLux inputs as Hydra hands them over. Pure.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <pxr/base/tf/token.h>

#include "delegate/prims/light.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// Answers with the value of a light parameter; empty where there is none.
using LightValues = std::function<VtValue(const TfToken&)>;

// Hydra's type of a light that the core renders ("rectLight") to UsdLux's schema ("RectLight"); empty for others.
std::string ToLightType(const TfToken& type);

delegate::LightParams ToLightParams(const TfToken& type, const LightValues& values);

// What is authored on a light and not rendered: (code, message).
std::vector<std::pair<const char*, std::string>> UnsupportedLightInputs(const LightValues& values);

// UsdLuxDomeLight_1's pole axis arrives as a matrix that comes before the transform. Identity where there is none.
GfMatrix4d DomeOffset(const LightValues& values);

}  // namespace hydra
