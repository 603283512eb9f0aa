// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Displacement terminals -> kernels of their own: what shares one, what is pruned, and what bad networks do.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/materialgen/fixture.h"

namespace materialgen {
namespace {

using Vector = Color;

std::string Source(const Result& result) { return result.material.kernel ? result.material.kernel->displacement : ""; }

Result Displacement(const MaterialNetwork& network) {
  Result result;
  result.material =
      SharedGenerator().GenerateDisplacement(network, [&](const Message& m) { result.messages.push_back(m); });
  if (result.material.kernel) {
    std::string error;
    EXPECT_FALSE(CompileGlsl(Source(result), "displacement", &error).empty()) << error << Source(result);
    EXPECT_TRUE(result.material.kernel->surface.empty());
  }
  return result;
}

MaterialNetwork Node(const std::string& identifier, std::map<std::string, Value> parameters,
                     const std::string& output = "out") {
  MaterialNetwork network;
  network.path = "/m";
  network.nodes = {{"/m/d", identifier, std::move(parameters)}};
  network.displacementNode = "/m/d";
  network.displacementOutput = output;
  return network;
}

TEST(Displacement, ValuesShareAKernelAndZeroHasNone) {
  const Result half = Displacement(Node("ND_displacement_float", {{"displacement", 0.5f}}));
  const Result more = Displacement(Node("ND_displacement_float", {{"displacement", 0.7f}, {"scale", 2.0f}}));
  ASSERT_TRUE(half.material.kernel && more.material.kernel);
  EXPECT_EQ(half.material.kernel, more.material.kernel);
  EXPECT_NE(half.material.parameters, more.material.parameters);
  EXPECT_TRUE(half.messages.empty());
  EXPECT_FALSE(Displacement(Node("ND_displacement_float", {})).material.kernel);
  EXPECT_FALSE(Displacement(Node("ND_displacement_float", {{"displacement", 0.5f}, {"scale", 0.0f}})).material.kernel);
  EXPECT_FALSE(Displacement(Node("ND_displacement_vector3", {{"displacement", Vector{}}})).material.kernel);
  EXPECT_FALSE(Displacement(Node("UsdPreviewSurface", {}, "displacement")).material.kernel);
  const Result preview = Displacement(Node("UsdPreviewSurface", {{"displacement", 0.1f}}, "displacement"));
  EXPECT_TRUE(preview.material.kernel);
  EXPECT_TRUE(preview.messages.empty());
}

TEST(Displacement, ScaleZeroPrunesATexture) {
  MaterialNetwork network = Node("ND_displacement_float", {{"scale", 0.0f}});
  network.nodes.push_back({"/m/t", "UsdUVTexture", {{"file", AssetValue{"a.png", "/a.png", ""}}}});
  network.connections = {{"/m/t", "r", "/m/d", "displacement"}};
  EXPECT_FALSE(Displacement(network).material.kernel);
  network.nodes[0].parameters["scale"] = 0.1f;
  const Result textured = Displacement(network);
  ASSERT_TRUE(textured.material.kernel);
  ASSERT_EQ(textured.material.textures.size(), 1u);
  EXPECT_EQ(textured.material.textures[0].node, "/m/t");
}

TEST(Displacement, SurfaceAndDisplacementDoNotSeeEachOther) {
  MaterialNetwork plain = Node("UsdPreviewSurface", {{"displacement", 0.1f}}, "displacement");
  plain.surfaceNode = plain.displacementNode;
  plain.surfaceOutput = "surface";
  MaterialNetwork textured = plain;
  textured.nodes.push_back({"/m/t", "UsdUVTexture", {{"file", AssetValue{"a.png", "/a.png", ""}}}});
  textured.connections = {{"/m/t", "r", "/m/d", "displacement"}};
  const MessageSink none = [](const Message& m) { ADD_FAILURE() << m.text; };
  EXPECT_EQ(SharedGenerator().Generate(plain, none).kernel, SharedGenerator().Generate(textured, none).kernel);
  EXPECT_TRUE(SharedGenerator().Generate(textured, none).textures.empty());
  textured.connections = {{"/m/t", "rgb", "/m/d", "diffuseColor"}};
  EXPECT_EQ(Displacement(plain).material.kernel, Displacement(textured).material.kernel);
  EXPECT_TRUE(Displacement(textured).material.textures.empty());
  // What is wrong with one is not told of the other again.
  textured.nodes.push_back({"/m/x", "ND_nonsense", {}});
  textured.connections = {{"/m/x", "out", "/m/d", "diffuseColor"}};
  EXPECT_TRUE(Displacement(textured).messages.empty());
}

TEST(Displacement, MixTakesNumbersAndVectors) {
  MaterialNetwork network = Node("ND_mix_displacementshader", {{"mix", 0.25f}});
  network.nodes.push_back({"/m/a", "ND_displacement_vector3", {{"displacement", Vector{1, 2, 3}}}});
  network.nodes.push_back({"/m/b", "ND_displacement_float", {{"displacement", 1.0f}}});
  network.connections = {{"/m/a", "out", "/m/d", "fg"}, {"/m/b", "out", "/m/d", "bg"}};
  EXPECT_NE(Source(Displacement(network)).find("patternUvFrame"), std::string::npos);
  network.connections.pop_back();
  EXPECT_TRUE(Displacement(network).material.kernel);
  network.connections.clear();
  EXPECT_FALSE(Displacement(network).material.kernel);
}

TEST(Displacement, BadNetworksAreSaidAndMoveNothing) {
  MaterialNetwork missing = Node("ND_displacement_float", {{"displacement", 1.0f}});
  missing.displacementNode = "/m/nowhere";
  const Result nowhere = Displacement(missing);
  EXPECT_TRUE(nowhere.Has("material-no-displacement"));
  EXPECT_FALSE(nowhere.material.kernel);
  EXPECT_TRUE(Displacement(Node("ND_standard_surface_surfaceshader", {})).Has("material-no-displacement"));
  EXPECT_TRUE(Displacement(Node("ND_nonsense", {})).Has("material-unknown-node"));
  MaterialNetwork cycle = Node("ND_displacement_float", {});
  cycle.nodes.push_back({"/m/a", "ND_add_float", {}});
  cycle.connections = {{"/m/a", "out", "/m/d", "displacement"}, {"/m/a", "out", "/m/a", "in1"}};
  EXPECT_TRUE(Displacement(cycle).Has("material-cycle"));
}

TEST(Displacement, WorldSpaceIsSaid) {
  MaterialNetwork network = Node("ND_displacement_vector3", {});
  network.nodes.push_back({"/m/p", "ND_position_vector3", {{"space", std::string("world")}}});
  network.connections = {{"/m/p", "out", "/m/d", "displacement"}};
  EXPECT_TRUE(Displacement(network).Has("material-unsupported-feature"));
  network.nodes[1].parameters["space"] = std::string("object");
  EXPECT_FALSE(Displacement(network).Has("material-unsupported-feature"));
}

}  // namespace
}  // namespace materialgen
