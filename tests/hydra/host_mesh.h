// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The meshes that UsdImaging makes of implicit shapes with scene-index mode off, asked of its own adapters.
#pragma once

#include <pxr/base/gf/vec3f.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/meshTopology.h>

#include "delegate/mesh/implicit.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra_test {

PXR_NAMESPACE_USING_DIRECTIVE

struct HostMesh {
  HdMeshTopology topology;
  VtVec3fArray points;
};

HostMesh MeshOfHost(const delegate::ImplicitInput& shape);

}  // namespace hydra_test
