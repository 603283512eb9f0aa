// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// UsdLux inputs, as authored, to the light that the core renders.
#pragma once

#include <optional>
#include <string>

#include "delegate/prims/gprim.h"
#include "materialgen/network.h"
#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"

namespace delegate {

// UsdLuxShapingAPI; angles in degrees.
struct LightShaping {
  float coneAngle = 90, coneSoftness = 0;
  float focus = 0;
  wavefront::Float3 focusTint{0, 0, 0};
  std::string iesFile;
};

// All inputs of UsdLux's lights with their fallbacks; each type reads its own. Angles in degrees, lengths in light
// space, colours scene-linear in the rendering colour space.
struct LightParams {
  std::string type = "RectLight";  // RectLight, DiskLight, SphereLight, CylinderLight, DistantLight, DomeLight
  float intensity = 1, exposure = 0;
  wavefront::Float3 color{1, 1, 1};
  bool enableColorTemperature = false;
  float colorTemperature = 6500;
  bool normalize = false;
  float diffuse = 1, specular = 1;
  float width = 1, height = 1, radius = 0.5f, length = 1;
  float angle = 0.53f;
  bool treatAsPoint = false, treatAsLine = false;
  materialgen::AssetValue texture;       // rect, dome
  std::string textureFormat = "automatic";
  std::optional<LightShaping> shaping;   // absent: ShapingAPI is not applied
  bool shadowEnable = true;
  bool visibleToCamera = true;
  std::string poleAxis = "Y";            // dome: Y, or Z (UsdLuxDomeLight_1 in a Z-up scene)
};

struct LightUpdate {
  std::optional<LightParams> params;                           // the whole set
  std::optional<TimeSamples<wavefront::Matrix4d>> transforms;  // light to world
  std::optional<bool> visible;
  std::optional<std::string> instancer;
  std::optional<int32_t> prototype;
};

// UsdLuxBlackbodyTemperatureAsRgb: linear Rec. 709 of luminance 1; temperatures are clamped to 1000..10000 K.
wavefront::Float3 BlackbodyTemperatureAsRgb(float kelvin);

// UsdLux's sizeFactor for `normalize`: area in world space (lightToWorld may scale unevenly); distant: 1 at angle 0,
// else pi sin^2(angle/2); dome: 1. Zero or not finite where the light has no size.
double LightSizeFactor(const LightParams& params, const wavefront::Matrix4d& lightToWorld);

// Nothing if the light cannot shine: unknown type, no area, a singular or not finite transform, not finite inputs; the
// sink is told. Texture stays kInvalidId: the caller owns textures.
std::optional<wavefront::LightData> ConvertLight(const std::string& path, const LightParams& params,
                                                 const TimeSamples<wavefront::Matrix4d>& transforms,
                                                 const wavefront::DiagnosticSink& sink);

}  // namespace delegate
