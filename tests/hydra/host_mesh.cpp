// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/hydra/host_mesh.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/usd/usd/attribute.h>
#include <pxr/usd/usd/prim.h>
#include <pxr/usd/usd/stage.h>
#include <pxr/usdImaging/usdImaging/adapterRegistry.h>
#include <pxr/usdImaging/usdImaging/capsuleAdapter.h>
#include <pxr/usdImaging/usdImaging/coneAdapter.h>
#include <pxr/usdImaging/usdImaging/cubeAdapter.h>
#include <pxr/usdImaging/usdImaging/cylinderAdapter.h>
#include <pxr/usdImaging/usdImaging/planeAdapter.h>
#include <pxr/usdImaging/usdImaging/sphereAdapter.h>

#include <memory>
#include <stdexcept>

namespace hydra_test {
namespace {

using delegate::ImplicitInput;
using delegate::ImplicitShape;

const char* SchemaOf(const ImplicitInput& s) {
  const bool hasTwoRadii = s.radiusTop >= 0 || s.radiusBottom >= 0;
  switch (s.shape) {
    case ImplicitShape::Sphere: return "Sphere";
    case ImplicitShape::Cube: return "Cube";
    case ImplicitShape::Cone: return "Cone";
    case ImplicitShape::Cylinder: return hasTwoRadii ? "Cylinder_1" : "Cylinder";
    case ImplicitShape::Capsule: return hasTwoRadii ? "Capsule_1" : "Capsule";
    case ImplicitShape::Plane: break;
  }
  return "Plane";
}

struct ShapePrim {
  UsdStageRefPtr stage = UsdStage::CreateInMemory();
  UsdPrim prim;

  explicit ShapePrim(const ImplicitInput& s) : prim(stage->DefinePrim(SdfPath("/shape"), TfToken(SchemaOf(s)))) {
    const std::pair<const char*, double> sizes[] = {
        {"size", s.size},     {"radius", s.radius}, {"radiusTop", s.radiusTop}, {"radiusBottom", s.radiusBottom},
        {"height", s.height}, {"width", s.width},   {"length", s.length}};
    for (const auto& [name, value] : sizes)
      if (const UsdAttribute attribute = prim.GetAttribute(TfToken(name))) attribute.Set(value);
    if (const UsdAttribute axis = prim.GetAttribute(TfToken("axis"))) axis.Set(TfToken(s.axis));
  }

  // What the adapter of the prim's schema makes of it. By qualified calls: where adapters keep their virtual functions
  // depends on the version.
  template <typename Adapter>
  HostMesh Read() const {
    const auto made = UsdImagingAdapterRegistry::GetInstance().ConstructAdapter(prim.GetTypeName());
    if (!made) throw std::runtime_error("UsdImaging has no adapter for " + prim.GetTypeName().GetString());
    const auto adapter = std::static_pointer_cast<Adapter>(made);
    const VtValue topology = adapter->Adapter::GetTopology(prim, prim.GetPath(), UsdTimeCode::Default());
    const VtValue points = adapter->Adapter::GetPoints(prim, UsdTimeCode::Default());
    return {topology.Get<HdMeshTopology>(), points.Get<VtVec3fArray>()};
  }
};

}  // namespace

HostMesh MeshOfHost(const ImplicitInput& shape) {
  const ShapePrim prim(shape);
  switch (shape.shape) {
    case ImplicitShape::Sphere: return prim.Read<UsdImagingSphereAdapter>();
    case ImplicitShape::Cube: return prim.Read<UsdImagingCubeAdapter>();
    case ImplicitShape::Cone: return prim.Read<UsdImagingConeAdapter>();
    case ImplicitShape::Cylinder: return prim.Read<UsdImagingCylinderAdapter>();
    case ImplicitShape::Capsule: return prim.Read<UsdImagingCapsuleAdapter>();
    case ImplicitShape::Plane: break;
  }
  return prim.Read<UsdImagingPlaneAdapter>();
}

}  // namespace hydra_test
