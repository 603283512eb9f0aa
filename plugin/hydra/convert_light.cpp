// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_light.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/tokens.h>

#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

using delegate::LightParams;
using delegate::LightShaping;

void ReadFloat(const LightValues& values, const char* name, float& member) {
  if (const auto number = ToNumber(values(TfToken(name)))) member = static_cast<float>(*number);
}

void ReadBool(const LightValues& values, const char* name, bool& member) {
  if (const auto truth = ToBool(values(TfToken(name)))) member = *truth;
}

void ReadColor(const LightValues& values, const char* name, wavefront::Float3& member) {
  const auto floats = ToFloats(values(TfToken(name)));
  if (floats && floats->values.size() == 3) member = {floats->values[0], floats->values[1], floats->values[2]};
}

// Nothing where UsdLuxShapingAPI is not applied: then no parameter of it has a value.
std::optional<LightShaping> ReadShaping(const LightValues& values) {
  const char* names[] = {"shaping:cone:angle", "shaping:cone:softness", "shaping:focus", "shaping:focusTint",
                         "shaping:ies:file"};
  bool applied = false;
  for (const char* name : names) applied |= !values(TfToken(name)).IsEmpty();
  if (!applied) return std::nullopt;
  LightShaping shaping;
  ReadFloat(values, "shaping:cone:angle", shaping.coneAngle);
  ReadFloat(values, "shaping:cone:softness", shaping.coneSoftness);
  ReadFloat(values, "shaping:focus", shaping.focus);
  ReadColor(values, "shaping:focusTint", shaping.focusTint);
  shaping.iesFile = ToString(values(TfToken("shaping:ies:file")));
  return shaping;
}

}  // namespace

std::string ToLightType(const TfToken& type) {
  if (type == HdPrimTypeTokens->rectLight) return "RectLight";
  if (type == HdPrimTypeTokens->diskLight) return "DiskLight";
  if (type == HdPrimTypeTokens->sphereLight) return "SphereLight";
  if (type == HdPrimTypeTokens->cylinderLight) return "CylinderLight";
  if (type == HdPrimTypeTokens->distantLight) return "DistantLight";
  if (type == HdPrimTypeTokens->domeLight) return "DomeLight";
  return {};
}

LightParams ToLightParams(const TfToken& type, const LightValues& values) {
  LightParams params;
  params.type = ToLightType(type);
  const std::pair<const char*, float LightParams::*> floats[] = {
      {"intensity", &LightParams::intensity}, {"exposure", &LightParams::exposure},
      {"colorTemperature", &LightParams::colorTemperature}, {"diffuse", &LightParams::diffuse},
      {"specular", &LightParams::specular}, {"width", &LightParams::width}, {"height", &LightParams::height},
      {"radius", &LightParams::radius}, {"length", &LightParams::length}, {"angle", &LightParams::angle}};
  for (const auto& [name, member] : floats) ReadFloat(values, name, params.*member);
  const std::pair<const char*, bool LightParams::*> bools[] = {
      {"enableColorTemperature", &LightParams::enableColorTemperature}, {"normalize", &LightParams::normalize},
      {"treatAsPoint", &LightParams::treatAsPoint}, {"treatAsLine", &LightParams::treatAsLine},
      {"shadow:enable", &LightParams::shadowEnable}};
  for (const auto& [name, member] : bools) ReadBool(values, name, params.*member);
  ReadColor(values, "color", params.color);
  const VtValue texture = values(TfToken("texture:file"));
  if (!ToString(texture).empty()) params.texture = ToAsset(texture);
  if (const std::string format = ToString(values(TfToken("texture:format"))); !format.empty())
    params.textureFormat = format;
  // UsdLux has no word on whether the camera sees a light; the first of these names that is authored counts.
  for (const char* name : {"visibility:camera", "primvars:arnold:visibility:camera", "primvars:arnold:camera",
                           "primvars:ri:attributes:visibility:camera"})
    if (const auto visible = ToBool(values(TfToken(name)))) {
      params.visibleToCamera = *visible;
      break;
    }
  params.shaping = ReadShaping(values);
  return params;
}

std::vector<std::pair<const char*, std::string>> UnsupportedLightInputs(const LightValues& values) {
  std::vector<std::pair<const char*, std::string>> found;
  const auto unlike = [&](const char* name, const VtValue& neutral) {
    const VtValue value = values(TfToken(name));
    if (!value.IsEmpty() && value != neutral)
      found.emplace_back("light-unsupported-input",
                         std::string("inputs:") + name + " is not supported; shadows are as light casts them");
  };
  unlike("shadow:color", VtValue(GfVec3f(0)));
  unlike("shadow:distance", VtValue(-1.0f));
  unlike("shadow:falloff", VtValue(-1.0f));
  const VtValue filters = values(HdTokens->filters);
  if (filters.IsHolding<SdfPathVector>() && !filters.UncheckedGet<SdfPathVector>().empty())
    found.emplace_back("light-filter-unsupported", "light filters are not rendered yet; they are ignored");
  const auto linked = [&](const TfToken& token, const char* code, const char* what) {
    if (!ToString(values(token)).empty())
      found.emplace_back(code, std::string(what) + " is not rendered yet; the light acts on everything");
  };
  linked(HdTokens->lightLink, "light-link-unsupported", "light linking");
  linked(HdTokens->shadowLink, "shadow-link-unsupported", "shadow linking");
  return found;
}

GfMatrix4d DomeOffset(const LightValues& values) {
  const VtValue offset = values(HdLightTokens->domeOffset);
  return offset.IsHolding<GfMatrix4d>() ? offset.UncheckedGet<GfMatrix4d>() : GfMatrix4d(1);
}

}  // namespace hydra
