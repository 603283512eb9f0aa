// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/instancer.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include <algorithm>

#include "plugin/hydra/convert_instancer.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/render_param.h"

namespace hydra {
namespace {

// Instances that some index names: how many an instancer has that says nothing else about them.
size_t CountOf(const VtIntArray& indices) {
  int highest = -1;
  for (const int index : indices) highest = std::max(highest, index);
  return static_cast<size_t>(highest + 1);
}

}  // namespace

HdDirtyBits Instancer::GetInitialDirtyBitsMask() const {
  return HdChangeTracker::DirtyTransform | HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyInstanceIndex |
         HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyVisibility;
}

void Instancer::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
  RenderParam& param = Param(renderParam);
  const SdfPath& id = GetId();
  const HdDirtyBits bits = *dirtyBits;
  _UpdateInstancer(sceneDelegate, dirtyBits);
  delegate::InstancerUpdate update;
  if (bits & (HdChangeTracker::DirtyTransform | HdChangeTracker::DirtyInstancer))
    update.transform = {{0, ToMatrix(sceneDelegate->GetInstancerTransform(id))}};
  if (HdChangeTracker::IsAnyPrimvarDirty(bits, id) || bits & HdChangeTracker::DirtyInstanceIndex) {
    size_t count = 0;
    for (const SdfPath& prototype : sceneDelegate->GetInstancerPrototypes(id))
      count = std::max(count, CountOf(sceneDelegate->GetInstanceIndices(id, prototype)));
    const HdPrimvarDescriptorVector primvars = sceneDelegate->GetPrimvarDescriptors(id, HdInterpolationInstance);
    ToInstances(
        primvars,
        [&](const HdPrimvarDescriptor& primvar, VtIntArray* indices) {
          return primvar.indexed ? sceneDelegate->GetIndexedPrimvar(id, primvar.name, indices)
                                 : sceneDelegate->Get(id, primvar.name);
        },
        count, update);
  }
  if (bits & HdChangeTracker::DirtyVisibility) update.visible = sceneDelegate->GetVisible(id);
  if (bits & (HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex)) {
    const InstancerLink parent = SyncInstancer(*sceneDelegate, param, GetParentId(), id);
    update.parent = parent.instancer;
    update.parentPrototype = parent.prototype;
  }
  param.Edit(id, std::move(update));
  *dirtyBits = HdChangeTracker::Clean;
}

void Instancer::Finalize(HdRenderParam* renderParam) {
  RenderParam& param = Param(renderParam);
  param.core().DestroyInstancer(GetId().GetString());
  param.ForgetInstancer(GetId());
  param.MarkEdited();
}

InstancerLink SyncInstancer(HdSceneDelegate& sceneDelegate, RenderParam& param, const SdfPath& instancer,
                            const SdfPath& prototype) {
  if (instancer.IsEmpty()) return {};
  HdInstancer::_SyncInstancerAndParents(sceneDelegate.GetRenderIndex(), instancer);
  param.SetInstances(instancer, prototype, ToInts(sceneDelegate.GetInstanceIndices(instancer, prototype)));
  return {instancer.GetString(), param.PrototypeId(prototype)};
}

}  // namespace hydra
