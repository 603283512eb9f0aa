// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// With scene-index mode off UsdImaging hands over a coarse mesh of its own making for each Sphere, Cube, Cone,
// Cylinder, Capsule and Plane. Here such a mesh is known for what it is. A mesh counts as a shape if, and only if,
//   1. its topology, scheme and orientation included, equals what UsdImaging's adapter of that shape gives,
//   2. the host knows all attributes of that shape by this prim: a prim of type Mesh has none of them, and
//   3. its points are exactly what the host's own generator makes of those attributes.
// Everything else stays the mesh that it is. Pure.
#pragma once

#include <functional>
#include <optional>

#include <pxr/base/gf/vec3f.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/meshTopology.h>

#include "delegate/mesh/implicit.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// 1: the shape that has this topology.
std::optional<delegate::ImplicitShape> ShapeOfTopology(const HdMeshTopology& topology);

// 2 and 3: the shape with its sizes. `attribute` reads an attribute of the prim; empty: it has none of that name.
std::optional<delegate::ImplicitInput> RecognizeImplicit(delegate::ImplicitShape shape, const VtValue& points,
                                                         const std::function<VtValue(const TfToken&)>& attribute);

}  // namespace hydra
