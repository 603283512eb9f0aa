// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// `RayCaster` for the benchmark: given rays through the renderer's trees and traversal.
#include "wavefront/ray_caster.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "plugin/python/src/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Rows3 = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Indices3 = nb::ndarray<const uint32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

template <typename T>
nb::object ToNumpy(std::vector<T> values) {
  auto* kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  const size_t shape[1] = {kept->size()};
  return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), 1, shape, owner));
}

class PythonRayCaster {
 public:
  PythonRayCaster(const Rows3& points, const Indices3& triangles, const std::string& device) {
    nb::gil_scoped_release release;
    auto made = wavefront::RayCaster::Create(
        device, {reinterpret_cast<const wavefront::Float3*>(points.data()), points.shape(0)},
        {reinterpret_cast<const wavefront::UInt3*>(triangles.data()), triangles.shape(0)});
    if (made) caster_ = std::move(made).value();
    else why_ = made.error().message;
  }

  void SetRays(const Rows3& origins, const Rows3& directions) {
    if (!caster_) RaiseRuntime(why_);
    if (origins.shape(0) != directions.shape(0)) RaiseValue("as many origins as directions");
    std::vector<wavefront::CasterRay> rays(origins.shape(0));
    for (size_t i = 0; i < rays.size(); ++i) {
      std::memcpy(&rays[i].origin, origins.data() + 3 * i, sizeof rays[i].origin);
      std::memcpy(&rays[i].direction, directions.data() + 3 * i, sizeof rays[i].direction);
      rays[i].tMax = std::numeric_limits<float>::infinity();
    }
    Must([&] { return caster_->SetRays(rays); });
  }

  void Cast() {
    if (!caster_) RaiseRuntime(why_);
    Must([&] { return caster_->Cast(); });
  }

  nb::tuple Hits() {
    if (!caster_) RaiseRuntime(why_);
    auto hits = caster_->Hits();
    if (!hits) RaiseRuntime(hits.error().message);
    std::vector<float> t;
    std::vector<int32_t> triangle;
    for (const wavefront::CasterHit& hit : hits.value()) {
      t.push_back(hit.t);
      triangle.push_back(static_cast<int32_t>(hit.triangle));
    }
    return nb::make_tuple(ToNumpy(std::move(t)), ToNumpy(std::move(triangle)));
  }

 private:
  template <typename F>
  void Must(F f) {
    wavefront::Status status;
    {
      nb::gil_scoped_release release;
      status = f();
    }
    if (!status) RaiseRuntime(status.error().message);
  }

  std::unique_ptr<wavefront::RayCaster> caster_;
  std::string why_;
};

}  // namespace

void BindRayCaster(nb::module_& module) {
  nb::class_<PythonRayCaster>(module, "RayCaster")
      .def(nb::init<const Rows3&, const Indices3&, const std::string&>(), "points"_a, "triangles"_a, "device"_a = "")
      .def("set_rays", &PythonRayCaster::SetRays, "origins"_a, "directions"_a)
      .def("cast", &PythonRayCaster::Cast)
      .def("hits", &PythonRayCaster::Hits);
}
