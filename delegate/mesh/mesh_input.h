// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What a host hands over for one polygon or subdivision mesh: UsdGeomMesh's values as authored, unchecked.
// Tokens are UsdGeom's and Hydra's, verbatim. Nothing here is trusted: BuildMesh (build_mesh.h) checks it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "wavefront/types.h"

namespace delegate {

// Faces that wear a material of their own (UsdGeomSubset of element type face, family materialBind).
struct GeomSubset {
  std::string path;               // named in diagnostics
  std::vector<int32_t> indices;   // authored faces
};

// Lengths and counts are int32 as in USD, so that negative values arrive here and are reported.
struct MeshTopology {
  std::string scheme = "catmullClark";      // none, catmullClark, loop, bilinear
  std::string orientation = "rightHanded";  // rightHanded, leftHanded
  std::vector<int32_t> faceVertexCounts;
  std::vector<int32_t> faceVertexIndices;
  std::vector<int32_t> holeIndices;         // authored faces that are not drawn
  // Subdivision tags. An empty token means UsdGeomMesh's default, which is the value given here.
  std::string interpolateBoundary = "edgeAndCorner";          // none, edgeOnly, edgeAndCorner
  std::string faceVaryingLinearInterpolation = "cornersPlus1";  // none, cornersOnly, cornersPlus1, cornersPlus2,
                                                                // boundaries, all
  std::string triangleSubdivisionRule = "catmullClark";       // catmullClark, smooth
  std::vector<int32_t> cornerIndices;       // points
  std::vector<float> cornerSharpnesses;     // one per corner; 10 and more is infinitely sharp
  std::vector<int32_t> creaseIndices;       // points, chained
  std::vector<int32_t> creaseLengths;       // points of each chain, at least 2
  std::vector<float> creaseSharpnesses;     // one per chain, or one per edge of all chains
  std::vector<GeomSubset> subsets;          // subset i wears material slot i + 1; the rest slot 0
};

struct PrimvarInput {
  std::string name;
  std::string interpolation = "constant";  // constant, uniform, vertex, varying, faceVarying
  uint32_t components = 1;                  // floats per element: 1..4, or 16
  std::vector<float> values;
  std::vector<int32_t> indices;             // empty: not indexed
};

struct MeshInput {
  std::string path;                          // prim path, named in every diagnostic
  MeshTopology topology;
  std::vector<wavefront::Float3> points;     // object space
  std::vector<PrimvarInput> primvars;        // authored normals come as "normals" (UsdGeomMesh.normals or primvars:normals)
  int refineLevel = 0;                       // 0..8: low 0, medium 1, high 2, veryhigh 3 of usdrecord's --complexity
  // Of a displaced mesh, 0..8: subdivision surfaces are refined this far instead, polygons split (split_triangles.h).
  std::optional<int> displacementLevel;
  bool doubleSided = false;
  uint64_t maxTriangles = 8'000'000;         // subdivision stops at the level that stays below (about 220 bytes each
                                             // while building); polygons are never cut
};

}  // namespace delegate
