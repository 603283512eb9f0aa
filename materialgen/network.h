// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A shading network as a host hands it over: nodes, values, connections. Host-neutral (no pxr).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace materialgen {

// An image file input. `resolvedPath` is what the host's resolver found (empty: not found); `authoredPath` is for
// diagnostics. `colorSpace`: as authored on the attribute (may be empty).
struct AssetValue {
  std::string authoredPath;
  std::string resolvedPath;
  std::string colorSpace;
};

using Value = std::variant<std::monostate, bool, int32_t, float, std::array<float, 2>, std::array<float, 3>,
                           std::array<float, 4>, std::array<float, 9>, std::array<float, 16>, std::string, AssetValue>;

struct Node {
  std::string path;        // prim path; unique in the network; named in diagnostics
  std::string identifier;  // info:id: "UsdPreviewSurface", "UsdUVTexture", "ND_standard_surface_surfaceshader", ...
  std::map<std::string, Value> parameters;  // authored values only; colours already in the rendering colour space
};

struct Connection {
  std::string upstreamNode, upstreamOutput;      // node path, output name ("out", "rgb", "surface", ...)
  std::string downstreamNode, downstreamInput;
};

// One terminal's network. Several contexts (own, mtlx, universal) are several networks; the delegate chooses.
struct MaterialNetwork {
  std::string path;               // of the material prim
  std::vector<Node> nodes;
  std::vector<Connection> connections;
  std::string surfaceNode;        // node path of the surface terminal
  std::string surfaceOutput;
  std::string displacementNode;   // of the displacement terminal; empty: none
  std::string displacementOutput;
};

}  // namespace materialgen
