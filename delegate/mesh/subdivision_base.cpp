// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/subdivision_base.h"

#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "delegate/mesh/triangulate.h"

namespace delegate {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

// Appends the face, repeated points in a row merged; at least 3 different points are there (mesh_check).
void AddFace(const MeshInput& input, const CheckedFace& face, uint32_t faceIndex, SubdivisionCage& cage) {
  const int32_t* indices = input.topology.faceVertexIndices.data() + face.begin;
  int count = 0;
  for (uint32_t k = 0; k < face.count; ++k) {
    if (indices[k] == indices[(k + face.count - 1) % face.count]) continue;
    cage.corners.push_back(face.begin + k);
    ++count;
  }
  cage.counts.push_back(count);
  cage.faces.push_back(faceIndex);
}

void AddAsTriangles(const MeshInput& input, const CheckedFace& face, uint32_t faceIndex, PolygonTriangulator& triangulator,
                    SubdivisionCage& cage) {
  const int32_t* indices = input.topology.faceVertexIndices.data() + face.begin;
  std::vector<Vec3> polygon;
  std::vector<uint32_t> triangles;
  for (uint32_t k = 0; k < face.count; ++k) polygon.emplace_back(input.points[indices[k]]);
  triangulator.Triangulate(polygon, triangles);
  for (size_t t = 0; t < triangles.size(); t += 3) {
    const uint32_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    if (indices[a] == indices[b] || indices[b] == indices[c] || indices[c] == indices[a]) continue;
    for (const uint32_t k : {a, b, c}) cage.corners.push_back(face.begin + k);
    cage.counts.push_back(3);
    cage.faces.push_back(faceIndex);
  }
}

// Corners at one vertex that hold equal values become one value.
FaceVaryingChannel Weld(const SubdivisionCage& cage, const CheckedPrimvar& primvar, std::vector<float>& values) {
  const size_t n = primvar.components;
  std::vector<uint32_t> order(cage.corners.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto value = [&](uint32_t corner) { return primvar.values.data() + n * primvar.Element(cage.corners[corner]); };
  const auto compare = [&](uint32_t a, uint32_t b) {
    const float* va = value(a);
    const float* vb = value(b);
    for (size_t c = 0; c < n; ++c)
      if (va[c] != vb[c]) return va[c] < vb[c] ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    if (cage.vertices[a] != cage.vertices[b]) return cage.vertices[a] < cage.vertices[b];
    const int c = compare(a, b);
    return c != 0 ? c < 0 : a < b;
  });
  FaceVaryingChannel channel;
  channel.indices.resize(order.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool isNew = i == 0 || cage.vertices[order[i]] != cage.vertices[order[i - 1]] || compare(order[i], order[i - 1]) != 0;
    if (isNew) {
      values.insert(values.end(), value(order[i]), value(order[i]) + n);
      ++channel.valueCount;
    }
    channel.indices[order[i]] = channel.valueCount - 1;
  }
  return channel;
}

FaceVaryingChannel Indexed(const SubdivisionCage& cage, const CheckedPrimvar& primvar, std::vector<float>& values) {
  FaceVaryingChannel channel;
  channel.valueCount = static_cast<int>(primvar.values.size() / primvar.components);
  channel.indices.reserve(cage.corners.size());
  for (const uint32_t corner : cage.corners) channel.indices.push_back(static_cast<int>(primvar.indices[corner]));
  values = primvar.values;
  return channel;
}

template <typename T>
struct TokenValue {
  const char* token;
  T value;
};

template <typename T, size_t kCount>
T ReadToken(const char* attribute, const std::string& token, const TokenValue<T> (&table)[kCount], T fallback, const MeshReport& report) {
  if (token.empty()) return fallback;
  for (const auto& row : table)
    if (token == row.token) return row.value;
  report.Warn("mesh-bad-token", std::string(attribute) + " \"" + token + "\" is unknown; UsdGeom's default is taken.");
  return fallback;
}

Sdc::Options ReadOptions(const MeshTopology& topology, const MeshReport& report) {
  using O = Sdc::Options;
  static constexpr TokenValue<O::VtxBoundaryInterpolation> kBoundary[] = {
      {"none", O::VTX_BOUNDARY_NONE}, {"edgeOnly", O::VTX_BOUNDARY_EDGE_ONLY}, {"edgeAndCorner", O::VTX_BOUNDARY_EDGE_AND_CORNER}};
  static constexpr TokenValue<O::FVarLinearInterpolation> kFaceVarying[] = {
      {"none", O::FVAR_LINEAR_NONE},
      {"cornersOnly", O::FVAR_LINEAR_CORNERS_ONLY},
      {"cornersPlus1", O::FVAR_LINEAR_CORNERS_PLUS1},
      {"cornersPlus2", O::FVAR_LINEAR_CORNERS_PLUS2},
      {"boundaries", O::FVAR_LINEAR_BOUNDARIES},
      {"all", O::FVAR_LINEAR_ALL}};
  static constexpr TokenValue<O::TriangleSubdivision> kTriangle[] = {{"catmullClark", O::TRI_SUB_CATMARK}, {"smooth", O::TRI_SUB_SMOOTH}};
  O options;
  options.SetVtxBoundaryInterpolation(
      ReadToken("interpolateBoundary", topology.interpolateBoundary, kBoundary, O::VTX_BOUNDARY_EDGE_AND_CORNER, report));
  options.SetFVarLinearInterpolation(ReadToken("faceVaryingLinearInterpolation", topology.faceVaryingLinearInterpolation,
                                               kFaceVarying, O::FVAR_LINEAR_CORNERS_PLUS1, report));
  options.SetTriangleSubdivision(
      ReadToken("triangleSubdivisionRule", topology.triangleSubdivisionRule, kTriangle, O::TRI_SUB_CATMARK, report));
  return options;
}

struct SharpCorners {
  std::vector<int> vertices;
  std::vector<float> sharpness;
};

struct SharpEdges {
  std::vector<int> vertices;  // pairs
  std::vector<float> sharpness;
};

int VertexOf(const SubdivisionCage& cage, int32_t point) {
  return point >= 0 && static_cast<size_t>(point) < cage.vertexOfPoint.size() ? cage.vertexOfPoint[point] : -1;
}

bool IsSharpness(float s) { return s >= 0; }  // NaN fails; infinity is clamped by OpenSubdiv's limit below

SharpCorners ReadCorners(const MeshTopology& topology, const SubdivisionCage& cage, const MeshReport& report) {
  SharpCorners result;
  const size_t count = std::min(topology.cornerIndices.size(), topology.cornerSharpnesses.size());
  if (topology.cornerIndices.size() != topology.cornerSharpnesses.size())
    report.Warn("mesh-bad-subdivision-tag", "There are " + std::to_string(topology.cornerIndices.size()) + " cornerIndices but " +
                                                std::to_string(topology.cornerSharpnesses.size()) +
                                                " cornerSharpnesses; the rest is ignored.");
  Tally bad;
  for (size_t i = 0; i < count; ++i) {
    const int vertex = VertexOf(cage, topology.cornerIndices[i]);
    if (vertex < 0 || !IsSharpness(topology.cornerSharpnesses[i])) {
      bad.Add(static_cast<int64_t>(i));
      continue;
    }
    result.vertices.push_back(vertex);
    result.sharpness.push_back(std::min(topology.cornerSharpnesses[i], Sdc::Crease::SHARPNESS_INFINITE));
  }
  if (bad.count)
    report.Warn("mesh-bad-subdivision-tag", std::to_string(bad.count) + " corners (first: entry " + std::to_string(bad.first) +
                                                ") name no point of a face or have a bad sharpness; ignored.");
  return result;
}

// Keeps the sharp pairs that are edges of the cage.
void KeepExistingEdges(const SubdivisionCage& cage, SharpEdges& edges, Tally& bad) {
  using Edge = std::pair<int, int>;
  const size_t count = edges.sharpness.size();
  const auto edge = [](int a, int b) { return a < b ? Edge{a, b} : Edge{b, a}; };
  std::vector<Edge> wanted(count);
  for (size_t i = 0; i < count; ++i) wanted[i] = edge(edges.vertices[2 * i], edges.vertices[2 * i + 1]);
  std::vector<Edge> sorted = wanted;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::vector<uint8_t> found(sorted.size(), 0);
  size_t begin = 0;
  for (const int n : cage.counts) {
    for (int k = 0; k < n; ++k) {
      const Edge e = edge(cage.vertices[begin + static_cast<size_t>(k)], cage.vertices[begin + static_cast<size_t>((k + 1) % n)]);
      const auto it = std::lower_bound(sorted.begin(), sorted.end(), e);
      if (it != sorted.end() && *it == e) found[static_cast<size_t>(it - sorted.begin())] = 1;
    }
    begin += static_cast<size_t>(n);
  }
  SharpEdges kept;
  for (size_t i = 0; i < count; ++i) {
    const auto it = std::lower_bound(sorted.begin(), sorted.end(), wanted[i]);
    if (!found[static_cast<size_t>(it - sorted.begin())]) {
      bad.Add(cage.points[edges.vertices[2 * i]]);
      continue;
    }
    kept.vertices.insert(kept.vertices.end(), {edges.vertices[2 * i], edges.vertices[2 * i + 1]});
    kept.sharpness.push_back(edges.sharpness[i]);
  }
  edges = std::move(kept);
}

SharpEdges ReadCreases(const MeshTopology& topology, const SubdivisionCage& cage, const MeshReport& report) {
  SharpEdges result;
  if (topology.creaseLengths.empty()) return result;
  uint64_t points = 0, edgeCount = 0;
  for (const int32_t length : topology.creaseLengths) {
    points += static_cast<uint64_t>(std::max(length, 0));
    edgeCount += static_cast<uint64_t>(std::max(length - 1, 0));
  }
  const size_t given = topology.creaseSharpnesses.size();
  const bool perCrease = given == topology.creaseLengths.size();
  if (!perCrease && given != edgeCount) {
    report.Warn("mesh-bad-subdivision-tag", "There are " + std::to_string(given) + " creaseSharpnesses for " +
                                                std::to_string(topology.creaseLengths.size()) + " creases with " +
                                                std::to_string(edgeCount) + " edges; creases are ignored.");
    return result;
  }
  if (points != topology.creaseIndices.size())
    report.Warn("mesh-bad-subdivision-tag", "creaseLengths sum to " + std::to_string(points) + " but there are " +
                                                std::to_string(topology.creaseIndices.size()) + " creaseIndices; the rest is ignored.");
  Tally bad;
  size_t begin = 0, edge = 0;
  for (size_t c = 0; c < topology.creaseLengths.size(); ++c) {
    const size_t length = static_cast<size_t>(std::max(topology.creaseLengths[c], 0));
    if (length < 2) bad.Add(static_cast<int64_t>(begin));
    for (size_t k = 0; k + 1 < length; ++k, ++edge) {
      if (begin + k + 1 >= topology.creaseIndices.size()) break;
      const int a = VertexOf(cage, topology.creaseIndices[begin + k]), b = VertexOf(cage, topology.creaseIndices[begin + k + 1]);
      const float sharpness = topology.creaseSharpnesses[perCrease ? c : edge];
      if (a < 0 || b < 0 || a == b || !IsSharpness(sharpness)) {
        bad.Add(topology.creaseIndices[begin + k]);
        continue;
      }
      result.vertices.insert(result.vertices.end(), {a, b});
      result.sharpness.push_back(std::min(sharpness, Sdc::Crease::SHARPNESS_INFINITE));
    }
    begin += length;
  }
  KeepExistingEdges(cage, result, bad);
  if (bad.count)
    report.Warn("mesh-bad-subdivision-tag", std::to_string(bad.count) + " crease edges (first: at point " + std::to_string(bad.first) +
                                                ") are no edge of a face or have a bad sharpness; ignored.");
  return result;
}

// OpenSubdiv numbers what meets at a vertex or face with 16 bits. Edges at a vertex: at most two per face.
bool FitsValenceLimit(const SubdivisionCage& cage) {
  std::vector<int> incidence(cage.points.size(), 0);
  for (const int vertex : cage.vertices)
    if (++incidence[vertex] > Far::VALENCE_LIMIT / 2) return false;
  return std::all_of(cage.counts.begin(), cage.counts.end(), [](int n) { return n <= Far::VALENCE_LIMIT; });
}

}  // namespace

SubdivisionCage MakeCage(const MeshInput& input, const CheckedTopology& topology, const MeshReport& report) {
  SubdivisionCage cage;
  cage.counts.reserve(topology.faces.size());
  cage.faces.reserve(topology.faces.size());
  cage.corners.reserve(topology.cornerCount);
  const bool trianglesOnly = topology.scheme == Scheme::Loop;
  PolygonTriangulator triangulator;
  uint64_t cut = 0;
  for (size_t f = 0; f < topology.faces.size(); ++f) {
    if (trianglesOnly && topology.faces[f].count != 3) {
      AddAsTriangles(input, topology.faces[f], static_cast<uint32_t>(f), triangulator, cage);
      ++cut;
    } else {
      AddFace(input, topology.faces[f], static_cast<uint32_t>(f), cage);
    }
  }
  if (cut)
    report.Warn("mesh-loop-needs-triangles",
                "The loop scheme takes triangles only; " + std::to_string(cut) + " larger faces are triangulated first.");
  cage.vertexOfPoint.assign(input.points.size(), -1);
  for (const uint32_t corner : cage.corners) cage.vertexOfPoint[input.topology.faceVertexIndices[corner]] = 0;
  for (size_t p = 0; p < input.points.size(); ++p) {
    if (cage.vertexOfPoint[p] < 0) continue;
    cage.vertexOfPoint[p] = static_cast<int>(cage.points.size());
    cage.points.push_back(static_cast<uint32_t>(p));
  }
  cage.vertices.reserve(cage.corners.size());
  for (const uint32_t corner : cage.corners) cage.vertices.push_back(cage.vertexOfPoint[input.topology.faceVertexIndices[corner]]);
  return cage;
}

FaceVaryingChannels MakeChannels(const SubdivisionCage& cage, const std::vector<CheckedPrimvar>& primvars) {
  FaceVaryingChannels result;
  result.channelOf.assign(primvars.size(), -1);
  result.baseValues.resize(primvars.size());
  for (size_t p = 0; p < primvars.size(); ++p) {
    if (primvars[p].interpolation != AuthoredInterpolation::FaceVarying) continue;
    FaceVaryingChannel channel = primvars[p].indices.empty() ? Weld(cage, primvars[p], result.baseValues[p])
                                                             : Indexed(cage, primvars[p], result.baseValues[p]);
    const auto same = std::find_if(result.channels.begin(), result.channels.end(), [&](const FaceVaryingChannel& other) {
      return other.valueCount == channel.valueCount && other.indices == channel.indices;
    });
    result.channelOf[p] = static_cast<int>(same - result.channels.begin());
    if (same == result.channels.end()) result.channels.push_back(std::move(channel));
  }
  return result;
}

std::unique_ptr<Far::TopologyRefiner> MakeRefiner(const MeshInput& input, const CheckedTopology& topology,
                                                  const SubdivisionCage& cage, const FaceVaryingChannels& channels,
                                                  const MeshReport& report) {
  if (cage.counts.empty()) {
    report.Warn("mesh-not-subdivided", "No face can be subdivided; the mesh is drawn as polygons.");
    return nullptr;
  }
  if (!FitsValenceLimit(cage)) {
    report.Warn("mesh-not-subdivided", "A point or a face has more neighbours than OpenSubdiv can take; the mesh is drawn as polygons.");
    return nullptr;
  }
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const SharpCorners corners = ReadCorners(input.topology, cage, report);
  const SharpEdges creases = ReadCreases(input.topology, cage, report);
  std::vector<Far::TopologyDescriptor::FVarChannel> fvar(channels.channels.size());
  for (size_t i = 0; i < fvar.size(); ++i) {
    fvar[i].numValues = channels.channels[i].valueCount;
    fvar[i].valueIndices = channels.channels[i].indices.data();
  }
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(cage.points.size());
  descriptor.numFaces = static_cast<int>(cage.counts.size());
  descriptor.numVertsPerFace = cage.counts.data();
  descriptor.vertIndicesPerFace = cage.vertices.data();
  descriptor.numCreases = static_cast<int>(creases.sharpness.size());
  descriptor.creaseVertexIndexPairs = creases.vertices.data();
  descriptor.creaseWeights = creases.sharpness.data();
  descriptor.numCorners = static_cast<int>(corners.sharpness.size());
  descriptor.cornerVertexIndices = corners.vertices.data();
  descriptor.cornerWeights = corners.sharpness.data();
  descriptor.numFVarChannels = static_cast<int>(fvar.size());
  descriptor.fvarChannels = fvar.data();
  const Sdc::SchemeType type = topology.scheme == Scheme::Loop       ? Sdc::SCHEME_LOOP
                               : topology.scheme == Scheme::Bilinear ? Sdc::SCHEME_BILINEAR
                                                                     : Sdc::SCHEME_CATMARK;
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(type, ReadOptions(input.topology, report))));
  if (!refiner) report.Warn("mesh-not-subdivided", "OpenSubdiv refuses the mesh's topology; the mesh is drawn as polygons.");
  return refiner;
}

}  // namespace delegate
