// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Random broken meshes: every result keeps its promises (ExpectValid), nothing crashes (run under ASan and UBSan in
// the dev preset).
#include <limits>
#include <random>

#include "tests/delegate/mesh/mesh_test_util.h"

namespace delegate::mesh_test {
namespace {

class Fuzzer {
 public:
  explicit Fuzzer(uint32_t seed) : random_(seed) {}

  MeshInput Make() {
    MeshInput input;
    input.path = "/World/mesh";
    const int pointCount = Int(0, 12);
    for (int i = 0; i < pointCount; ++i) input.points.push_back({Coordinate(), Coordinate(), Coordinate()});
    auto& t = input.topology;
    t.scheme = Pick({"none", "catmullClark", "loop", "bilinear", "", "junk"});
    t.orientation = Pick({"rightHanded", "leftHanded", "junk"});
    t.interpolateBoundary = Pick({"none", "edgeOnly", "edgeAndCorner"});
    t.faceVaryingLinearInterpolation = Pick({"none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"});
    t.triangleSubdivisionRule = Pick({"catmullClark", "smooth"});
    const int faces = Int(0, 8);
    for (int f = 0; f < faces; ++f) {
      const int count = Rarely() ? Int(-2, 30) : Int(3, 6);
      t.faceVertexCounts.push_back(Rarely() ? std::numeric_limits<int32_t>::max() : count);
      for (int k = 0; k < count; ++k) t.faceVertexIndices.push_back(Index(pointCount));
    }
    if (Rarely()) t.faceVertexIndices.resize(size_t(Int(0, 40)), 0);
    t.holeIndices = Indices(Int(0, 2), faces);
    t.cornerIndices = Indices(Int(0, 3), pointCount);
    t.cornerSharpnesses = Floats(Int(0, 3));
    AddCreases(t, pointCount);
    for (int s = Int(0, 2); s > 0; --s) t.subsets.push_back({"/World/mesh/s", Indices(Int(0, 4), faces)});
    for (int p = Int(0, 4); p > 0; --p) input.primvars.push_back(Primvar(input));
    input.refineLevel = Int(-1, 3);
    if (Rarely()) input.maxTriangles = uint64_t(Int(0, 100));
    return input;
  }

 private:
  int Int(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool Rarely() { return Int(0, 19) == 0; }
  std::string Pick(std::initializer_list<const char*> options) { return *(options.begin() + Int(0, int(options.size()) - 1)); }
  float Coordinate() {
    if (Int(0, 99) == 0) return std::numeric_limits<float>::quiet_NaN();
    if (Int(0, 99) == 0) return std::numeric_limits<float>::max();
    if (Int(0, 99) == 0) return 1e18f;
    return float(Int(-4, 4));  // coincident and flat shapes are common
  }
  int32_t Index(int count) { return Int(0, 99) == 0 ? Int(-5, 100) : Int(0, std::max(count - 1, 0)); }
  std::vector<int32_t> Indices(int n, int count) {
    std::vector<int32_t> result;
    for (int i = 0; i < n; ++i) result.push_back(Index(count));
    return result;
  }
  std::vector<float> Floats(int n) {
    std::vector<float> result;
    for (int i = 0; i < n; ++i) result.push_back(Rarely() ? std::numeric_limits<float>::infinity() : float(Int(-1, 11)));
    return result;
  }
  void AddCreases(MeshTopology& t, int pointCount) {
    int points = 0, edges = 0;
    for (int c = Int(0, 3); c > 0; --c) {
      const int length = Rarely() ? Int(-3, 100) : Int(2, 4);
      t.creaseLengths.push_back(length);
      points += std::max(length, 0);
      edges += std::max(length - 1, 0);
    }
    t.creaseIndices = Indices(Rarely() ? Int(0, 9) : points, pointCount);
    t.creaseSharpnesses = Floats(Int(0, 1) ? edges : int(t.creaseLengths.size()));
  }
  PrimvarInput Primvar(const MeshInput& input) {
    PrimvarInput p;
    p.name = Pick({"st", "normals", "a", "b"});
    p.interpolation = Pick({"constant", "uniform", "vertex", "varying", "faceVarying"});
    p.components = p.name == "normals" ? 3 : uint32_t(Int(0, 5) == 5 ? 16 : Int(1, 4));
    int elements = 1;
    if (p.interpolation == "uniform") elements = int(input.topology.faceVertexCounts.size());
    if (p.interpolation == "vertex" || p.interpolation == "varying") elements = int(input.points.size());
    if (p.interpolation == "faceVarying") elements = int(input.topology.faceVertexIndices.size());
    if (Int(0, 1)) {
      const int values = Int(1, 20);
      p.indices = Indices(Rarely() ? elements / 2 : elements, values);
      elements = values;
    }
    if (Rarely()) --elements;
    p.values = Floats(std::max(elements, 0) * int(p.components));
    return p;
  }
  std::mt19937 random_;
};

TEST(MeshFuzz, BrokenMeshesKeepThePromises) {
  int drawn = 0, subdivided = 0;
  for (uint32_t seed = 0; seed < 20000; ++seed) {
    const MeshInput input = Fuzzer(seed).Make();
    const Built built = Build(input);
    ASSERT_FALSE(HasFatalFailure()) << "seed " << seed;
    if (built.mesh) ++drawn;
    if (built.mesh && input.refineLevel > 0 && input.topology.scheme != "none") ++subdivided;
    if (!built.mesh && input.topology.holeIndices.empty()) {
      ASSERT_FALSE(built.diagnostics.empty()) << "seed " << seed;
    }
  }
  // The fuzzer must reach what it is meant to test.
  EXPECT_GT(drawn, 5000);
  EXPECT_GT(subdivided, 2000);
}

}  // namespace
}  // namespace delegate::mesh_test
