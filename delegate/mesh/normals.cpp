// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/normals.h"

#include "delegate/mesh/triangulate.h"

namespace delegate {

Vec3 FaceNormal(const MeshInput& input, const CheckedTopology& topology, const CheckedFace& face, std::vector<Vec3>& scratch) {
  scratch.clear();
  const int32_t* corner = input.topology.faceVertexIndices.data() + face.begin;
  for (uint32_t k = 0; k < face.count; ++k) scratch.emplace_back(input.points[corner[k]]);
  const Vec3 normal = Normalized(NewellNormal(scratch));
  return topology.leftHanded ? -normal : normal;
}

std::vector<float> SmoothNormals(const MeshInput& input, const CheckedTopology& topology) {
  const size_t pointCount = input.points.size();
  std::vector<Vec3> sums(pointCount), polygon;
  std::vector<wavefront::Float3> firstFace(pointCount, wavefront::Float3{0, 0, 0});
  const auto isZero = [](const wavefront::Float3& v) { return v.x == 0 && v.y == 0 && v.z == 0; };
  for (const CheckedFace& face : topology.faces) {
    const Vec3 normal = FaceNormal(input, topology, face, polygon);
    const int32_t* corner = input.topology.faceVertexIndices.data() + face.begin;
    for (uint32_t k = 0; k < face.count; ++k) {
      const Vec3& p = polygon[k];
      const Vec3 toNext = polygon[(k + 1) % face.count] - p, toPrevious = polygon[(k + face.count - 1) % face.count] - p;
      const size_t point = static_cast<size_t>(corner[k]);
      sums[point] += normal * AngleBetween(toNext, toPrevious);
      if (isZero(firstFace[point])) firstFace[point] = ToFloat3(normal);
    }
  }
  std::vector<float> normals(3 * pointCount);
  for (size_t i = 0; i < pointCount; ++i) {
    // Angles are of order 1, so a sum this short has cancelled out.
    Vec3 n = Length(sums[i]) > 1e-6 ? Normalized(sums[i]) : Vec3(firstFace[i]);
    if (Dot(n, n) == 0) n = {0, 0, 1};
    const wavefront::Float3 value = ToFloat3(n);
    normals[3 * i] = value.x;
    normals[3 * i + 1] = value.y;
    normals[3 * i + 2] = value.z;
  }
  return normals;
}

}  // namespace delegate
