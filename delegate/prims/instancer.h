// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Instancers: native instances and PointInstancers, nested by their parents, composed in double.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "delegate/prims/gprim.h"

namespace delegate {

// Raw arrays as authored. Either `transforms` (native instances: each instance's root) or the PointInstancer's arrays.
// Arrays may be empty; lengths that disagree give a diagnostic and the shortest counts.
struct InstancerUpdate {
  std::optional<TimeSamples<std::vector<wavefront::Matrix4d>>> transforms;
  std::optional<TimeSamples<std::vector<wavefront::Float3>>> positions;
  std::optional<TimeSamples<std::vector<wavefront::Float4>>> orientations;  // x, y, z = imaginary, w = real
  std::optional<TimeSamples<std::vector<wavefront::Float3>>> scales;
  std::optional<std::vector<int32_t>> protoIndices;   // empty: every prototype at every instance
  // Which instances draw a prototype, where a host knows it by prototype (Hydra does): not empty, this counts and
  // protoIndices, ids and invisibleIds do not. A prototype that is missing is drawn nowhere.
  std::optional<std::map<int32_t, std::vector<int32_t>>> prototypeInstances;
  std::optional<std::vector<int64_t>> ids;            // empty: 0, 1, 2 ...
  std::optional<std::vector<int64_t>> invisibleIds;   // invisible or inactive: not drawn
  std::optional<TimeSamples<wavefront::Matrix4d>> transform;  // own: to world, or to the parent's prototype root
  std::optional<std::vector<PrimvarInput>> primvars;  // the whole set; interpolation "instance" or "constant"
  std::optional<bool> visible;
  std::optional<std::string> parent;                  // path of the instancer above; empty: none
  std::optional<int32_t> parentPrototype;
};

// An instancer's state, defaults filled in.
struct InstancerState {
  std::string path;
  TimeSamples<std::vector<wavefront::Matrix4d>> transforms;
  TimeSamples<std::vector<wavefront::Float3>> positions;
  TimeSamples<std::vector<wavefront::Float4>> orientations;
  TimeSamples<std::vector<wavefront::Float3>> scales;
  std::vector<int32_t> protoIndices;
  std::map<int32_t, std::vector<int32_t>> prototypeInstances;
  std::vector<int64_t> ids, invisibleIds;
  TimeSamples<wavefront::Matrix4d> transform{{0, {}}};
  std::vector<PrimvarInput> primvars;
  bool visible = true;
  std::string parent;
  int32_t parentPrototype = 0;
};

// The instances of one prototype, flattened over the chain of instancers, outer ones slowest; each keeps its place
// whatever else is invisible. `indices` (the instanceId AOV): the index in the innermost instancer, or the place in
// prototypeInstances' list where that is told, plus its length times that of the next outer one, and so on.
struct FlatInstances {
  TimeSamples<std::vector<wavefront::Matrix4d>> transforms;  // prototype root to world
  std::vector<int32_t> indices;
  std::vector<wavefront::PrimvarData> primvars;              // Instance or Constant
};

// chain[0] draws the prototype, chain[1] is its parent, and so on; prototypes[k] is the prototype index in chain[k].
// Pure; uses up to `threads` threads for large counts. Instances whose matrix is not finite are left out, with one
// diagnostic.
FlatInstances ComposeInstances(const std::vector<const InstancerState*>& chain, const std::vector<int32_t>& prototypes,
                               unsigned threads, const wavefront::DiagnosticSink& sink);

}  // namespace delegate
