// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_primvars.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/tokens.h>

#include "plugin/hydra/convert_value.h"

namespace hydra {

const char* ToInterpolation(HdInterpolation interpolation) {
  switch (interpolation) {
    case HdInterpolationConstant: return "constant";
    case HdInterpolationUniform: return "uniform";
    case HdInterpolationVarying: return "varying";
    case HdInterpolationVertex: return "vertex";
    case HdInterpolationFaceVarying: return "faceVarying";
    case HdInterpolationInstance: return "instance";
    default: return "constant";
  }
}

bool IsShadingPrimvar(const TfToken& name) {
  if (name == HdTokens->points || name == HdTokens->velocities || name == HdTokens->accelerations) return false;
  for (const char* prefix : {"skel:", "arnold:", "ri:", "prman:", "karma:", "cycles:", "renderman:", "hydra:"})
    if (TfStringStartsWith(name.GetString(), prefix)) return false;
  return true;
}

std::optional<delegate::PrimvarInput> ToPrimvar(const TfToken& name, const char* interpolation, const VtValue& value,
                                                const VtIntArray& indices) {
  if (!IsShadingPrimvar(name)) return std::nullopt;
  std::optional<Floats> floats = ToFloats(value);
  if (!floats || floats->components > 4 || floats->values.empty()) return std::nullopt;
  delegate::PrimvarInput primvar;
  primvar.name = name.GetString();
  primvar.interpolation = interpolation;
  primvar.components = floats->components;
  primvar.values = std::move(floats->values);
  primvar.indices = ToInts(indices);
  return primvar;
}

}  // namespace hydra
