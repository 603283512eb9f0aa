// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Same(a, b): equal to the bit, so that a NaN equals itself and marks nothing dirty. A struct takes part by a row of
// Fields: the members that count. Internal to delegate.
#pragma once

#include <array>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "delegate/prims/camera.h"
#include "delegate/prims/gprim.h"
#include "delegate/prims/instancer.h"
#include "delegate/prims/light.h"
#include "delegate/prims/material.h"
#include "wavefront/renderer.h"

namespace delegate {

inline auto Fields(const GeomSubset& v) { return std::tie(v.path, v.indices); }
inline auto Fields(const MeshTopology& v) {
  return std::tie(v.scheme, v.orientation, v.faceVertexCounts, v.faceVertexIndices, v.holeIndices,
                  v.interpolateBoundary, v.faceVaryingLinearInterpolation, v.triangleSubdivisionRule, v.cornerIndices,
                  v.cornerSharpnesses, v.creaseIndices, v.creaseLengths, v.creaseSharpnesses, v.subsets);
}
inline auto Fields(const PrimvarInput& v) {
  return std::tie(v.name, v.interpolation, v.components, v.values, v.indices);
}
inline auto Fields(const ImplicitInput& v) {  // path and doubleSided do not shape the surface
  return std::tie(v.shape, v.size, v.radius, v.radiusTop, v.radiusBottom, v.height, v.width, v.length, v.axis);
}
inline auto Fields(const materialgen::AssetValue& v) { return std::tie(v.authoredPath, v.resolvedPath, v.colorSpace); }
inline auto Fields(const materialgen::Node& v) { return std::tie(v.path, v.identifier, v.parameters); }
inline auto Fields(const materialgen::Connection& v) {
  return std::tie(v.upstreamNode, v.upstreamOutput, v.downstreamNode, v.downstreamInput);
}
inline auto Fields(const materialgen::MaterialNetwork& v) {
  return std::tie(v.path, v.nodes, v.connections, v.surfaceNode, v.surfaceOutput, v.displacementNode,
                  v.displacementOutput);
}
inline auto Fields(const MaterialUpdate& v) { return std::tie(v.contexts); }
inline auto Fields(const LightShaping& v) {
  return std::tie(v.coneAngle, v.coneSoftness, v.focus, v.focusTint, v.iesFile);
}
inline auto Fields(const LightParams& v) {
  return std::tie(v.type, v.intensity, v.exposure, v.color, v.enableColorTemperature, v.colorTemperature, v.normalize,
                  v.diffuse, v.specular, v.width, v.height, v.radius, v.length, v.angle, v.treatAsPoint, v.treatAsLine,
                  v.texture, v.textureFormat, v.shaping, v.shadowEnable, v.visibleToCamera, v.poleAxis);
}
inline auto Fields(const CameraParams& v) {
  return std::tie(v.projection, v.horizontalAperture, v.verticalAperture, v.horizontalApertureOffset,
                  v.verticalApertureOffset, v.focalLength, v.apertureUnit, v.clippingNear, v.clippingFar,
                  v.clippingPlanes, v.fStop, v.focusDistance, v.exposure, v.exposureTime, v.exposureIso, v.exposureFStop, v.exposureResponsivity,
                  v.shutterOpen, v.shutterClose);
}
inline auto Fields(const wavefront::LightData& v) {
  return std::tie(v.path, v.type, v.transforms, v.radiance, v.width, v.height, v.radius, v.length, v.angle, v.coneAngle,
                  v.coneSoftness, v.focus, v.focusTint, v.texture, v.visibleToCamera, v.castsShadows, v.lightLink,
                  v.shadowLink, v.lightGroup);
}
inline auto Fields(const wavefront::CameraData& v) {
  return std::tie(v.transforms, v.orthographic, v.left, v.right, v.bottom, v.top, v.nearClip, v.farClip, v.clipPlanes,
                  v.lensRadius, v.focusDistance, v.exposureScale, v.shutterOpen, v.shutterClose);
}
inline auto Fields(const wavefront::MaterialData& v) {
  return std::tie(v.path, v.kernelKey, v.parameters, v.mediumPriority, v.scatters, v.lightEnters);
}
inline auto Fields(const wavefront::RenderSettings& v) {
  return std::tie(v.width, v.height, v.firstSample, v.samples, v.maxBounces, v.rouletteBounce, v.maxTransparency,
                  v.seed, v.executionMode, v.lightSampling, v.poolSize, v.samplesPerBatch, v.frame, v.time, v.textureMemory,
                  v.radianceClamp, v.cameraVisibleDome, v.shadows, v.interactive, v.aovs, v.primvarAovs);
}

template <typename T>
constexpr bool kBitwise = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, wavefront::Float2> ||
                          std::is_same_v<T, wavefront::Float3> || std::is_same_v<T, wavefront::Float4> ||
                          std::is_same_v<T, wavefront::Matrix4d>;  // no padding

template <typename T>
bool Same(const T& a, const T& b);
template <typename T>
bool Same(const wavefront::TimeSample<T>& a, const wavefront::TimeSample<T>& b);
template <typename T, size_t N>
bool Same(const std::array<T, N>& a, const std::array<T, N>& b);
template <typename A, typename B>
bool Same(const std::pair<A, B>& a, const std::pair<A, B>& b);
template <typename T>
bool Same(const std::optional<T>& a, const std::optional<T>& b);
template <typename T>
bool Same(const std::vector<T>& a, const std::vector<T>& b);
template <typename K, typename V>
bool Same(const std::map<K, V>& a, const std::map<K, V>& b);
template <typename... T>
bool Same(const std::variant<T...>& a, const std::variant<T...>& b);
inline bool Same(const std::string& a, const std::string& b) { return a == b; }
inline bool Same(std::monostate, std::monostate) { return true; }

template <typename T>
bool Same(const T& a, const T& b) {
  if constexpr (kBitwise<T>) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
  } else {
    const auto left = Fields(a), right = Fields(b);
    return [&]<size_t... I>(std::index_sequence<I...>) {
      return (Same(std::get<I>(left), std::get<I>(right)) && ...);
    }(std::make_index_sequence<std::tuple_size_v<decltype(left)>>());
  }
}
template <typename T>
bool Same(const wavefront::TimeSample<T>& a, const wavefront::TimeSample<T>& b) {
  return Same(a.time, b.time) && Same(a.value, b.value);
}
template <typename T, size_t N>
bool Same(const std::array<T, N>& a, const std::array<T, N>& b) {
  static_assert(kBitwise<T>);
  return std::memcmp(a.data(), b.data(), sizeof(T) * N) == 0;
}
template <typename A, typename B>
bool Same(const std::pair<A, B>& a, const std::pair<A, B>& b) {
  return Same(a.first, b.first) && Same(a.second, b.second);
}
template <typename T>
bool Same(const std::optional<T>& a, const std::optional<T>& b) {
  return a.has_value() == b.has_value() && (!a || Same(*a, *b));
}
template <typename T>
bool Same(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size()) return false;
  if constexpr (kBitwise<T>) {
    return a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
  } else {
    for (size_t i = 0; i < a.size(); ++i)
      if (!Same(a[i], b[i])) return false;
    return true;
  }
}
template <typename K, typename V>
bool Same(const std::map<K, V>& a, const std::map<K, V>& b) {
  if (a.size() != b.size()) return false;
  for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j)
    if (!Same(i->first, j->first) || !Same(i->second, j->second)) return false;
  return true;
}
template <typename... T>
bool Same(const std::variant<T...>& a, const std::variant<T...>& b) {
  if (a.index() != b.index()) return false;
  return std::visit([&](const auto& value) { return Same(value, std::get<std::decay_t<decltype(value)>>(b)); }, a);
}

// Takes the update's value if there is one and it differs; true if it was taken.
template <typename T>
bool Take(T& state, std::optional<T>& update) {
  if (!update || Same(state, *update)) return false;
  state = std::move(*update);
  return true;
}

}  // namespace delegate
