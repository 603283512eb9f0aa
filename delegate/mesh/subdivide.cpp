// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/subdivide.h"

#include <opensubdiv/far/primvarRefiner.h>

#include <algorithm>
#include <numeric>

#include "delegate/mesh/limit_normals.h"
#include "delegate/mesh/subdivision_base.h"
#include "delegate/mesh/triangulate.h"

namespace delegate {
namespace {

namespace Far = OpenSubdiv::Far;
using wavefront::Float3;
using wavefront::Interpolation;
using wavefront::MeshData;
using wavefront::PrimvarData;

// OpenSubdiv numbers with int, and the last level's edges and corners are four times its quads.
constexpr uint64_t kMostTriangles = 500'000'000;

// N floats of an interleaved array, with the operations that PrimvarRefiner asks for.
template <int N>
struct Row {
  float* p;
  void Clear() {
    for (int c = 0; c < N; ++c) p[c] = 0;
  }
  void AddWithWeight(const Row& other, float weight) {
    for (int c = 0; c < N; ++c) p[c] += weight * other.p[c];
  }
};

template <int N>
struct Rows {
  float* data;
  size_t stride;
  Row<N> operator[](int i) const { return {data + static_cast<size_t>(i) * stride}; }
};

enum class Rule { Vertex, Varying, FaceVarying };

// One step of refinement (level 1 and up), or the limit of the last level (level 0), for N of `stride` components.
template <int N>
void RefineStep(const Far::PrimvarRefiner& refiner, Rule rule, int channel, int level, float* source, float* target, size_t stride) {
  const Rows<N> from{source, stride};
  Rows<N> to{target, stride};
  if (rule == Rule::FaceVarying) {
    if (level) refiner.InterpolateFaceVarying(level, from, to, channel);
    else refiner.LimitFaceVarying(from, to, channel);
  } else if (rule == Rule::Varying) {
    refiner.InterpolateVarying(level, from, to);
  } else {
    if (level) refiner.Interpolate(level, from, to);
    else refiner.Limit(from, to);
  }
}

void RefineStep(const Far::PrimvarRefiner& refiner, Rule rule, int channel, int level, uint32_t components,
                std::vector<float>& source, std::vector<float>& target) {
  for (uint32_t c = 0; c < components; c += 4) {
    float* from = source.data() + c;
    float* to = target.data() + c;
    switch (std::min(components - c, 4u)) {
      case 1: RefineStep<1>(refiner, rule, channel, level, from, to, components); break;
      case 2: RefineStep<2>(refiner, rule, channel, level, from, to, components); break;
      case 3: RefineStep<3>(refiner, rule, channel, level, from, to, components); break;
      default: RefineStep<4>(refiner, rule, channel, level, from, to, components); break;
    }
  }
}

// From the cage to the last level, before the limit.
std::vector<float> RefineToLastLevel(const Far::TopologyRefiner& topology, Rule rule, int channel, uint32_t components,
                                     std::vector<float> values) {
  const Far::PrimvarRefiner refiner(topology);
  for (int level = 1; level <= topology.GetMaxLevel(); ++level) {
    const Far::TopologyLevel& target = topology.GetLevel(level);
    const int count = rule == Rule::FaceVarying ? target.GetNumFVarValues(channel) : target.GetNumVertices();
    std::vector<float> next(static_cast<size_t>(count) * components);
    RefineStep(refiner, rule, channel, level, components, values, next);
    values = std::move(next);
  }
  return values;
}

std::vector<float> RefineToLimit(const Far::TopologyRefiner& topology, Rule rule, int channel, uint32_t components,
                                 std::vector<float> values) {
  values = RefineToLastLevel(topology, rule, channel, components, std::move(values));
  if (rule == Rule::Varying) return values;  // linear: already on its limit
  std::vector<float> limit(values.size());
  RefineStep(Far::PrimvarRefiner(topology), rule, channel, 0, components, values, limit);
  return limit;
}

std::vector<float> GatherPoints(const SubdivisionCage& cage, const std::vector<float>& values, uint32_t components) {
  std::vector<float> result;
  result.reserve(cage.points.size() * components);
  for (const uint32_t point : cage.points)
    result.insert(result.end(), values.begin() + static_cast<std::ptrdiff_t>(point) * components,
                  values.begin() + static_cast<std::ptrdiff_t>(point + 1) * components);
  return result;
}

// The highest level, at most the one asked for, whose triangles fit.
int FittingLevel(const MeshInput& input, const CheckedTopology& topology, const SubdivisionCage& cage, const MeshReport& report) {
  const uint64_t most = std::min(input.maxTriangles, kMostTriangles);
  const auto triangles = [&](int level) {
    const uint64_t perStep = uint64_t{1} << (2 * level);
    return topology.scheme == Scheme::Loop ? cage.counts.size() * perStep : cage.corners.size() * perStep / 2;
  };
  int level = topology.level;
  while (level > 0 && triangles(level) > most) --level;
  if (level < topology.level)
    report.Warn("mesh-too-fine", "Refinement level " + std::to_string(topology.level) + " would make " +
                                     std::to_string(triangles(topology.level)) + " triangles, more than " + std::to_string(most) +
                                     "; level " + std::to_string(level) + " is taken.");
  return level;
}

std::vector<uint32_t> LastLevelParents(const Far::TopologyRefiner& topology, const SubdivisionCage& cage) {
  const Far::PrimvarRefiner refiner(topology);
  std::vector<uint32_t> parents = cage.faces;
  for (int level = 1; level <= topology.GetMaxLevel(); ++level) {
    std::vector<uint32_t> next(static_cast<size_t>(topology.GetLevel(level).GetNumFaces()));
    refiner.InterpolateFaceUniform(level, parents, next);
    parents = std::move(next);
  }
  return parents;
}

// Positions on the limit surface; the normals too, unless the surface is faceted.
LimitNormals PlacePoints(const Far::TopologyRefiner& refiner, const SubdivisionCage& cage, const MeshInput& input,
                         const CheckedTopology& topology, uint32_t cornersPerFace, MeshData& mesh) {
  std::vector<float> base;
  base.reserve(3 * cage.points.size());
  for (const uint32_t point : cage.points) {
    const Float3& p = input.points[point];
    base.insert(base.end(), {p.x, p.y, p.z});
  }
  std::vector<float> refined = RefineToLastLevel(refiner, Rule::Vertex, 0, 3, std::move(base));
  std::vector<float> limit(refined.size());
  LimitNormals normals;
  if (topology.scheme == Scheme::Bilinear) {
    limit = std::move(refined);
  } else {
    std::vector<float> tangent1(refined.size()), tangent2(refined.size());
    const Rows<3> from{refined.data(), 3};
    Rows<3> to{limit.data(), 3}, t1{tangent1.data(), 3}, t2{tangent2.data(), 3};
    Far::PrimvarRefiner(refiner).Limit(from, to, t1, t2);
    refined = {};
    normals = ComputeLimitNormals(refiner.GetLevel(refiner.GetMaxLevel()), cornersPerFace, limit, tangent1, tangent2,
                                  topology.leftHanded);
  }
  mesh.positions.resize(limit.size() / 3);
  for (size_t i = 0; i < mesh.positions.size(); ++i) mesh.positions[i] = {limit[3 * i], limit[3 * i + 1], limit[3 * i + 2]};
  return normals;
}

// Triangles of the last level, holes left out, and per triangle corner what each face-varying channel and the normals
// select.
struct FaceWriter {
  const Far::TopologyLevel& level;
  const CheckedTopology& topology;
  const LimitNormals& normals;
  uint32_t cornersPerFace;
  MeshData& mesh;
  std::vector<std::vector<uint32_t>> channelIndices;
  std::vector<uint32_t> normalIndices;

  void Add(int face, uint32_t checkedFace, int a, int b, int c) {
    if (topology.leftHanded) std::swap(b, c);
    const Far::ConstIndexArray verts = level.GetFaceVertices(face);
    mesh.triangles.push_back({static_cast<uint32_t>(verts[a]), static_cast<uint32_t>(verts[b]), static_cast<uint32_t>(verts[c])});
    const uint32_t id = topology.faces[checkedFace].id;
    mesh.faceIds.push_back(id);
    if (!topology.slots.empty()) mesh.materialSlots.push_back(topology.slots[id]);
    for (size_t channel = 0; channel < channelIndices.size(); ++channel) {
      const Far::ConstIndexArray values = level.GetFaceFVarValues(face, static_cast<int>(channel));
      for (const int k : {a, b, c}) channelIndices[channel].push_back(static_cast<uint32_t>(values[k]));
    }
    if (normals.corners.empty()) return;
    for (const int k : {a, b, c})
      normalIndices.push_back(normals.corners[static_cast<size_t>(face) * cornersPerFace + static_cast<size_t>(k)]);
  }

  void AddAll(const std::vector<uint32_t>& parents) {
    const auto at = [&](int vertex) { return Vec3(mesh.positions[static_cast<size_t>(vertex)]); };
    for (int face = 0; face < level.GetNumFaces(); ++face) {
      const uint32_t parent = parents[static_cast<size_t>(face)];
      // OpenSubdiv marks holes of its own: faces at a boundary that interpolateBoundary "none" leaves undefined.
      if (level.IsFaceHole(face) || (!topology.isHole.empty() && topology.isHole[parent])) continue;
      const Far::ConstIndexArray v = level.GetFaceVertices(face);
      if (v.size() == 3) {
        Add(face, parent, 0, 1, 2);
      } else if (SplitsAlongAC(at(v[0]), at(v[1]), at(v[2]), at(v[3]))) {
        Add(face, parent, 0, 1, 2);
        Add(face, parent, 0, 2, 3);
      } else {
        Add(face, parent, 0, 1, 3);
        Add(face, parent, 1, 2, 3);
      }
    }
  }

  void Reserve() {
    const size_t count = static_cast<size_t>(level.GetNumFaces()) * (cornersPerFace - 2);
    mesh.triangles.reserve(count);
    mesh.faceIds.reserve(count);
    if (!topology.slots.empty()) mesh.materialSlots.reserve(count);
    for (auto& indices : channelIndices) indices.reserve(3 * count);
    if (!normals.corners.empty()) normalIndices.reserve(3 * count);
  }
};

PrimvarData RefinePrimvar(const Far::TopologyRefiner& refiner, const SubdivisionCage& cage, const CheckedPrimvar& primvar,
                          int channel, std::vector<float> channelBase, const FaceWriter& faces) {
  PrimvarData data;
  data.name = primvar.name;
  data.components = primvar.components;
  switch (primvar.interpolation) {
    case AuthoredInterpolation::Constant:
    case AuthoredInterpolation::Uniform:
      data.interpolation = primvar.interpolation == AuthoredInterpolation::Constant ? Interpolation::Constant : Interpolation::Uniform;
      data.values = primvar.values;
      break;
    case AuthoredInterpolation::Vertex:
    case AuthoredInterpolation::Varying: {
      const Rule rule = primvar.interpolation == AuthoredInterpolation::Vertex ? Rule::Vertex : Rule::Varying;
      data.interpolation = Interpolation::Vertex;
      data.values = RefineToLimit(refiner, rule, 0, primvar.components, GatherPoints(cage, primvar.values, primvar.components));
      break;
    }
    case AuthoredInterpolation::FaceVarying:
      data.interpolation = Interpolation::FaceVarying;
      data.values = RefineToLimit(refiner, Rule::FaceVarying, channel, primvar.components, std::move(channelBase));
      data.indices = faces.channelIndices[static_cast<size_t>(channel)];
      break;
  }
  return data;
}

}  // namespace

std::optional<MeshData> Subdivide(const MeshInput& input, const CheckedTopology& topology,
                                  const std::vector<CheckedPrimvar>& primvars, const MeshReport& report) {
  SubdivisionCage cage = MakeCage(input, topology, report);
  const int levels = FittingLevel(input, topology, cage, report);
  if (levels == 0) return std::nullopt;
  FaceVaryingChannels channels = MakeChannels(cage, primvars);
  const std::unique_ptr<Far::TopologyRefiner> refiner = MakeRefiner(input, topology, cage, channels, report);
  if (!refiner) return std::nullopt;
  // The refiner has its own copy; the last level is what takes memory.
  cage.counts = {};
  cage.vertices = {};
  cage.corners = {};
  const size_t channelCount = channels.channels.size();
  channels.channels = {};

  Far::TopologyRefiner::UniformOptions options(levels);
  options.fullTopologyInLastLevel = true;  // the limit needs the neighbours of each vertex
  refiner->RefineUniform(options);
  const Far::TopologyLevel& last = refiner->GetLevel(levels);
  const uint32_t cornersPerFace = topology.scheme == Scheme::Loop ? 3 : 4;

  MeshData mesh;
  mesh.doubleSided = input.doubleSided;
  LimitNormals normals = PlacePoints(*refiner, cage, input, topology, cornersPerFace, mesh);
  FaceWriter faces{last, topology, normals, cornersPerFace, mesh, std::vector<std::vector<uint32_t>>(channelCount), {}};
  faces.Reserve();
  faces.AddAll(LastLevelParents(*refiner, cage));
  if (mesh.triangles.empty()) return mesh;  // nothing but holes
  for (size_t p = 0; p < primvars.size(); ++p)
    mesh.primvars.push_back(
        RefinePrimvar(*refiner, cage, primvars[p], channels.channelOf[p], std::move(channels.baseValues[p]), faces));
  if (!normals.values.empty()) {
    PrimvarData data;
    data.name = "normals";
    data.components = 3;
    data.interpolation = normals.corners.empty() ? Interpolation::Vertex : Interpolation::FaceVarying;
    data.values = std::move(normals.values);
    data.indices = std::move(faces.normalIndices);
    mesh.primvars.push_back(std::move(data));
  }
  return mesh;
}

}  // namespace delegate
