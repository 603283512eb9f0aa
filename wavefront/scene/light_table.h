// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Light records, light items and the distribution from which the logic kernel picks one.
#pragma once

#include <cstdint>
#include <vector>

#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"
#include "wavefront/scene/texture_store.h"
#include "wavefront/scene/transforms.h"

namespace wavefront {

// An emissive instance's triangles, in mesh order; filled by the scene commit.
struct EmissiveTriangles {
  uint32_t instance = 0;
  std::vector<uint32_t> records;  // absolute triangle record of each mesh triangle; kNoLight: does not emit
  std::vector<float> areas;       // world
  std::vector<Float3> corners;    // three of each mesh triangle, world, relative to the scene's origin
  uint32_t itemBase = 0;          // out: first item
};

// A light that rays can hit: an instance of a unit shape.
struct LightShape {
  uint32_t kind = 0, light = 0;
  Matrix4d transform;
  bool visibleToCamera = true;
};

// What kernels need code for where a light is so: a bit for its type, and these.
constexpr uint32_t LightTraitOf(LightType type) { return 1u << static_cast<uint32_t>(type); }
constexpr uint32_t kLightTraitShaped = 1u << 30, kLightTraitTextured = 1u << 31;

struct LightTable {
  std::vector<Float4> records;        // kLightTexels per light
  std::vector<uint32_t> items;        // 4 words per item, then the light tree
  std::vector<float> distribution;    // CDF over items (with a tree: over lights at infinity and the tree), then dome maps
  std::vector<LightShape> shapes;
  uint32_t lightCount = 0, infiniteCount = 0, itemCount = 0;
  uint32_t traits = 0;                // of all lights
  uint32_t tree = 0;                  // first texel of the light tree among the items; 0: there is none
};

// Lights are ordered infinite first, then by path. `sceneRadius` weighs distant and dome lights against area lights.
// Lights that cannot shine (singular transform, no area, not finite) give a diagnostic and are left out.
// A light tree is built as `sampling` says; Auto: where more than kHandfulOfLights items at finite places shine.
// A dome of one colour is never picked: bounce rays find it wherever they go, and prefer directions that matter to the
// surface. Light that throws no shadows (a light's own wish, or not `shadows`) bounce rays do not count, so it is picked.
constexpr std::size_t kHandfulOfLights = 8;
LightTable BuildLightTable(std::vector<LightData> lights, std::vector<EmissiveTriangles>& emissive, TextureStore& textures,
                           const Double3& origin, double sceneRadius, LightSampling sampling, bool shadows, const DiagnosticSink& sink);

}  // namespace wavefront
