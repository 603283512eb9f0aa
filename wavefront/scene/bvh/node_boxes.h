// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Boxes of a node's children: quantised when a tree is built or refitted, read back when it is judged.
#pragma once

#include <span>

#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/bvh/vector4.h"

namespace wavefront::bvh {

// Sets the node's origin, steps and planes so that the box of each child holds boxes[child] exactly. `boxes`: one for each
// of the node's children, none of them empty.
void QuantiseBoxes(BvhNode4& node, std::span<const Box4> boxes);

// Half the surface of a child's box as it is quantised.
double QuantisedHalfArea(const BvhNode4& node, uint32_t child);

}  // namespace wavefront::bvh
