// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/mesh_content.h"

#include <algorithm>

#include "wavefront/base/hash.h"

namespace wavefront {
namespace {

template <typename T>
ArrayContent Content(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.size(), HashBytes(bytes)};
}

}  // namespace

MeshContent ContentOf(const MeshData& mesh) {
  MeshContent content{Content(mesh.positions), Content(mesh.triangles), Content(mesh.materialSlots), Content(mesh.faceIds), {}};
  for (const PrimvarData& p : mesh.primvars)
    content.primvars.push_back({p.name, p.interpolation, p.components, Content(p.values), Content(p.indices)});
  return content;
}

bool SameSizes(const MeshContent& a, const MeshContent& b) {
  return a.triangles.bytes == b.triangles.bytes && a.faceIds.bytes == b.faceIds.bytes &&
         std::equal(a.primvars.begin(), a.primvars.end(), b.primvars.begin(), b.primvars.end(), [](const PrimvarContent& x, const PrimvarContent& y) {
           return x.name == y.name && x.interpolation == y.interpolation && x.components == y.components &&
                  x.values.bytes == y.values.bytes && x.indices.bytes == y.indices.bytes;
         });
}

}  // namespace wavefront
