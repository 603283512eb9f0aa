// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The light tree: a binary tree over light items by which the light that is likely to matter at a point is picked in
// logarithmic time (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018;
// Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 12.6). Kernels walk it: lib/lights/light_tree.glsl.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace wavefront {

// Where an item shines from and to. Space: world, relative to the scene's origin.
struct LightBounds {
  float min[3], max[3];        // box around it
  float axis[3] = {0, 0, 1};   // unit: about which its normals lie
  float normals = 3.14159265f; // largest angle between a normal and the axis, radians; pi: all round
  float emission = 1.57079633f;// largest angle between a normal and a direction that light leaves to, radians
  bool twoSided = false;       // light leaves to both sides of its surface
  double power = 0;            // what it weighs; above 0
  uint32_t item = 0;           // index of its light item
};

struct LightTree {
  std::vector<uint32_t> nodes;   // kLightNodeTexels texels each, root first, siblings side by side; see scene_layout.h
  std::vector<uint32_t> trails;  // per LightBounds: bit d tells the child (0 or 1) at depth d on the way to its leaf
};

// Pure: the same lights in the same order give the same tree. No trail is longer than 32. `lights` is not empty.
LightTree BuildLightTree(std::span<const LightBounds> lights);

}  // namespace wavefront
