// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/limit_normals.h"

#include <algorithm>
#include <numeric>

#include "delegate/mesh/mesh_math.h"

namespace delegate {
namespace {

namespace Far = OpenSubdiv::Far;

class NormalBuilder {
 public:
  NormalBuilder(const Far::TopologyLevel& level, uint32_t cornersPerFace, const std::vector<float>& positions, bool leftHanded)
      : level_(level), cornersPerFace_(cornersPerFace), positions_(positions), sign_(leftHanded ? -1 : 1) {}

  LimitNormals Build(const std::vector<float>& tangent1, const std::vector<float>& tangent2) {
    const int count = level_.GetNumVertices();
    result_.values.resize(3 * static_cast<size_t>(count));
    for (int v = 0; v < count; ++v) {
      const Vec3 t1 = At(tangent1, v), t2 = At(tangent2, v), normal = Cross(t1, t2);
      // Tangents that vanish or are parallel span no plane.
      const bool hasPlane = Length(normal) > 1e-6 * Length(t1) * Length(t2);
      if (hasPlane && !NeedsSectors(v)) Store(static_cast<size_t>(v), Normalized(normal));
      else AddSectors(v);
    }
    return std::move(result_);
  }

 private:
  Vec3 At(const std::vector<float>& data, int v) const {
    const size_t i = 3 * static_cast<size_t>(v);
    return {data[i], data[i + 1], data[i + 2]};
  }

  void Store(size_t element, const Vec3& normal) {
    const double s = sign_;
    result_.values[3 * element] = static_cast<float>(normal.x * s);
    result_.values[3 * element + 1] = static_cast<float>(normal.y * s);
    result_.values[3 * element + 2] = static_cast<float>(normal.z * s);
  }

  // A boundary edge is sharp too, but has the surface on one side only.
  bool JoinsSmoothly(int edge) const {
    return level_.GetEdgeFaces(edge).size() == 2 && !level_.IsEdgeNonManifold(edge) && level_.GetEdgeSharpness(edge) <= 0;
  }

  bool NeedsSectors(int v) const {
    if (level_.IsVertexNonManifold(v)) return true;
    // The tip of a sharp corner inside the surface: no tangent plane.
    if (!level_.IsVertexBoundary(v) && level_.GetVertexSharpness(v) > 0) return true;
    for (const int edge : level_.GetVertexEdges(v))
      if (!level_.IsEdgeBoundary(edge) && !JoinsSmoothly(edge)) return true;
    return false;
  }

  Vec3 CornerNormal(int face, int corner) const {
    const Far::ConstIndexArray verts = level_.GetFaceVertices(face);
    const int n = verts.size();
    const Vec3 p = At(positions_, verts[corner]);
    const Vec3 next = At(positions_, verts[(corner + 1) % n]) - p, previous = At(positions_, verts[(corner + n - 1) % n]) - p;
    return Normalized(Cross(next, previous)) * AngleBetween(next, previous);
  }

  int Root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // Unites the faces around the vertex that meet in smooth edges; each group shares one normal.
  void AddSectors(int v) {
    const Far::ConstIndexArray faces = level_.GetVertexFaces(v);
    const Far::ConstLocalIndexArray inFace = level_.GetVertexFaceLocalIndices(v);
    const int count = faces.size();
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](int a, int b) { return faces[a] < faces[b]; });
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0);
    const auto find = [&](int face) {
      return *std::lower_bound(order_.begin(), order_.end(), face, [&](int i, int f) { return faces[i] < f; });
    };
    for (const int edge : level_.GetVertexEdges(v)) {
      if (!JoinsSmoothly(edge)) continue;
      const Far::ConstIndexArray sides = level_.GetEdgeFaces(edge);
      // The smaller number becomes the root, so that the numbering is that of the faces.
      const int a = Root(find(sides[0])), b = Root(find(sides[1]));
      parent_[std::max(a, b)] = std::min(a, b);
    }
    sums_.assign(count, Vec3());
    for (int i = 0; i < count; ++i) sums_[Root(i)] += CornerNormal(faces[i], inFace[i]);
    elements_.assign(count, 0);
    bool first = true;
    for (int i = 0; i < count; ++i) {
      if (Root(i) != i) continue;
      Vec3 normal = Normalized(sums_[i]);
      if (Dot(normal, normal) == 0) normal = {0, 0, 1};
      size_t element = static_cast<size_t>(v);
      if (!first) {
        element = result_.values.size() / 3;
        result_.values.resize(result_.values.size() + 3);
      }
      first = false;
      Store(element, normal);
      elements_[i] = static_cast<uint32_t>(element);
    }
    for (int i = 0; i < count; ++i)
      if (elements_[Root(i)] != static_cast<uint32_t>(v)) SetCorner(faces[i], inFace[i], elements_[Root(i)]);
  }

  void SetCorner(int face, int corner, uint32_t element) {
    if (result_.corners.empty()) {
      result_.corners.reserve(static_cast<size_t>(level_.GetNumFaces()) * cornersPerFace_);
      for (int f = 0; f < level_.GetNumFaces(); ++f)
        for (const int v : level_.GetFaceVertices(f)) result_.corners.push_back(static_cast<uint32_t>(v));
    }
    result_.corners[static_cast<size_t>(face) * cornersPerFace_ + static_cast<size_t>(corner)] = element;
  }

  const Far::TopologyLevel& level_;
  const uint32_t cornersPerFace_;
  const std::vector<float>& positions_;
  const double sign_;
  LimitNormals result_;
  std::vector<int> order_, parent_;
  std::vector<Vec3> sums_;
  std::vector<uint32_t> elements_;
};

}  // namespace

LimitNormals ComputeLimitNormals(const Far::TopologyLevel& level, uint32_t cornersPerFace, const std::vector<float>& positions,
                                 const std::vector<float>& tangent1, const std::vector<float>& tangent2, bool leftHanded) {
  return NormalBuilder(level, cornersPerFace, positions, leftHanded).Build(tangent1, tangent2);
}

}  // namespace delegate
