// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The BVH builder for tests in Python: arrays in, arrays of texels out, as the kernels read them.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstring>

#include "wavefront/base/check.h"
#include "wavefront/scene/bvh/bvh.h"

namespace nb = nanobind;

namespace {

using namespace wavefront;

using FloatArray = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using IndexArray = nb::ndarray<const uint32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using SlotArray = nb::ndarray<const uint16_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using MatrixArray = nb::ndarray<const float, nb::shape<-1, 3, 4>, nb::c_contig, nb::device::cpu>;

// A new numpy array of rows of `columns` 32-bit words with the bytes of `items`.
template <typename T, typename Word>
nb::object ToArray(const std::vector<T>& items, size_t columns) {
  const size_t bytes = items.size() * sizeof(T);
  auto* words = new Word[bytes / sizeof(Word) + 1];
  if (bytes > 0) std::memcpy(words, items.data(), bytes);
  nb::capsule owner(words, [](void* p) noexcept { delete[] static_cast<Word*>(p); });
  const size_t shape[2] = {bytes / sizeof(Word) / columns, columns};
  return nb::cast(nb::ndarray<nb::numpy, Word>(words, 2, shape, owner));
}

bvh::Rows3x4 RowsOf(const float* p) {
  bvh::Rows3x4 rows;
  std::memcpy(static_cast<void*>(&rows), p, sizeof rows);
  return rows;
}

nb::tuple BoundsToTuple(const Bounds3& b) {
  return nb::make_tuple(nb::make_tuple(b.min.x, b.min.y, b.min.z), nb::make_tuple(b.max.x, b.max.y, b.max.z));
}

nb::tuple BuildMesh(const FloatArray& positions, const IndexArray& triangles, const SlotArray& slots,
                    unsigned threads, bool spatialSplits) {
  if (slots.shape(0) != 0 && slots.shape(0) != triangles.shape(0)) throw nb::value_error("one slot per triangle");
  bvh::MeshBvh mesh;
  {
    nb::gil_scoped_release unlocked;
    mesh = bvh::BuildMeshBvh({reinterpret_cast<const Float3*>(positions.data()), positions.shape(0)},
                             {reinterpret_cast<const UInt3*>(triangles.data()), triangles.shape(0)},
                             {slots.data(), slots.shape(0)}, {threads, spatialSplits});
  }
  return nb::make_tuple(ToArray<bvh::BvhNode4, uint32_t>(mesh.nodes, 4),
                        ToArray<bvh::TriangleRecord, float>(mesh.triangles, 4), BoundsToTuple(mesh.bounds),
                        mesh.brokenTriangles);
}

nb::tuple BuildInstances(const FloatArray& lows, const FloatArray& highs) {
  if (lows.shape(0) != highs.shape(0)) throw nb::value_error("as many low as high corners");
  std::vector<Bounds3> bounds(lows.shape(0));
  for (size_t i = 0; i < bounds.size(); ++i) {
    std::memcpy(static_cast<void*>(&bounds[i].min), lows.data() + 3 * i, sizeof(Float3));
    std::memcpy(static_cast<void*>(&bounds[i].max), highs.data() + 3 * i, sizeof(Float3));
  }
  const bvh::InstanceBvh tree = bvh::BuildInstanceBvh(bounds);
  return nb::make_tuple(ToArray<bvh::BvhNode4, uint32_t>(tree.nodes, 4), tree.skipped);
}

nb::tuple InstanceBounds(const FloatArray& objectBounds, const MatrixArray& transforms) {
  if (objectBounds.shape(0) != 2 || transforms.shape(0) != 2) throw nb::value_error("two corners, two matrices");
  Bounds3 object;
  std::memcpy(static_cast<void*>(&object), objectBounds.data(), sizeof object);
  return BoundsToTuple(bvh::InstanceBounds(object, RowsOf(transforms.data()), RowsOf(transforms.data() + 12)));
}

nb::tuple LightShapeBounds(uint32_t kind) {
  if (kind < 1 || kind > 4) throw nb::value_error("kinds 1 (rect) to 4 (cylinder)");
  return BoundsToTuple(bvh::LightShapeBounds(kind));
}

}  // namespace

void bindBvh(nb::module_& module) {
  static_assert(sizeof(Float3) == 12 && sizeof(UInt3) == 12 && sizeof(Bounds3) == 24 && sizeof(bvh::Rows3x4) == 48);
  module.def("build_mesh_bvh", &BuildMesh, nb::arg("positions"), nb::arg("triangles"), nb::arg("slots"),
             nb::arg("threads") = 0, nb::arg("spatial_splits") = true,
             "Node texels (uint32, 4 a row), triangle texels (float32, 4 a row), (low, high), broken triangles.");
  module.def("build_instance_bvh", &BuildInstances, nb::arg("lows"), nb::arg("highs"),
             "Node texels of the tree over instances, and how many were skipped.");
  module.def("instance_bounds", &InstanceBounds, nb::arg("object_bounds"), nb::arg("transforms"),
             "World bounds (low, high) from object bounds and [object to world, world to object] rows.");
  module.def("light_shape_bounds", &LightShapeBounds, nb::arg("kind"));
}
