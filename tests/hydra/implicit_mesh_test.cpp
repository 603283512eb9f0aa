// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which meshes count as implicit shapes.
#include <gtest/gtest.h>
#include <pxr/imaging/geomUtil/sphereMeshGenerator.h>
#include <pxr/imaging/pxOsd/tokens.h>

#include <cmath>
#include <map>

#include "plugin/hydra/implicit_mesh.h"
#include "tests/hydra/host_mesh.h"

namespace hydra {
namespace {

using delegate::ImplicitInput;
using delegate::ImplicitShape;

struct ShapeMesh : hydra_test::HostMesh {
  ImplicitShape shape = ImplicitShape::Sphere;
  std::map<std::string, VtValue> attributes;

  explicit ShapeMesh(const ImplicitInput& input)
      : HostMesh(hydra_test::MeshOfHost(input)), shape(input.shape) {}
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

ShapeMesh Sphere(double radius) {
  ImplicitInput input;
  input.radius = radius;
  ShapeMesh mesh(input);
  mesh.attributes["radius"] = VtValue(radius);
  return mesh;
}

ShapeMesh Cube(double size) {
  ImplicitInput input;
  input.shape = ImplicitShape::Cube;
  input.size = size;
  ShapeMesh mesh(input);
  mesh.attributes["size"] = VtValue(size);
  return mesh;
}

ShapeMesh Round(ImplicitShape shape, double bottom, double top, double height, const std::string& axis) {
  ImplicitInput input;
  input.shape = shape;
  input.height = height;
  input.axis = axis;
  input.radius = bottom;
  if (bottom != top) {
    input.radiusBottom = bottom;
    input.radiusTop = top;
  }
  ShapeMesh mesh(input);
  mesh.attributes = {{"height", VtValue(height)}, {"axis", VtValue(TfToken(axis))}};
  if (bottom == top) {
    mesh.attributes["radius"] = VtValue(bottom);
  } else {
    mesh.attributes["radiusBottom"] = VtValue(bottom);
    mesh.attributes["radiusTop"] = VtValue(top);
  }
  return mesh;
}

ShapeMesh Cone(double radius, double height, const std::string& axis) {
  return Round(ImplicitShape::Cone, radius, radius, height, axis);
}
ShapeMesh Cylinder(double bottom, double top, double height, const std::string& axis) {
  return Round(ImplicitShape::Cylinder, bottom, top, height, axis);
}
ShapeMesh Capsule(double bottom, double top, double height, const std::string& axis) {
  return Round(ImplicitShape::Capsule, bottom, top, height, axis);
}

ShapeMesh Plane(float width, float length, const std::string& axis) {
  ImplicitInput input;
  input.shape = ImplicitShape::Plane;
  input.width = width;
  input.length = length;
  input.axis = axis;
  ShapeMesh mesh(input);
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
        for (const ShapeMesh& mesh : {Cylinder(radius, radius, height, axis), Capsule(radius, radius, height, axis)}) {
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
  for (const ShapeMesh& mesh : {Cylinder(1.5, 0.25, 3, "Y"), Capsule(0.4, 0.75, 3, "Y")}) {
    const auto shape = mesh.Recognized();
    ASSERT_TRUE(shape);
    EXPECT_EQ(shape->radiusBottom, mesh.attributes.at("radiusBottom").UncheckedGet<double>());
    EXPECT_EQ(shape->radiusTop, mesh.attributes.at("radiusTop").UncheckedGet<double>());
  }
}

std::vector<ShapeMesh> OneOfEach() {
  return {Sphere(1.5), Cube(2), Cone(1, 2, "X"), Cylinder(1, 1, 2, "Y"), Capsule(0.5, 0.5, 1, "Z"), Plane(2, 3, "Z")};
}

TEST(ImplicitMesh, PointsThatDifferByTheLeastStayAMesh) {
  for (ShapeMesh mesh : OneOfEach()) {
    ASSERT_TRUE(mesh.Recognized());
    for (size_t i = 0; i < mesh.points.size(); ++i) {
      ShapeMesh moved = mesh;
      moved.points[i][i % 3] = std::nextafter(moved.points[i][i % 3], 10.0f);
      EXPECT_FALSE(moved.Recognized()) << "point " << i;
    }
    mesh.points.push_back(GfVec3f(0));
    EXPECT_FALSE(mesh.Recognized());
  }
}

TEST(ImplicitMesh, AMeshWithoutTheShapesAttributesStaysAMesh) {
  for (const ShapeMesh& mesh : OneOfEach())
    for (const auto& [name, value] : mesh.attributes) {
      ShapeMesh lacking = mesh;
      lacking.attributes.erase(name);
      EXPECT_FALSE(lacking.Recognized()) << name;
    }
  // A primvar of that name is none of the shape's.
  ShapeMesh primvar = Sphere(1);
  primvar.attributes["radius"] = VtValue(VtFloatArray{1});
  EXPECT_FALSE(primvar.Recognized());
  // A Mesh of the default size has the points, and no attribute at all.
  for (ShapeMesh mesh : {Sphere(1), Cube(2), Cone(1, 2, "Z"), Plane(2, 2, "Z")}) {
    mesh.attributes.clear();
    EXPECT_FALSE(mesh.Recognized());
  }
}

TEST(ImplicitMesh, AnotherSizeOrAxisThanThePointsStaysAMesh) {
  for (const ShapeMesh& mesh : OneOfEach())
    for (const auto& [name, value] : mesh.attributes) {
      ShapeMesh other = mesh;
      if (value.IsHolding<TfToken>())
        other.attributes[name] = VtValue(TfToken(value.UncheckedGet<TfToken>() == TfToken("X") ? "Y" : "X"));
      else
        other.attributes[name] = VtValue(value.UncheckedGet<double>() * 1.001);
      EXPECT_FALSE(other.Recognized()) << name;
    }
}

TEST(ImplicitMesh, AnotherTopologyStaysAMesh) {
  for (const ShapeMesh& mesh : OneOfEach()) {
    const PxOsdMeshTopology& t = mesh.topology.GetPxOsdMeshTopology();
    const auto with = [&](const TfToken& scheme, const TfToken& orientation, const VtIntArray& indices,
                          const VtIntArray& holes) {
      ShapeMesh other = mesh;
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
    ShapeMesh subsets = mesh;
    subsets.topology.SetGeomSubsets({{HdGeomSubset::TypeFaceSet, SdfPath("/s/a"), SdfPath("/red"), {0}}});
    EXPECT_FALSE(subsets.Recognized());
  }
  ShapeMesh finer = Sphere(1);
  finer.topology = HdMeshTopology(GeomUtilSphereMeshGenerator::GenerateTopology(12, 10));
  EXPECT_FALSE(finer.Recognized());
}

}  // namespace
}  // namespace hydra
