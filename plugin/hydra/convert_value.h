// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Values of Vt and Gf as the delegate takes them. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/vt/array.h>
#include <pxr/base/vt/value.h>
#include <pxr/usd/sdf/path.h>

#include "delegate/prims/gprim.h"
#include "delegate/settings.h"
#include "materialgen/network.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

wavefront::Matrix4d ToMatrix(const GfMatrix4d& matrix);

// Numbers of a scalar, vector or array value as floats. `components` per element: 1 to 4, or 9 and 16 for matrices.
struct Floats {
  uint32_t components = 1;
  std::vector<float> values;
  bool isArray = false;
};
// Nothing for what holds no numbers: strings, tokens, assets, quaternions, and empty values.
std::optional<Floats> ToFloats(const VtValue& value);

// Arrays of three-vectors (float, double, half); nothing for other types.
std::optional<std::vector<wavefront::Float3>> ToFloat3s(const VtValue& value);
// Arrays of quaternions (half, float, double) as x, y, z, w; nothing for other types.
std::optional<std::vector<wavefront::Float4>> ToQuaternions(const VtValue& value);
std::optional<std::vector<wavefront::Matrix4d>> ToMatrices(const VtValue& value);

std::vector<int32_t> ToInts(const VtIntArray& values);

// bool, every integer that fits, float and double, text that is not empty; nothing for others.
std::optional<delegate::SettingValue> ToSetting(const VtValue& value);
VtValue FromSetting(const delegate::SettingValue& value);

std::optional<double> ToNumber(const VtValue& value);
std::optional<bool> ToBool(const VtValue& value);
std::string ToString(const VtValue& value);  // of strings, tokens and asset paths (authored); else empty

// A parameter of a shading node; monostate for a type that networks do not hold.
materialgen::Value ToParameter(const VtValue& value);
// resolvedPath is what the host's resolver found; patterns with <UDIM> keep the authored path where it found nothing.
materialgen::AssetValue ToAsset(const VtValue& value);

}  // namespace hydra
