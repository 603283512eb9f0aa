// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/implicit_mesh.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/imaging/geomUtil/capsuleMeshGenerator.h>
#include <pxr/imaging/geomUtil/coneMeshGenerator.h>
#include <pxr/imaging/geomUtil/cuboidMeshGenerator.h>
#include <pxr/imaging/geomUtil/cylinderMeshGenerator.h>
#include <pxr/imaging/geomUtil/sphereMeshGenerator.h>
#include <pxr/imaging/pxOsd/meshTopology.h>
#include <pxr/imaging/pxOsd/tokens.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "plugin/hydra/convert_mesh.h"
#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

using delegate::ImplicitInput;
using delegate::ImplicitShape;

// numRadial, numAxial and numCapAxial of UsdImaging{Sphere,Cone,Cylinder,Capsule}Adapter.
constexpr size_t kRadial = 10, kAxial = 10, kCapAxial = 4;

PxOsdMeshTopology TopologyOf(ImplicitShape shape) {
  switch (shape) {
    case ImplicitShape::Sphere: return GeomUtilSphereMeshGenerator::GenerateTopology(kRadial, kAxial);
    case ImplicitShape::Cube: return GeomUtilCuboidMeshGenerator::GenerateTopology();
    case ImplicitShape::Cone: return GeomUtilConeMeshGenerator::GenerateTopology(kRadial);
    case ImplicitShape::Cylinder: return GeomUtilCylinderMeshGenerator::GenerateTopology(kRadial);
    case ImplicitShape::Capsule: return GeomUtilCapsuleMeshGenerator::GenerateTopology(kRadial, kCapAxial);
    case ImplicitShape::Plane: break;
  }
  // UsdImagingGetPlaneTopology
  return PxOsdMeshTopology(PxOsdOpenSubdivTokens->bilinear, PxOsdOpenSubdivTokens->rightHanded, {4}, {0, 1, 2, 3});
}

// Attributes that UsdGeom's schemas have, by shape: one of these sets, whole.
std::vector<std::vector<const char*>> AttributesOf(ImplicitShape shape) {
  switch (shape) {
    case ImplicitShape::Sphere: return {{"radius"}};
    case ImplicitShape::Cube: return {{"size"}};
    case ImplicitShape::Cone: return {{"radius", "height", "axis"}};
    case ImplicitShape::Cylinder:
    case ImplicitShape::Capsule:
      return {{"radius", "height", "axis"}, {"radiusTop", "radiusBottom", "height", "axis"}};
    case ImplicitShape::Plane: break;
  }
  return {{"width", "length", "axis"}};
}

// UsdImagingGprimAdapter::GetImplicitBasis: the generators' Z to the spine.
GfMatrix4d Basis(const std::string& axis) {
  if (axis == "X") return {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1};
  if (axis == "Y") return {0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  return GfMatrix4d(1);
}

// UsdImagingGeneratePlaneMeshPoints
VtVec3fArray PlanePoints(double width, double length, const std::string& axis) {
  VtVec3fArray points;
  for (const auto& [u, v] : {std::pair(0.5, 0.5), std::pair(-0.5, 0.5), std::pair(-0.5, -0.5), std::pair(0.5, -0.5)}) {
    if (axis == "X") points.push_back(GfVec3f(GfVec3d(0, u * length, v * width)));
    // Seen from above Y the corners go the other way round: they begin at the left.
    else if (axis == "Y") points.push_back(GfVec3f(GfVec3d(-u * width, 0, v * length)));
    else points.push_back(GfVec3f(GfVec3d(u * width, v * length, 0)));
  }
  return points;
}

VtVec3fArray PointsOf(const ImplicitInput& s) {
  const double bottom = s.radiusBottom < 0 ? s.radius : s.radiusBottom;
  const double top = s.radiusTop < 0 ? s.radius : s.radiusTop;
  const GfMatrix4d basis = Basis(s.axis);
  VtVec3fArray points;
  switch (s.shape) {
    case ImplicitShape::Sphere:
      points.resize(GeomUtilSphereMeshGenerator::ComputeNumPoints(kRadial, kAxial));
      GeomUtilSphereMeshGenerator::GeneratePoints(points.begin(), kRadial, kAxial, s.radius);
      break;
    case ImplicitShape::Cube:
      points.resize(GeomUtilCuboidMeshGenerator::ComputeNumPoints());
      GeomUtilCuboidMeshGenerator::GeneratePoints(points.begin(), s.size, s.size, s.size);
      break;
    case ImplicitShape::Cone:
      points.resize(GeomUtilConeMeshGenerator::ComputeNumPoints(kRadial));
      GeomUtilConeMeshGenerator::GeneratePoints(points.begin(), kRadial, s.radius, s.height, &basis);
      break;
    case ImplicitShape::Cylinder:
      points.resize(GeomUtilCylinderMeshGenerator::ComputeNumPoints(kRadial));
      GeomUtilCylinderMeshGenerator::GeneratePoints(points.begin(), kRadial, bottom, top, s.height, &basis);
      break;
    case ImplicitShape::Capsule:
      points.resize(GeomUtilCapsuleMeshGenerator::ComputeNumPoints(kRadial, kCapAxial));
      GeomUtilCapsuleMeshGenerator::GeneratePoints(points.begin(), kRadial, kCapAxial, bottom, top, s.height, &basis);
      break;
    case ImplicitShape::Plane: points = PlanePoints(s.width, s.length, s.axis); break;
  }
  return points;
}

}  // namespace

std::optional<ImplicitShape> ShapeOfTopology(const HdMeshTopology& topology) {
  static const auto known = [] {
    std::vector<std::pair<ImplicitShape, PxOsdMeshTopology>> all;
    for (const ImplicitShape shape : {ImplicitShape::Sphere, ImplicitShape::Cube, ImplicitShape::Cone,
                                      ImplicitShape::Cylinder, ImplicitShape::Capsule, ImplicitShape::Plane})
      all.emplace_back(shape, TopologyOf(shape));
    return all;
  }();
  if (!topology.GetGeomSubsets().empty()) return std::nullopt;
  for (const auto& [shape, its] : known)
    if (topology.GetFaceVertexCounts().size() == its.GetFaceVertexCounts().size() &&
        topology.GetPxOsdMeshTopology() == its)
      return shape;
  return std::nullopt;
}

std::optional<ImplicitInput> RecognizeImplicit(ImplicitShape shape, const VtValue& points,
                                               const std::function<VtValue(const TfToken&)>& attribute) {
  if (!points.IsHolding<VtVec3fArray>()) return std::nullopt;
  const auto has = [&](const std::vector<const char*>& names) {
    return std::ranges::all_of(names, [&](const std::string& name) {
      const VtValue value = attribute(TfToken(name));
      return name == "axis" ? !ToString(value).empty() : ToNumber(value).has_value();  // not an array: no primvar
    });
  };
  bool known = false;
  for (const auto& names : AttributesOf(shape)) known = known || has(names);
  if (!known) return std::nullopt;
  const ImplicitInput input = ToImplicit(shape, attribute);
  if (points.UncheckedGet<VtVec3fArray>() != PointsOf(input)) return std::nullopt;
  return input;
}

}  // namespace hydra
