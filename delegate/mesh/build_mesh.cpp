// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/build_mesh.h"

#include <algorithm>

#include "delegate/mesh/mesh_check.h"
#include "delegate/mesh/normals.h"
#include "delegate/mesh/primvars.h"
#include "delegate/mesh/split_triangles.h"
#include "delegate/mesh/subdivide.h"
#include "delegate/mesh/triangulate.h"

namespace delegate {
namespace {

using wavefront::Float3;
using wavefront::Interpolation;
using wavefront::MeshData;
using wavefront::PrimvarData;

// Fills triangles, faceIds and slots; returns the authored corner of each triangle corner.
std::vector<uint32_t> AddTriangles(const MeshInput& input, const CheckedTopology& topology, const MeshReport& report, MeshData& mesh) {
  const auto& indices = input.topology.faceVertexIndices;
  std::vector<uint32_t> corners, local;
  std::vector<Vec3> polygon;
  PolygonTriangulator triangulator;
  Tally crossing, overBudget;
  size_t triangleCount = 0;
  for (const CheckedFace& face : topology.faces) triangleCount += face.count - 2;
  mesh.triangles.reserve(triangleCount);
  mesh.faceIds.reserve(triangleCount);
  corners.reserve(3 * triangleCount);
  for (size_t f = 0; f < topology.faces.size(); ++f) {
    if (!topology.isHole.empty() && topology.isHole[f]) continue;
    const CheckedFace& face = topology.faces[f];
    polygon.clear();
    for (uint32_t k = 0; k < face.count; ++k) polygon.emplace_back(input.points[indices[face.begin + k]]);
    local.clear();
    const PolygonOutcome outcome = triangulator.Triangulate(polygon, local);
    if (outcome == PolygonOutcome::SelfIntersecting) crossing.Add(face.id);
    if (outcome == PolygonOutcome::OverBudget) overBudget.Add(face.id);
    for (size_t t = 0; t < local.size(); t += 3) {
      uint32_t a = face.begin + local[t], b = face.begin + local[t + 1], c = face.begin + local[t + 2];
      if (topology.leftHanded) std::swap(b, c);
      const auto pa = static_cast<uint32_t>(indices[a]), pb = static_cast<uint32_t>(indices[b]), pc = static_cast<uint32_t>(indices[c]);
      if (pa == pb || pb == pc || pc == pa) continue;
      mesh.triangles.push_back({pa, pb, pc});
      mesh.faceIds.push_back(face.id);
      if (!topology.slots.empty()) mesh.materialSlots.push_back(topology.slots[face.id]);
      corners.insert(corners.end(), {a, b, c});
    }
  }
  if (crossing.count)
    report.Warn("mesh-bad-topology", std::to_string(crossing.count) + " faces (first: face " + std::to_string(crossing.first) +
                                         ") cross themselves; their shape is arbitrary.");
  if (overBudget.count)
    report.Warn("mesh-bad-topology", std::to_string(overBudget.count) + " faces (first: face " + std::to_string(overBudget.first) +
                                         ") are too large and concave to triangulate well; their shape is approximate.");
  return corners;
}

// Unit normals; those of zero length are computed instead. Elements without a corner of a drawn face become +Z.
// False: nothing can be saved (one constant normal of zero length).
bool NormalizeNormals(const MeshInput& input, const CheckedTopology& topology, const MeshReport& report, CheckedPrimvar& normals) {
  Tally zero;
  std::vector<uint8_t> isZero(normals.values.size() / 3, 0);
  for (size_t i = 0; i < isZero.size(); ++i) {
    float* v = normals.values.data() + 3 * i;
    const Float3 n = ToFloat3(Normalized(Vec3(v[0], v[1], v[2])));
    v[0] = n.x;
    v[1] = n.y;
    v[2] = n.z;
    if (n.x != 0 || n.y != 0 || n.z != 0) continue;
    isZero[i] = 1;
    zero.Add(static_cast<int64_t>(i));
  }
  if (!zero.count) return true;
  report.Warn("mesh-bad-primvar", std::to_string(zero.count) + " authored normals (first: element " + std::to_string(zero.first) +
                                      ") have no length; computed ones are taken.");
  const auto set = [&](size_t element, const Vec3& normal) {
    if (!isZero[element] || Dot(normal, normal) == 0) return;
    isZero[element] = 0;
    const Float3 n = ToFloat3(normal);
    std::copy_n(&n.x, 3, normals.values.begin() + static_cast<std::ptrdiff_t>(3 * element));
  };
  if (normals.interpolation == AuthoredInterpolation::Constant) return false;
  if (normals.interpolation == AuthoredInterpolation::Vertex || normals.interpolation == AuthoredInterpolation::Varying) {
    const std::vector<float> smooth = SmoothNormals(input, topology);
    for (size_t i = 0; i < isZero.size(); ++i) set(i, Vec3(smooth[3 * i], smooth[3 * i + 1], smooth[3 * i + 2]));
  } else {
    std::vector<Vec3> scratch;
    for (const CheckedFace& face : topology.faces) {
      const Vec3 normal = FaceNormal(input, topology, face, scratch);
      if (normals.interpolation == AuthoredInterpolation::Uniform) set(face.id, normal);
      else
        for (uint32_t k = 0; k < face.count; ++k) set(normals.Element(face.begin + k), normal);
    }
  }
  for (size_t i = 0; i < isZero.size(); ++i) set(i, {0, 0, 1});
  return true;
}

PrimvarData ToPrimvarData(CheckedPrimvar& primvar, const std::vector<uint32_t>& corners) {
  PrimvarData data;
  data.name = std::move(primvar.name);
  data.components = primvar.components;
  data.values = std::move(primvar.values);
  switch (primvar.interpolation) {
    case AuthoredInterpolation::Constant: data.interpolation = Interpolation::Constant; break;
    case AuthoredInterpolation::Uniform: data.interpolation = Interpolation::Uniform; break;
    case AuthoredInterpolation::Vertex:
    case AuthoredInterpolation::Varying: data.interpolation = Interpolation::Vertex; break;
    case AuthoredInterpolation::FaceVarying: {
      data.interpolation = Interpolation::FaceVarying;
      data.indices.resize(corners.size());
      bool isIdentity = data.values.size() == corners.size() * data.components;
      for (size_t i = 0; i < corners.size(); ++i) {
        data.indices[i] = primvar.Element(corners[i]);
        isIdentity = isIdentity && data.indices[i] == i;
      }
      if (isIdentity) data.indices = {};
      break;
    }
  }
  return data;
}

MeshData BuildPolygons(const MeshInput& input, const CheckedTopology& topology, std::vector<CheckedPrimvar> primvars,
                       const MeshReport& report) {
  MeshData mesh;
  mesh.doubleSided = input.doubleSided;
  const std::vector<uint32_t> corners = AddTriangles(input, topology, report, mesh);
  if (mesh.triangles.empty()) return mesh;
  mesh.positions = input.points;
  for (size_t i = 0; i < topology.badPoint.size(); ++i)
    if (topology.badPoint[i]) mesh.positions[i] = {0, 0, 0};
  for (CheckedPrimvar& primvar : primvars) {
    if (primvar.name == "normals" && !NormalizeNormals(input, topology, report, primvar)) continue;
    mesh.primvars.push_back(ToPrimvarData(primvar, corners));
  }
  if (topology.scheme == Scheme::CatmullClark || topology.scheme == Scheme::Loop)
    mesh.primvars.push_back({"normals", Interpolation::Vertex, 3, SmoothNormals(input, topology), {}});
  return mesh;
}

}  // namespace

std::optional<MeshData> BuildMesh(const MeshInput& input, const wavefront::DiagnosticSink& sink) {
  const MeshReport report(input.path, sink);
  const std::optional<CheckedTopology> topology = CheckTopology(input, report);
  if (!topology) return std::nullopt;
  std::vector<CheckedPrimvar> primvars = CheckPrimvars(input, *topology, report);
  std::optional<MeshData> mesh;
  if (topology->scheme != Scheme::None && topology->level > 0) mesh = Subdivide(input, *topology, primvars, report);
  if (!mesh) mesh = BuildPolygons(input, *topology, std::move(primvars), report);
  mesh->path = input.path;
  if (topology->scheme == Scheme::None) SplitTriangles(*mesh, input.displacementLevel.value_or(0));
  if (!mesh->triangles.empty()) return mesh;
  const auto& holes = topology->isHole;
  if (holes.empty() || std::count(holes.begin(), holes.end(), 0))
    report.Warn("mesh-empty", "None of the mesh's faces spans an area; nothing is drawn.");
  return std::nullopt;
}

}  // namespace delegate
