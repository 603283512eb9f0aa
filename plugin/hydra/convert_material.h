// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Material networks. Pure.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <pxr/imaging/hd/material.h>

#include "delegate/prims/material.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// Hydra hands over one network, that of the best context it found; which one that was shows in its nodes. Nodes come in
// the order in which the Python host walks: depth first from the surface. Messages are (code, text).
struct ConvertedMaterial {
  delegate::MaterialUpdate update;  // without a context where there is no surface, which the core tells
  std::vector<std::pair<const char*, std::string>> messages;
};
ConvertedMaterial ToMaterial(const SdfPath& id, const HdMaterialNetworkMap& networks);

}  // namespace hydra
