// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <string>

#include <pxr/imaging/hd/instancer.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

class RenderParam;

// Raw arrays to the delegate, which composes them; nested instancers too.
class Instancer final : public HdInstancer {
 public:
  Instancer(HdSceneDelegate* sceneDelegate, const SdfPath& id) : HdInstancer(sceneDelegate, id) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
  void Finalize(HdRenderParam* renderParam) override;
};

struct InstancerLink {
  std::string instancer;  // path; empty: none
  int32_t prototype = 0;
};
// Hydra syncs instancers on behalf of the prims they draw: brings the chain above `prototype` up to date, and tells
// which of its instances draw it.
InstancerLink SyncInstancer(HdSceneDelegate& sceneDelegate, RenderParam& param, const SdfPath& instancer,
                            const SdfPath& prototype);

}  // namespace hydra
