// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_mesh.h"

#include <pxr/imaging/hd/geomSubset.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/pxOsd/tokens.h>

#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

std::vector<float> ToFloatVector(const VtFloatArray& values) { return {values.cbegin(), values.cend()}; }

bool WearsMaterial(const HdGeomSubset& subset) { return subset.type == HdGeomSubset::TypeFaceSet; }

// An empty token keeps the default.
void SetToken(std::string& member, const TfToken& token) {
  if (!token.IsEmpty()) member = token.GetString();
}

}  // namespace

delegate::MeshTopology ToTopology(const HdMeshTopology& topology, const PxOsdSubdivTags& tags) {
  delegate::MeshTopology t;
  SetToken(t.scheme, topology.GetScheme());
  SetToken(t.orientation, topology.GetOrientation());
  t.faceVertexCounts = ToInts(topology.GetFaceVertexCounts());
  t.faceVertexIndices = ToInts(topology.GetFaceVertexIndices());
  t.holeIndices = ToInts(topology.GetHoleIndices());
  for (const HdGeomSubset& subset : topology.GetGeomSubsets())
    if (WearsMaterial(subset)) t.subsets.push_back({subset.id.GetString(), ToInts(subset.indices)});
  if (t.scheme == PxOsdOpenSubdivTokens->none.GetString()) return t;  // tags say nothing about polygons
  SetToken(t.interpolateBoundary, tags.GetVertexInterpolationRule());
  SetToken(t.faceVaryingLinearInterpolation, tags.GetFaceVaryingInterpolationRule());
  SetToken(t.triangleSubdivisionRule, tags.GetTriangleSubdivision());
  t.cornerIndices = ToInts(tags.GetCornerIndices());
  t.cornerSharpnesses = ToFloatVector(tags.GetCornerWeights());
  t.creaseIndices = ToInts(tags.GetCreaseIndices());
  t.creaseLengths = ToInts(tags.GetCreaseLengths());
  t.creaseSharpnesses = ToFloatVector(tags.GetCreaseWeights());
  return t;
}

std::vector<std::string> ToSubsetMaterials(const HdMeshTopology& topology, const SdfPath& primMaterial) {
  std::vector<std::string> materials;
  for (const HdGeomSubset& subset : topology.GetGeomSubsets())
    if (WearsMaterial(subset))
      materials.push_back((subset.materialId.IsEmpty() ? primMaterial : subset.materialId).GetString());
  return materials;
}

std::optional<delegate::ImplicitShape> ToImplicitShape(const TfToken& type) {
  if (type == HdPrimTypeTokens->sphere) return delegate::ImplicitShape::Sphere;
  if (type == HdPrimTypeTokens->cube) return delegate::ImplicitShape::Cube;
  if (type == HdPrimTypeTokens->cone) return delegate::ImplicitShape::Cone;
  if (type == HdPrimTypeTokens->cylinder) return delegate::ImplicitShape::Cylinder;
  if (type == HdPrimTypeTokens->capsule) return delegate::ImplicitShape::Capsule;
  if (type == TfToken("plane")) return delegate::ImplicitShape::Plane;
  return std::nullopt;
}

delegate::ImplicitInput ToImplicit(delegate::ImplicitShape shape, const std::function<VtValue(const TfToken&)>& value) {
  delegate::ImplicitInput input;
  input.shape = shape;
  if (shape == delegate::ImplicitShape::Capsule) {
    input.radius = 0.5;
    input.height = 1;
  }
  const std::pair<const char*, double delegate::ImplicitInput::*> sizes[] = {
      {"size", &delegate::ImplicitInput::size},           {"radius", &delegate::ImplicitInput::radius},
      {"radiusTop", &delegate::ImplicitInput::radiusTop}, {"radiusBottom", &delegate::ImplicitInput::radiusBottom},
      {"height", &delegate::ImplicitInput::height},       {"width", &delegate::ImplicitInput::width},
      {"length", &delegate::ImplicitInput::length}};
  for (const auto& [name, member] : sizes)
    if (const auto number = ToNumber(value(TfToken(name)))) input.*member = *number;
  if (const std::string axis = ToString(value(TfToken("axis"))); !axis.empty()) input.axis = axis;
  return input;
}

}  // namespace hydra
