// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_value.h"

#include "delegate/texture_tiles.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/gf/matrix3d.h>
#include <pxr/base/gf/matrix3f.h>
#include <pxr/base/gf/matrix4f.h>
#include <pxr/base/gf/quatd.h>
#include <pxr/base/gf/quatf.h>
#include <pxr/base/gf/quath.h>
#include <pxr/base/gf/vec2d.h>
#include <pxr/base/gf/vec2f.h>
#include <pxr/base/gf/vec2h.h>
#include <pxr/base/gf/vec2i.h>
#include <pxr/base/gf/vec3d.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec3h.h>
#include <pxr/base/gf/vec3i.h>
#include <pxr/base/gf/vec4d.h>
#include <pxr/base/gf/vec4f.h>
#include <pxr/base/gf/vec4h.h>
#include <pxr/base/gf/vec4i.h>
#include <pxr/base/tf/token.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

namespace hydra {

namespace {

template <typename T>
constexpr uint32_t Components() {
  if constexpr (GfIsGfVec<T>::value) return T::dimension;
  else if constexpr (GfIsGfMatrix<T>::value) return T::numRows * T::numColumns;
  else return 1;
}

template <typename T>
void Append(const T& element, std::vector<float>& out) {
  if constexpr (GfIsGfVec<T>::value) {
    for (size_t i = 0; i < T::dimension; ++i) out.push_back(static_cast<float>(element[i]));
  } else if constexpr (GfIsGfMatrix<T>::value) {
    for (size_t i = 0; i < T::numRows * T::numColumns; ++i) out.push_back(static_cast<float>(element.data()[i]));
  } else {
    out.push_back(static_cast<float>(element));
  }
}

template <typename T>
bool TryFloats(const VtValue& value, Floats& out) {
  if (value.IsHolding<T>()) {
    out.components = Components<T>();
    Append(value.UncheckedGet<T>(), out.values);
    return true;
  }
  if (value.IsHolding<VtArray<T>>()) {
    const auto& array = value.UncheckedGet<VtArray<T>>();
    out.components = Components<T>();
    out.isArray = true;
    out.values.reserve(array.size() * out.components);
    for (const T& element : array) Append(element, out.values);
    return true;
  }
  return false;
}

template <typename... T>
bool TryAnyFloats(const VtValue& value, Floats& out) {
  return (TryFloats<T>(value, out) || ...);
}

template <typename T>
bool TryFloat3s(const VtValue& value, std::vector<wavefront::Float3>& out) {
  if (!value.IsHolding<VtArray<T>>()) return false;
  const auto& array = value.UncheckedGet<VtArray<T>>();
  out.reserve(array.size());
  for (const T& v : array)
    out.push_back({static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])});
  return true;
}

template <typename T>
bool TryQuaternions(const VtValue& value, std::vector<wavefront::Float4>& out) {
  if (!value.IsHolding<VtArray<T>>()) return false;
  const auto& array = value.UncheckedGet<VtArray<T>>();
  out.reserve(array.size());
  for (const T& q : array) {
    const auto& i = q.GetImaginary();
    out.push_back({static_cast<float>(i[0]), static_cast<float>(i[1]), static_cast<float>(i[2]),
                   static_cast<float>(q.GetReal())});
  }
  return true;
}

template <typename T>
bool TryWhole(const VtValue& value, std::optional<delegate::SettingValue>& out) {
  if (!value.IsHolding<T>()) return false;
  const T number = value.UncheckedGet<T>();
  if constexpr (std::is_same_v<T, uint64_t>)
    if (number > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) return true;
  out = static_cast<int64_t>(number);
  return true;
}

template <size_t N>
materialgen::Value FloatArray(const std::vector<float>& values) {
  std::array<float, N> array;
  std::copy_n(values.begin(), N, array.begin());
  return array;
}

}  // namespace

wavefront::Matrix4d ToMatrix(const GfMatrix4d& matrix) {
  wavefront::Matrix4d result;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) result.m[i][j] = matrix[i][j];
  return result;
}

std::optional<Floats> ToFloats(const VtValue& value) {
  Floats floats;
  if (TryAnyFloats<float, GfVec2f, GfVec3f, GfVec4f, double, GfHalf, GfVec2d, GfVec3d, GfVec4d, GfVec2h, GfVec3h,
                   GfVec4h, int, bool, unsigned int, unsigned char, int64_t, uint64_t, GfVec2i, GfVec3i, GfVec4i,
                   GfMatrix3d, GfMatrix4d, GfMatrix3f, GfMatrix4f>(value, floats))
    return floats;
  return std::nullopt;
}

std::optional<std::vector<wavefront::Float3>> ToFloat3s(const VtValue& value) {
  std::vector<wavefront::Float3> result;
  if (TryFloat3s<GfVec3f>(value, result) || TryFloat3s<GfVec3d>(value, result) || TryFloat3s<GfVec3h>(value, result))
    return result;
  return std::nullopt;
}

std::optional<std::vector<wavefront::Float4>> ToQuaternions(const VtValue& value) {
  std::vector<wavefront::Float4> result;
  if (TryQuaternions<GfQuath>(value, result) || TryQuaternions<GfQuatf>(value, result) ||
      TryQuaternions<GfQuatd>(value, result))
    return result;
  // Older scene delegates hand rotations over as (real, i, j, k) vectors.
  if (value.IsHolding<VtVec4fArray>()) {
    for (const GfVec4f& q : value.UncheckedGet<VtVec4fArray>()) result.push_back({q[1], q[2], q[3], q[0]});
    return result;
  }
  return std::nullopt;
}

std::optional<std::vector<wavefront::Matrix4d>> ToMatrices(const VtValue& value) {
  if (!value.IsHolding<VtMatrix4dArray>()) return std::nullopt;
  std::vector<wavefront::Matrix4d> result;
  const auto& array = value.UncheckedGet<VtMatrix4dArray>();
  result.reserve(array.size());
  for (const GfMatrix4d& matrix : array) result.push_back(ToMatrix(matrix));
  return result;
}

std::vector<int32_t> ToInts(const VtIntArray& values) { return {values.cbegin(), values.cend()}; }

std::optional<delegate::SettingValue> ToSetting(const VtValue& value) {
  std::optional<delegate::SettingValue> result;
  if (value.IsHolding<bool>()) return value.UncheckedGet<bool>();
  if (TryWhole<int>(value, result) || TryWhole<unsigned int>(value, result) || TryWhole<int64_t>(value, result) ||
      TryWhole<uint64_t>(value, result) || TryWhole<short>(value, result) || TryWhole<unsigned char>(value, result))
    return result;
  if (value.IsHolding<float>()) return static_cast<double>(value.UncheckedGet<float>());
  if (value.IsHolding<double>()) return value.UncheckedGet<double>();
  if (std::string text = ToString(value); !text.empty()) return text;
  return std::nullopt;
}

VtValue FromSetting(const delegate::SettingValue& value) {
  // int and float are what usdview shows; it leaves out 64-bit integers and doubles.
  if (const auto* whole = std::get_if<int64_t>(&value)) return VtValue(static_cast<int>(*whole));
  if (const auto* real = std::get_if<double>(&value)) return VtValue(static_cast<float>(*real));
  if (const auto* text = std::get_if<std::string>(&value)) return VtValue(*text);
  return VtValue(std::get<bool>(value));
}

std::optional<double> ToNumber(const VtValue& value) {
  if (value.IsHolding<GfHalf>()) return static_cast<double>(value.UncheckedGet<GfHalf>());
  const auto setting = ToSetting(value);
  if (!setting) return std::nullopt;
  if (const auto* whole = std::get_if<int64_t>(&*setting)) return static_cast<double>(*whole);
  if (const auto* flag = std::get_if<bool>(&*setting)) return *flag ? 1.0 : 0.0;
  if (const auto* real = std::get_if<double>(&*setting)) return *real;
  return std::nullopt;
}

std::optional<bool> ToBool(const VtValue& value) {
  const auto number = ToNumber(value);
  return number ? std::optional<bool>(*number != 0) : std::nullopt;
}

std::string ToString(const VtValue& value) {
  if (value.IsHolding<TfToken>()) return value.UncheckedGet<TfToken>().GetString();
  if (value.IsHolding<std::string>()) return value.UncheckedGet<std::string>();
  if (value.IsHolding<SdfAssetPath>()) return value.UncheckedGet<SdfAssetPath>().GetAssetPath();
  return {};
}

materialgen::AssetValue ToAsset(const VtValue& value) {
  materialgen::AssetValue asset;
  if (value.IsHolding<SdfAssetPath>()) {
    const auto& path = value.UncheckedGet<SdfAssetPath>();
    asset.authoredPath = path.GetAssetPath();
    asset.resolvedPath = path.GetResolvedPath();
  } else {
    asset.authoredPath = ToString(value);
    asset.resolvedPath = asset.authoredPath;
  }
  if (asset.resolvedPath.empty() && delegate::IsTilePattern(asset.authoredPath))
    asset.resolvedPath = asset.authoredPath;
  return asset;
}

materialgen::Value ToParameter(const VtValue& value) {
  if (value.IsHolding<bool>()) return value.UncheckedGet<bool>();
  if (value.IsHolding<int>()) return value.UncheckedGet<int>();
  if (value.IsHolding<SdfAssetPath>()) return ToAsset(value);
  if (value.IsHolding<std::string>() || value.IsHolding<TfToken>()) return ToString(value);
  const std::optional<Floats> floats = ToFloats(value);
  if (!floats || floats->isArray) return std::monostate();
  switch (floats->values.size()) {
    case 1: return floats->values[0];
    case 2: return FloatArray<2>(floats->values);
    case 3: return FloatArray<3>(floats->values);
    case 4: return FloatArray<4>(floats->values);
    case 9: return FloatArray<9>(floats->values);
    case 16: return FloatArray<16>(floats->values);
    default: return std::monostate();
  }
}

}  // namespace hydra
