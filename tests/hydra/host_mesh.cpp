// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/hydra/host_mesh.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/imaging/geomUtil/capsuleMeshGenerator.h>
#include <pxr/imaging/geomUtil/coneMeshGenerator.h>
#include <pxr/imaging/geomUtil/cuboidMeshGenerator.h>
#include <pxr/imaging/geomUtil/cylinderMeshGenerator.h>
#include <pxr/imaging/geomUtil/sphereMeshGenerator.h>
#include <pxr/imaging/pxOsd/tokens.h>

namespace hydra_test {
namespace {

using delegate::ImplicitInput;
using delegate::ImplicitShape;

GfMatrix4d Spine(const std::string& axis) {
  GfMatrix4d m(1);
  const int spine = axis[0] - 'X';
  for (int row = 0; row < 3; ++row) m.SetRow3(row, GfVec3d::Axis(static_cast<size_t>(spine + 1 + row) % 3));
  return m;
}

VtVec3fArray PlanePoints(float width, float length, const std::string& axis) {
  const float w = 0.5f * width, l = 0.5f * length;
  if (axis == "X") return {GfVec3f(0, l, w), GfVec3f(0, -l, w), GfVec3f(0, -l, -w), GfVec3f(0, l, -w)};
  if (axis == "Y") return {GfVec3f(-w, 0, l), GfVec3f(w, 0, l), GfVec3f(w, 0, -l), GfVec3f(-w, 0, -l)};
  return {GfVec3f(w, l, 0), GfVec3f(-w, l, 0), GfVec3f(-w, -l, 0), GfVec3f(w, -l, 0)};
}

}  // namespace

HdMeshTopology HostTopology(ImplicitShape shape) {
  switch (shape) {
    case ImplicitShape::Sphere: return HdMeshTopology(GeomUtilSphereMeshGenerator::GenerateTopology(10, 10));
    case ImplicitShape::Cube: return HdMeshTopology(GeomUtilCuboidMeshGenerator::GenerateTopology());
    case ImplicitShape::Cone: return HdMeshTopology(GeomUtilConeMeshGenerator::GenerateTopology(10));
    case ImplicitShape::Cylinder: return HdMeshTopology(GeomUtilCylinderMeshGenerator::GenerateTopology(10));
    case ImplicitShape::Capsule: return HdMeshTopology(GeomUtilCapsuleMeshGenerator::GenerateTopology(10, 4));
    case ImplicitShape::Plane: break;
  }
  return HdMeshTopology(PxOsdMeshTopology(PxOsdOpenSubdivTokens->bilinear, PxOsdOpenSubdivTokens->rightHanded, {4},
                                          {0, 1, 2, 3}));
}

VtVec3fArray HostPoints(const ImplicitInput& s) {
  const double bottom = s.radiusBottom >= 0 ? s.radiusBottom : s.radius;
  const double top = s.radiusTop >= 0 ? s.radiusTop : s.radius;
  const GfMatrix4d spine = Spine(s.axis);
  VtVec3fArray points;
  switch (s.shape) {
    case ImplicitShape::Sphere:
      points.resize(GeomUtilSphereMeshGenerator::ComputeNumPoints(10, 10));
      GeomUtilSphereMeshGenerator::GeneratePoints(points.begin(), 10, 10, s.radius);
      break;
    case ImplicitShape::Cube:
      points.resize(GeomUtilCuboidMeshGenerator::ComputeNumPoints());
      GeomUtilCuboidMeshGenerator::GeneratePoints(points.begin(), s.size, s.size, s.size);
      break;
    case ImplicitShape::Cone:
      points.resize(GeomUtilConeMeshGenerator::ComputeNumPoints(10));
      GeomUtilConeMeshGenerator::GeneratePoints(points.begin(), 10, s.radius, s.height, &spine);
      break;
    case ImplicitShape::Cylinder:
      points.resize(GeomUtilCylinderMeshGenerator::ComputeNumPoints(10));
      GeomUtilCylinderMeshGenerator::GeneratePoints(points.begin(), 10, bottom, top, s.height, &spine);
      break;
    case ImplicitShape::Capsule:
      points.resize(GeomUtilCapsuleMeshGenerator::ComputeNumPoints(10, 4));
      GeomUtilCapsuleMeshGenerator::GeneratePoints(points.begin(), 10, 4, bottom, top, s.height, &spine);
      break;
    case ImplicitShape::Plane:
      points = PlanePoints(static_cast<float>(s.width), static_cast<float>(s.length), s.axis);
      break;
  }
  return points;
}

}  // namespace hydra_test
