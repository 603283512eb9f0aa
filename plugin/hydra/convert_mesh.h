// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Topology and shapes as the delegate takes them. Pure.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <pxr/imaging/hd/meshTopology.h>
#include <pxr/imaging/pxOsd/subdivTags.h>

#include "delegate/mesh/implicit.h"
#include "delegate/mesh/mesh_input.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// Subsets of faces; others (points, edges) wear no material.
delegate::MeshTopology ToTopology(const HdMeshTopology& topology, const PxOsdSubdivTags& tags);
// Materials by the topology's subsets; those without one take the prim's.
std::vector<std::string> ToSubsetMaterials(const HdMeshTopology& topology, const SdfPath& primMaterial);

// Hydra's types of implicit surfaces; nothing for other types.
std::optional<delegate::ImplicitShape> ToImplicitShape(const TfToken& type);
// `value` reads an attribute by its name in UsdGeom's schema; empty keeps the fallback of that shape.
delegate::ImplicitInput ToImplicit(delegate::ImplicitShape shape, const std::function<VtValue(const TfToken&)>& value);

}  // namespace hydra
