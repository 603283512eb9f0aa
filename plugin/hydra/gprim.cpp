// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/gprim.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/extComputationUtils.h>
#include <pxr/imaging/hd/mesh.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>

#include "plugin/hydra/convert_primvars.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/instancer.h"
#include "plugin/hydra/render_param.h"

namespace hydra {
namespace {

bool HasComputed(HdSceneDelegate& sceneDelegate, const SdfPath& id) {
  for (int i = 0; i < HdInterpolationCount; ++i)
    if (!sceneDelegate.GetExtComputationPrimvarDescriptors(id, static_cast<HdInterpolation>(i)).empty()) return true;
  return false;
}

// Skinning and the like: values by primvar, computed on the CPU by the computations' own kernels.
void ReadComputed(HdSceneDelegate& sceneDelegate, const SdfPath& id, std::vector<delegate::PrimvarInput>& primvars,
                  VtValue* points) {
  for (int i = 0; i < HdInterpolationCount; ++i) {
    const auto interpolation = static_cast<HdInterpolation>(i);
    const HdExtComputationPrimvarDescriptorVector descriptors =
        sceneDelegate.GetExtComputationPrimvarDescriptors(id, interpolation);
    if (descriptors.empty()) continue;
    const auto values = HdExtComputationUtils::GetComputedPrimvarValues(descriptors, &sceneDelegate);
    for (const HdExtComputationPrimvarDescriptor& descriptor : descriptors) {
      const auto found = values.find(descriptor.name);
      if (found == values.end() || found->second.IsEmpty()) continue;
      if (descriptor.name == HdTokens->points) {
        if (points) *points = found->second;
        continue;
      }
      const std::string name = descriptor.name.GetString();
      std::erase_if(primvars, [&](const delegate::PrimvarInput& p) { return p.name == name; });
      if (auto primvar = ToPrimvar(descriptor.name, ToInterpolation(interpolation), found->second, {}))
        primvars.push_back(std::move(*primvar));
    }
  }
}

std::vector<delegate::PrimvarInput> ReadPrimvars(HdSceneDelegate& sceneDelegate, const SdfPath& id) {
  std::vector<delegate::PrimvarInput> primvars;
  for (int i = 0; i < HdInterpolationInstance; ++i) {
    const auto interpolation = static_cast<HdInterpolation>(i);
    for (const HdPrimvarDescriptor& descriptor : sceneDelegate.GetPrimvarDescriptors(id, interpolation)) {
      if (!IsShadingPrimvar(descriptor.name)) continue;
      VtIntArray indices;
      const VtValue value = descriptor.indexed
                                ? sceneDelegate.GetIndexedPrimvar(id, descriptor.name, &indices)
                                : sceneDelegate.Get(id, descriptor.name);
      if (auto primvar = ToPrimvar(descriptor.name, ToInterpolation(interpolation), value, indices))
        primvars.push_back(std::move(*primvar));
    }
  }
  // Hosts list primvars in an order of their own.
  std::stable_sort(primvars.begin(), primvars.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return primvars;
}

}  // namespace

HdDirtyBits CommonDirtyBits() {
  return HdChangeTracker::Clean | HdChangeTracker::InitRepr | HdChangeTracker::DirtyTransform |
         HdChangeTracker::DirtyVisibility | HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyMaterialId |
         HdChangeTracker::DirtyDoubleSided | HdChangeTracker::DirtyPrimID | HdChangeTracker::DirtyRenderTag |
         HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex | HdChangeTracker::DirtyNormals |
         HdChangeTracker::DirtyPoints;
}

void ReadCommon(HdSceneDelegate& sceneDelegate, RenderParam& param, const HdRprim& rprim, HdDirtyBits bits,
                delegate::GprimUpdate& update, VtValue* points) {
  const SdfPath& id = rprim.GetId();
  // Points that move change no other primvar, unless computations say so: skinning turns normals as well.
  const bool computed = HdChangeTracker::IsAnyPrimvarDirty(bits, id) && HasComputed(sceneDelegate, id);
  if (computed || bits & (HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyNormals))
    update.primvars = ReadPrimvars(sceneDelegate, id);
  if (computed) ReadComputed(sceneDelegate, id, *update.primvars, points);
  if (HdChangeTracker::IsTransformDirty(bits, id))
    update.transforms = {{0, ToMatrix(sceneDelegate.GetTransform(id))}};
  if (bits & HdChangeTracker::DirtyMaterialId) update.material = rprim.GetMaterialId().GetString();
  if (HdChangeTracker::IsVisibilityDirty(bits, id)) update.visible = rprim.IsVisible();
  if (HdChangeTracker::IsDoubleSidedDirty(bits, id)) update.doubleSided = sceneDelegate.GetDoubleSided(id);
  if (HdChangeTracker::IsPrimIdDirty(bits, id)) update.primId = rprim.GetPrimId();
  if (bits & HdChangeTracker::DirtyRenderTag) update.renderTag = rprim.GetRenderTag().GetString();
  if (bits & (HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex)) {
    const InstancerLink link = SyncInstancer(sceneDelegate, param, rprim.GetInstancerId(), id);
    update.instancer = link.instancer;
    update.prototype = link.prototype;
  }
}

template <typename Base, typename Update>
void Rprim<Base, Update>::Finalize(HdRenderParam* renderParam) {
  Param(renderParam).core().DestroyRprim(this->GetId().GetString());
  Param(renderParam).MarkEdited();
}

template <typename Base, typename Update>
void Rprim<Base, Update>::UpdateRenderTag(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam) {
  HdRprim::UpdateRenderTag(sceneDelegate, renderParam);
  Update update;
  update.renderTag = this->GetRenderTag().GetString();
  Param(renderParam).Edit(this->GetId(), std::move(update));
}

template <typename Base, typename Update>
void Rprim<Base, Update>::Prologue(HdSceneDelegate* sceneDelegate, HdRenderParam*, HdDirtyBits* dirtyBits) {
  const HdDirtyBits bits = *dirtyBits;
  this->_UpdateVisibility(sceneDelegate, dirtyBits);
  this->_UpdateInstancer(sceneDelegate, dirtyBits);
  if (bits & HdChangeTracker::DirtyMaterialId) this->SetMaterialId(sceneDelegate->GetMaterialId(this->GetId()));
}

template class Rprim<HdMesh, delegate::MeshUpdate>;
template class Rprim<HdRprim, delegate::ImplicitUpdate>;

}  // namespace hydra
