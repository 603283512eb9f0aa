// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/split_triangles.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <unordered_map>

#include "delegate/mesh/mesh_math.h"

namespace delegate {
namespace {

using wavefront::Interpolation;
using wavefront::PrimvarData;

// The elements that triangle corners select, and those between them.
struct Edges {
  std::vector<uint32_t> corners;                       // of the finer triangles
  std::vector<std::pair<uint32_t, uint32_t>> middles;  // of what each new element is the middle
};

// `corners`: three per triangle. New elements are numbered from `count` on, in order of the triangles.
Edges Split(const std::vector<uint32_t>& corners, uint32_t count) {
  Edges result;
  result.corners.reserve(4 * corners.size());
  std::unordered_map<uint64_t, uint32_t> known;
  known.reserve(corners.size() / 2 + 16);
  const auto middle = [&](uint32_t a, uint32_t b) {
    if (a == b) return a;
    if (a > b) std::swap(a, b);
    const auto [found, isNew] =
        known.try_emplace(uint64_t{a} << 32 | b, count + static_cast<uint32_t>(result.middles.size()));
    if (isNew) result.middles.push_back({a, b});
    return found->second;
  };
  for (size_t i = 0; i < corners.size(); i += 3) {
    const uint32_t a = corners[i], b = corners[i + 1], c = corners[i + 2];
    const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    result.corners.insert(result.corners.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
  }
  return result;
}

void AddMiddles(PrimvarData& primvar, const std::vector<std::pair<uint32_t, uint32_t>>& middles) {
  const size_t n = primvar.components;
  const bool isNormal = primvar.name == "normals" && n == 3;
  primvar.values.reserve(primvar.values.size() + n * middles.size());
  for (const auto& [a, b] : middles) {
    const size_t at = primvar.values.size();
    for (size_t i = 0; i < n; ++i)
      primvar.values.push_back(0.5f * primvar.values[n * a + i] + 0.5f * primvar.values[n * b + i]);
    if (!isNormal) continue;
    float* v = &primvar.values[at];
    const Vec3 unit = Normalized(Vec3(v[0], v[1], v[2]));
    const wavefront::Float3 normal = Dot(unit, unit) > 0 ? ToFloat3(unit) : wavefront::Float3{0, 0, 1};
    std::copy_n(&normal.x, 3, v);
  }
}

template <typename T>
void RepeatFourTimes(std::vector<T>& values) {
  std::vector<T> result;
  result.reserve(4 * values.size());
  for (const T& value : values) result.insert(result.end(), 4, value);
  values = std::move(result);
}

void SplitOnce(wavefront::MeshData& mesh) {
  std::vector<uint32_t> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const wavefront::UInt3& t : mesh.triangles) corners.insert(corners.end(), {t.x, t.y, t.z});
  const Edges points = Split(corners, static_cast<uint32_t>(mesh.positions.size()));
  for (PrimvarData& primvar : mesh.primvars) {
    if (primvar.interpolation == Interpolation::Vertex) AddMiddles(primvar, points.middles);
    if (primvar.interpolation != Interpolation::FaceVarying || primvar.components == 0) continue;
    if (primvar.indices.empty()) {
      primvar.indices.resize(corners.size());
      std::iota(primvar.indices.begin(), primvar.indices.end(), 0u);
    }
    Edges elements = Split(primvar.indices, static_cast<uint32_t>(primvar.values.size() / primvar.components));
    AddMiddles(primvar, elements.middles);
    primvar.indices = std::move(elements.corners);
  }
  mesh.positions.reserve(mesh.positions.size() + points.middles.size());
  for (const auto& [a, b] : points.middles)
    mesh.positions.push_back(ToFloat3((Vec3(mesh.positions[a]) + Vec3(mesh.positions[b])) * 0.5));
  if (mesh.faceIds.empty()) {  // a triangle is its own face
    mesh.faceIds.resize(mesh.triangles.size());
    std::iota(mesh.faceIds.begin(), mesh.faceIds.end(), 0u);
  }
  mesh.triangles.resize(points.corners.size() / 3);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    mesh.triangles[t] = {points.corners[3 * t], points.corners[3 * t + 1], points.corners[3 * t + 2]};
  RepeatFourTimes(mesh.faceIds);
  RepeatFourTimes(mesh.materialSlots);
}

}  // namespace

void SplitTriangles(wavefront::MeshData& mesh, int levels) {
  for (int level = 0; level < levels; ++level) SplitOnce(mesh);
}

void WeldPoints(wavefront::MeshData& mesh) {
  std::vector<uint32_t> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const wavefront::UInt3& t : mesh.triangles) corners.insert(corners.end(), {t.x, t.y, t.z});
  for (PrimvarData& primvar : mesh.primvars) {
    if (primvar.interpolation != Interpolation::Vertex) continue;
    primvar.interpolation = Interpolation::FaceVarying;
    primvar.indices = corners;
  }
  std::map<std::array<float, 3>, uint32_t> places;
  std::vector<uint32_t> welded;
  std::vector<wavefront::Float3> positions;
  for (const wavefront::Float3& p : mesh.positions) {
    const auto [found, isNew] = places.try_emplace({p.x, p.y, p.z}, static_cast<uint32_t>(positions.size()));
    if (isNew) positions.push_back(p);
    welded.push_back(found->second);
  }
  mesh.positions = std::move(positions);
  for (wavefront::UInt3& t : mesh.triangles) t = {welded[t.x], welded[t.y], welded[t.z]};
}

}  // namespace delegate
