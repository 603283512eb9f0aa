// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which meshes count as implicit shapes. Meshes and points are made here as UsdImaging's adapters make them.
#include <gtest/gtest.h>
#include <pxr/base/gf/matrix4d.h>
#include <pxr/imaging/geomUtil/capsuleMeshGenerator.h>
#include <pxr/imaging/geomUtil/coneMeshGenerator.h>
#include <pxr/imaging/geomUtil/cuboidMeshGenerator.h>
#include <pxr/imaging/geomUtil/cylinderMeshGenerator.h>
#include <pxr/imaging/geomUtil/sphereMeshGenerator.h>
#include <pxr/imaging/pxOsd/tokens.h>

#include <cmath>
#include <map>

#include "plugin/hydra/implicit_mesh.h"

namespace hydra {
namespace {

using delegate::ImplicitInput;
using delegate::ImplicitShape;

struct HostMesh {
  ImplicitShape shape = ImplicitShape::Sphere;
  HdMeshTopology topology;
  VtVec3fArray points;
  std::map<std::string, VtValue> attributes;

  std::optional<ImplicitInput> Recognized() const {
    const auto is = ShapeOfTopology(topology);
    if (!is) return std::nullopt;
    EXPECT_EQ(*is, shape);
    return RecognizeImplicit(*is, VtValue(points), [&](const TfToken& name) {
      const auto found = attributes.find(name.GetString());
      return found == attributes.end() ? VtValue() : found->second;
    });
  }
};

GfMatrix4d Spine(const std::string& axis) {
  GfMatrix4d m(1);
  const int spine = axis[0] - 'X';
  for (int row = 0; row < 3; ++row)
    m.SetRow3(row, GfVec3d::Axis((spine + 1 + row) % 3));  // u, v, spine
  return m;
}

HostMesh Sphere(double radius) {
  HostMesh mesh{ImplicitShape::Sphere, HdMeshTopology(GeomUtilSphereMeshGenerator::GenerateTopology(10, 10)), {}, {}};
  mesh.points.resize(GeomUtilSphereMeshGenerator::ComputeNumPoints(10, 10));
  GeomUtilSphereMeshGenerator::GeneratePoints(mesh.points.begin(), 10, 10, radius);
  mesh.attributes["radius"] = VtValue(radius);
  return mesh;
}

HostMesh Cube(double size) {
  HostMesh mesh{ImplicitShape::Cube, HdMeshTopology(GeomUtilCuboidMeshGenerator::GenerateTopology()), {}, {}};
  mesh.points.resize(GeomUtilCuboidMeshGenerator::ComputeNumPoints());
  GeomUtilCuboidMeshGenerator::GeneratePoints(mesh.points.begin(), size, size, size);
  mesh.attributes["size"] = VtValue(size);
  return mesh;
}

HostMesh Cone(double radius, double height, const std::string& axis) {
  HostMesh mesh{ImplicitShape::Cone, HdMeshTopology(GeomUtilConeMeshGenerator::GenerateTopology(10)), {}, {}};
  mesh.points.resize(GeomUtilConeMeshGenerator::ComputeNumPoints(10));
  const GfMatrix4d basis = Spine(axis);
  GeomUtilConeMeshGenerator::GeneratePoints(mesh.points.begin(), 10, radius, height, &basis);
  mesh.attributes = {{"radius", VtValue(radius)}, {"height", VtValue(height)}, {"axis", VtValue(TfToken(axis))}};
  return mesh;
}

HostMesh Cylinder(double bottom, double top, double height, const std::string& axis) {
  HostMesh mesh{ImplicitShape::Cylinder, HdMeshTopology(GeomUtilCylinderMeshGenerator::GenerateTopology(10)), {}, {}};
  mesh.points.resize(GeomUtilCylinderMeshGenerator::ComputeNumPoints(10));
  const GfMatrix4d basis = Spine(axis);
  GeomUtilCylinderMeshGenerator::GeneratePoints(mesh.points.begin(), 10, bottom, top, height, &basis);
  mesh.attributes = {{"height", VtValue(height)}, {"axis", VtValue(TfToken(axis))}};
  if (bottom == top) {
    mesh.attributes["radius"] = VtValue(bottom);
  } else {
    mesh.attributes["radiusBottom"] = VtValue(bottom);
    mesh.attributes["radiusTop"] = VtValue(top);
  }
  return mesh;
}

HostMesh Capsule(double bottom, double top, double height, const std::string& axis) {
  HostMesh mesh = Cylinder(bottom, top, height, axis);
  mesh.shape = ImplicitShape::Capsule;
  mesh.topology = HdMeshTopology(GeomUtilCapsuleMeshGenerator::GenerateTopology(10, 4));
  mesh.points.resize(GeomUtilCapsuleMeshGenerator::ComputeNumPoints(10, 4));
  const GfMatrix4d basis = Spine(axis);
  GeomUtilCapsuleMeshGenerator::GeneratePoints(mesh.points.begin(), 10, 4, bottom, top, height, &basis);
  return mesh;
}

HostMesh Plane(float width, float length, const std::string& axis) {
  HostMesh mesh{ImplicitShape::Plane,
                HdMeshTopology(PxOsdMeshTopology(PxOsdOpenSubdivTokens->bilinear, PxOsdOpenSubdivTokens->rightHanded,
                                                 {4}, {0, 1, 2, 3})),
                {}, {}};
  const float w = 0.5f * width, l = 0.5f * length;
  if (axis == "X") mesh.points = {GfVec3f(0, l, w), GfVec3f(0, -l, w), GfVec3f(0, -l, -w), GfVec3f(0, l, -w)};
  else if (axis == "Y") mesh.points = {GfVec3f(-w, 0, l), GfVec3f(w, 0, l), GfVec3f(w, 0, -l), GfVec3f(-w, 0, -l)};
  else mesh.points = {GfVec3f(w, l, 0), GfVec3f(-w, l, 0), GfVec3f(-w, -l, 0), GfVec3f(w, -l, 0)};
  mesh.attributes = {{"width", VtValue(static_cast<double>(width))}, {"length", VtValue(static_cast<double>(length))},
                     {"axis", VtValue(TfToken(axis))}};
  return mesh;
}

constexpr double kSizes[] = {1e-6, 0.1, 1, 1.0 / 3, 2.5, 12345.678};

TEST(ImplicitMesh, EverySizeComesBack) {
  for (const double size : kSizes) {
    const auto sphere = Sphere(size).Recognized();
    ASSERT_TRUE(sphere);
    EXPECT_EQ(sphere->shape, ImplicitShape::Sphere);
    EXPECT_EQ(sphere->radius, size);
    const auto cube = Cube(size).Recognized();
    ASSERT_TRUE(cube);
    EXPECT_EQ(cube->size, size);
  }
}

TEST(ImplicitMesh, EveryAxisAndSizeComesBack) {
  for (const std::string axis : {"X", "Y", "Z"})
    for (const double radius : kSizes)
      for (const double height : kSizes) {
        const auto cone = Cone(radius, height, axis).Recognized();
        ASSERT_TRUE(cone) << axis << " " << radius << " " << height;
        EXPECT_EQ(cone->shape, ImplicitShape::Cone);
        EXPECT_EQ(cone->radius, radius);
        EXPECT_EQ(cone->height, height);
        EXPECT_EQ(cone->axis, axis);
        for (const HostMesh& mesh : {Cylinder(radius, radius, height, axis), Capsule(radius, radius, height, axis)}) {
          const auto shape = mesh.Recognized();
          ASSERT_TRUE(shape) << axis << " " << radius << " " << height;
          EXPECT_EQ(shape->shape, mesh.shape);
          EXPECT_EQ(shape->radius, radius);
          EXPECT_EQ(shape->height, height);
          EXPECT_EQ(shape->axis, axis);
        }
        const auto plane = Plane(static_cast<float>(radius), static_cast<float>(height), axis).Recognized();
        ASSERT_TRUE(plane) << axis << " " << radius << " " << height;
        EXPECT_EQ(plane->width, static_cast<float>(radius));
        EXPECT_EQ(plane->length, static_cast<float>(height));
        EXPECT_EQ(plane->axis, axis);
      }
}

TEST(ImplicitMesh, TwoRadiiComeBack) {
  for (const HostMesh& mesh : {Cylinder(1, 0.25, 3, "Y"), Capsule(0.5, 0.75, 3, "Y")}) {
    const auto shape = mesh.Recognized();
    ASSERT_TRUE(shape);
    EXPECT_EQ(shape->radiusBottom, mesh.attributes.at("radiusBottom").UncheckedGet<double>());
    EXPECT_EQ(shape->radiusTop, mesh.attributes.at("radiusTop").UncheckedGet<double>());
  }
}

std::vector<HostMesh> OneOfEach() {
  return {Sphere(1.5), Cube(2), Cone(1, 2, "X"), Cylinder(1, 1, 2, "Y"), Capsule(0.5, 0.5, 1, "Z"), Plane(2, 3, "Z")};
}

TEST(ImplicitMesh, PointsThatDifferByTheLeastStayAMesh) {
  for (HostMesh mesh : OneOfEach()) {
    ASSERT_TRUE(mesh.Recognized());
    for (size_t i = 0; i < mesh.points.size(); ++i) {
      HostMesh moved = mesh;
      moved.points[i][i % 3] = std::nextafter(moved.points[i][i % 3], 10.0f);
      EXPECT_FALSE(moved.Recognized()) << "point " << i;
    }
    mesh.points.push_back(GfVec3f(0));
    EXPECT_FALSE(mesh.Recognized());
  }
}

TEST(ImplicitMesh, AMeshWithoutTheShapesAttributesStaysAMesh) {
  for (const HostMesh& mesh : OneOfEach())
    for (const auto& [name, value] : mesh.attributes) {
      HostMesh lacking = mesh;
      lacking.attributes.erase(name);
      EXPECT_FALSE(lacking.Recognized()) << name;
    }
  // A Mesh of the default size has the points, and no attribute at all.
  for (HostMesh mesh : {Sphere(1), Cube(2), Cone(1, 2, "Z"), Plane(2, 2, "Z")}) {
    mesh.attributes.clear();
    EXPECT_FALSE(mesh.Recognized());
  }
}

TEST(ImplicitMesh, AnotherSizeOrAxisThanThePointsStaysAMesh) {
  for (const HostMesh& mesh : OneOfEach())
    for (const auto& [name, value] : mesh.attributes) {
      HostMesh other = mesh;
      if (value.IsHolding<TfToken>())
        other.attributes[name] = VtValue(TfToken(value.UncheckedGet<TfToken>() == TfToken("X") ? "Y" : "X"));
      else
        other.attributes[name] = VtValue(value.UncheckedGet<double>() * 1.001);
      EXPECT_FALSE(other.Recognized()) << name;
    }
}

TEST(ImplicitMesh, AnotherTopologyStaysAMesh) {
  for (const HostMesh& mesh : OneOfEach()) {
    const PxOsdMeshTopology& t = mesh.topology.GetPxOsdMeshTopology();
    const auto with = [&](const TfToken& scheme, const TfToken& orientation, const VtIntArray& indices,
                          const VtIntArray& holes) {
      HostMesh other = mesh;
      other.topology = HdMeshTopology(scheme, orientation, t.GetFaceVertexCounts(), indices, holes);
      return other.Recognized();
    };
    const VtIntArray& indices = t.GetFaceVertexIndices();
    ASSERT_TRUE(with(t.GetScheme(), t.GetOrientation(), indices, {}));
    EXPECT_FALSE(with(PxOsdOpenSubdivTokens->none, t.GetOrientation(), indices, {}));
    EXPECT_FALSE(with(t.GetScheme(), PxOsdOpenSubdivTokens->leftHanded, indices, {}));
    EXPECT_FALSE(with(t.GetScheme(), t.GetOrientation(), indices, {0}));
    VtIntArray turned = indices;
    std::swap(turned[0], turned[1]);
    EXPECT_FALSE(with(t.GetScheme(), t.GetOrientation(), turned, {}));
    HostMesh subsets = mesh;
    subsets.topology.SetGeomSubsets({{HdGeomSubset::TypeFaceSet, SdfPath("/s/a"), SdfPath("/red"), {0}}});
    EXPECT_FALSE(subsets.Recognized());
  }
  HostMesh finer = Sphere(1);
  finer.topology = HdMeshTopology(GeomUtilSphereMeshGenerator::GenerateTopology(12, 10));
  EXPECT_FALSE(finer.Recognized());
}

}  // namespace
}  // namespace hydra
