// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_instancer.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/gf/quatd.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>

#include "plugin/hydra/convert_primvars.h"
#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

// Hydra allows all four arrays at once: the matrix is applied first, then scale, rotation and translation. No host is
// known to do it; the delegate takes the one or the other.
void MultiplyIn(delegate::InstancerUpdate& update) {
  auto& matrices = update.transforms->front().value;
  const auto count = [](const auto& samples) { return samples ? samples->front().value.size() : size_t{0}; };
  for (size_t i = 0; i < matrices.size(); ++i) {
    GfMatrix4d result(1);
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) result[r][c] = matrices[i].m[static_cast<size_t>(r)][static_cast<size_t>(c)];
    if (i < count(update.scales)) {
      const wavefront::Float3 s = update.scales->front().value[i];
      result *= GfMatrix4d().SetScale(GfVec3d(s.x, s.y, s.z));
    }
    if (i < count(update.orientations)) {
      const wavefront::Float4 q = update.orientations->front().value[i];
      result *= GfMatrix4d().SetRotate(GfQuatd(q.w, q.x, q.y, q.z).GetNormalized());
    }
    if (i < count(update.positions)) {
      const wavefront::Float3 p = update.positions->front().value[i];
      result *= GfMatrix4d().SetTranslate(GfVec3d(p.x, p.y, p.z));
    }
    matrices[i] = ToMatrix(result);
  }
  update.positions.emplace(1);
  update.scales.emplace(1);
  update.orientations.emplace(1);
}

}  // namespace

void ToInstances(const HdPrimvarDescriptorVector& primvars,
                 const std::function<VtValue(const HdPrimvarDescriptor&, VtIntArray*)>& value, size_t instanceCount,
                 delegate::InstancerUpdate& update) {
  // What an instancer no longer has must be told as well: every array starts empty.
  update.transforms.emplace(1);
  update.positions.emplace(1);
  update.orientations.emplace(1);
  update.scales.emplace(1);
  update.primvars.emplace();
  const auto put = [](auto& member, auto converted) {
    if (converted) member->front().value = std::move(*converted);
  };
  for (const HdPrimvarDescriptor& primvar : primvars) {
    VtIntArray indices;
    const VtValue v = value(primvar, &indices);
    if (primvar.name == HdInstancerTokens->instanceTranslations) put(update.positions, ToFloat3s(v));
    else if (primvar.name == HdInstancerTokens->instanceRotations) put(update.orientations, ToQuaternions(v));
    else if (primvar.name == HdInstancerTokens->instanceScales) put(update.scales, ToFloat3s(v));
    else if (primvar.name == HdInstancerTokens->instanceTransforms) put(update.transforms, ToMatrices(v));
    else if (auto converted = ToPrimvar(primvar.name, "instance", v, indices))
      update.primvars->push_back(std::move(*converted));
  }
  const bool hasArrays = !update.positions->front().value.empty() || !update.orientations->front().value.empty() ||
                         !update.scales->front().value.empty();
  if (!update.transforms->front().value.empty()) {
    if (hasArrays) MultiplyIn(update);
  } else if (update.positions->front().value.empty()) {
    update.transforms->front().value.resize(
        std::max({instanceCount, update.orientations->front().value.size(), update.scales->front().value.size()}));
    if (hasArrays) MultiplyIn(update);
  }
}

}  // namespace hydra
