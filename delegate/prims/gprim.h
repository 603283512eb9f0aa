// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What a host says about a thing that can be drawn. Updates carry only what is dirty; an equal value marks nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "delegate/mesh/implicit.h"
#include "delegate/mesh/mesh_input.h"
#include "wavefront/scene.h"

namespace delegate {

template <typename T>
using TimeSamples = std::vector<wavefront::TimeSample<T>>;  // never empty; length 1: still

// Common to every Rprim.
struct GprimUpdate {
  std::optional<std::vector<PrimvarInput>> primvars;              // the whole set
  std::optional<TimeSamples<wavefront::Matrix4d>> transforms;     // object to world, or to the prototype's root
  std::optional<std::string> material;                            // path; empty: none
  std::optional<bool> visible;
  std::optional<std::string> renderTag;                           // geometry, proxy, render, guide
  std::optional<bool> doubleSided;
  std::optional<std::string> instancer;                           // path; empty: drawn once
  std::optional<int32_t> prototype;                               // value in the instancer's protoIndices
  std::optional<int32_t> primId;                                  // AOV; by order of creation where never given
};

struct MeshUpdate : GprimUpdate {
  std::optional<MeshTopology> topology;
  std::optional<TimeSamples<std::vector<wavefront::Float3>>> points;
  std::optional<std::vector<std::string>> subsetMaterials;        // by topology.subsets
  std::optional<int> refineLevel;
};

// Sphere, Cube, Cone, Cylinder, Capsule, Plane. `shape.path` and `shape.doubleSided` are ignored.
struct ImplicitUpdate : GprimUpdate {
  std::optional<ImplicitInput> shape;
};

}  // namespace delegate
