// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What bad, long and random networks do: a diagnostic, never a crash or a hang.
#include "tests/materialgen/fixture.h"

#include <ctime>
#include <limits>
#include <random>

namespace materialgen {
namespace {

// USD and MaterialX let no colour flow into a number: said where it happens. A channel of it, or a number for a colour, fit.
TEST(MaterialGen, ConnectionsThatLoseComponentsAreSaid) {
  const auto messages = [](const char* node, const char* output, const char* input) {
    MaterialNetwork network = Preview();
    network.nodes.push_back({"/Looks/m/up", node, {}});
    network.connections.push_back({"/Looks/m/up", output, "/Looks/m/surface", input});
    return RunNetwork(network).messages;
  };
  const std::vector<Message> lost = messages("ND_constant_color3", "out", "roughness");
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].code, "material-type-mismatch");
  EXPECT_EQ(lost[0].location, "/Looks/m/surface");
  EXPECT_EQ(lost[0].text, "what is connected to input 'roughness' has 3 components; of them 1 is used");
  EXPECT_EQ(messages("ND_constant_color4", "out", "diffuseColor").size(), 1u);
  EXPECT_EQ(messages("ND_constant_vector3", "out", "opacity").size(), 1u);
  EXPECT_TRUE(messages("ND_constant_float", "out", "diffuseColor").empty());
  EXPECT_TRUE(messages("ND_constant_vector3", "out", "diffuseColor").empty());
  EXPECT_TRUE(messages("UsdUVTexture", "r", "roughness").empty());
  EXPECT_TRUE(messages("UsdUVTexture", "rgb", "diffuseColor").empty());
}

TEST(MaterialGen, UnknownNodesAreNamedAndShow) {
  MaterialNetwork network = Preview();
  network.nodes.push_back({"/Looks/m/strange", "ND_no_such_node", {}});
  network.connections.push_back({"/Looks/m/strange", "out", network.surfaceNode, "diffuseColor"});
  const Result result = RunNetwork(network);
  ASSERT_EQ(result.messages.size(), 1u);
  EXPECT_EQ(result.messages[0].code, "material-unknown-node");
  EXPECT_EQ(result.messages[0].location, "/Looks/m/strange");
  ExpectCompiles(result.material, "unknown");
  std::string where;
  EXPECT_FALSE(SharedGenerator().Supports(network, &where));
  EXPECT_EQ(where, "/Looks/m/strange");
  EXPECT_TRUE(SharedGenerator().Supports(Preview(), nullptr));
}

TEST(MaterialGen, MalformedNetworks) {
  MaterialNetwork empty;
  EXPECT_TRUE(RunNetwork(empty).Has("material-no-surface"));
  ExpectCompiles(RunNetwork(empty).material, "empty");

  MaterialNetwork unknown = Preview();
  unknown.nodes[0].identifier = "NoSuchSurface";
  EXPECT_TRUE(RunNetwork(unknown).Has("material-unknown-node"));
  EXPECT_EQ(Lobes(RunNetwork(unknown)), (std::vector<std::string>{"oren_nayar"}));

  MaterialNetwork notSurface = Preview();
  notSurface.nodes[0].identifier = "UsdPrimvarReader_float";
  EXPECT_TRUE(RunNetwork(notSurface).Has("material-no-surface"));

  MaterialNetwork dangling = Preview();
  dangling.connections.push_back({"/nowhere", "out", dangling.surfaceNode, "roughness"});
  EXPECT_TRUE(RunNetwork(dangling).Has("material-dangling-connection"));

  MaterialNetwork output = Preview();
  output.nodes.push_back({"/t", "UsdUVTexture", {}});
  output.connections.push_back({"/t", "nonsense", output.surfaceNode, "diffuseColor"});
  EXPECT_TRUE(RunNetwork(output).Has("material-unknown-output"));

  const Result type =
      RunNetwork(Preview({{"diffuseColor", std::string("red")}, {"roughness", AssetValue{"a", "b", ""}}}));
  EXPECT_TRUE(type.Has("material-type-mismatch"));
  ExpectCompiles(type.material, "type");

  const Result bad = RunNetwork(Preview({{"roughness", std::numeric_limits<float>::quiet_NaN()}, {"ior", -1.0f}}));
  EXPECT_TRUE(bad.Has("material-bad-value"));
  for (float value : bad.material.parameters) EXPECT_TRUE(std::isfinite(value));
}

// A colour where a number is wanted: its first component is taken, and that is said; so are fewer components for more.
TEST(MaterialGen, ValuesWithTooManyComponentsAreSaid) {
  using Float2 = std::array<float, 2>;
  const auto said = [](std::map<std::string, Value> parameters) { return RunNetwork(Standard(std::move(parameters))); };
  const Result result = said({{"metalness", Color{0.2f, 0.4f, 0.6f}}});
  ASSERT_EQ(result.messages.size(), 1u);
  EXPECT_EQ(result.messages[0].code, "material-type-mismatch");
  EXPECT_EQ(result.messages[0].location, "/Looks/m/surface");
  EXPECT_NE(result.messages[0].text.find("metalness"), std::string::npos);
  EXPECT_TRUE(said({{"thin_walled", Float2{1, 0}}}).Has("material-type-mismatch"));
  EXPECT_TRUE(said({{"base_color", std::array<float, 4>{1, 1, 1, 1}}}).Has("material-type-mismatch"));
  EXPECT_TRUE(said({{"metalness", int32_t{1}}, {"base_color", 0.5f}, {"thin_walled", 1.0f}}).messages.empty());
}

TEST(MaterialGen, Cycles) {
  MaterialNetwork network = Preview();
  network.nodes.push_back({"/a", "ND_add_color3", {}});
  network.nodes.push_back({"/b", "ND_multiply_color3", {}});
  network.connections = {
      {"/a", "out", network.surfaceNode, "diffuseColor"}, {"/b", "out", "/a", "in1"}, {"/a", "out", "/b", "in1"}};
  const Result result = RunNetwork(network);
  EXPECT_TRUE(result.Has("material-cycle"));
  ExpectCompiles(result.material, "cycle");
  MaterialNetwork self = Preview();
  self.connections = {{self.surfaceNode, "surface", self.surfaceNode, "roughness"}};
  EXPECT_TRUE(RunNetwork(self).Has("material-cycle"));
}

// `count` nodes in a row: values fold on the CPU; what a texture feeds has a bound.
TEST(MaterialGen, LongChains) {
  for (const bool isTextured : {false, true}) {
    for (const char* kind : {"ND_add_color3", "ND_multiply_color3", "ND_mix_color3", "ND_power_color3"}) {
      MaterialNetwork network = Preview();
      std::string upstream;
      for (int i = 0; i < 10000; ++i) {
        const std::string path = "/n" + std::to_string(i);
        network.nodes.push_back({path, kind, {{i % 2 ? "in1" : "in2", Color{0.999f, 0.5f, 0.1f}}}});
        const std::string input = std::string(kind) == "ND_mix_color3" ? "bg" : "in1";
        if (i) network.connections.push_back({upstream, "out", path, input});
        upstream = path;
      }
      network.connections.push_back({upstream, "out", network.surfaceNode, "diffuseColor"});
      if (isTextured) {
        network.nodes.push_back({"/t", "UsdUVTexture", {{"file", AssetValue{"a.png", "a.png", ""}}}});
        network.connections.push_back({"/t", "rgb", "/n0", "in1"});
        network.connections.push_back({"/t", "rgb", "/n0", "bg"});
      }
      const std::clock_t start = std::clock();  // of this process: not what else the machine does
      const Result result = RunNetwork(network);
      EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 20.0) << kind;
      if (!isTextured) ExpectCompiles(result.material, kind);
    }
  }
}

// A sum of `count` noises: each some 1,700 instructions once it is inlined.
MaterialNetwork Noises(int count, const char* node) {
  MaterialNetwork network = Preview();
  network.nodes.push_back({"/uv", "ND_texcoord_vector2", {}});
  network.nodes.push_back({"/p", "ND_position_vector3", {}});
  std::string sum;
  for (int i = 0; i < count; ++i) {
    const std::string at = "/at" + std::to_string(i), noise = "/noise" + std::to_string(i), add = "/add" + std::to_string(i);
    network.nodes.push_back({at, "ND_multiply_vector2FA", {{"in2", 1 + 0.37f * float(i)}}});
    network.nodes.push_back({noise, node, {}});
    network.nodes.push_back({add, "ND_add_float", {}});
    network.connections.push_back({"/uv", "out", at, "in1"});
    network.connections.push_back({at, "out", noise, "texcoord"});
    network.connections.push_back({noise, "out", add, "in1"});
    if (i) network.connections.push_back({sum, "out", add, "in2"});
    sum = add;
  }
  network.connections.push_back({sum, "out", network.surfaceNode, "roughness"});
  return network;
}

// What a driver would compile for too long is refused before it gets there; what it can do in time is not.
TEST(MaterialGen, SizeHasALimit) {
  const Result large = RunNetwork(Noises(200, "ND_noise2d_float"));
  EXPECT_TRUE(large.messages.empty());
  std::string error;
  const uint64_t instructions = InlinedInstructions(CompileGlsl(large.material.kernel->surface, "large", &error));
  EXPECT_GT(instructions, 300000u);
  EXPECT_LE(instructions, 400000u);
  for (const int count : {260, 1000}) {  // by instructions, and by characters
    const Result refused = RunNetwork(Noises(count, "ND_noise2d_float"));
    ASSERT_EQ(refused.messages.size(), 1u) << count;
    EXPECT_EQ(refused.messages[0].code, "material-too-large");
    EXPECT_EQ(refused.messages[0].location, "/Looks/m");
    EXPECT_EQ(Lobes(refused), (LobeNames{"oren_nayar"})) << "magenta";
    EXPECT_TRUE(RunNetwork(Noises(count, "ND_noise2d_float")).Has("material-too-large")) << "again";
  }
  MaterialNetwork displaced = Noises(260, "ND_noise2d_float");
  displaced.nodes.push_back({"/d", "ND_displacement_float", {}});
  displaced.connections.push_back({displaced.connections.back().upstreamNode, "out", "/d", "displacement"});
  displaced.displacementNode = "/d";
  displaced.displacementOutput = "out";
  std::vector<Message> messages;
  const auto sink = [&](const Message& m) { messages.push_back(m); };
  EXPECT_EQ(SharedGenerator().GenerateDisplacement(displaced, sink).kernel, nullptr);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].code, "material-too-large");
}

TEST(MaterialGen, CallsCountWhatTheyCall) {
  const auto count = [](const std::string& body) {
    std::string error;
    const std::string head = "#version 460\nlayout(local_size_x = 1) in;\nlayout(binding = 0) buffer B { float b[]; };\n";
    const std::string functions = "float one(float x) { return sin(x) + 1.0; }\nfloat two(float x) { return one(one(x)); }\n";
    const std::vector<uint32_t> spirv = CompileGlsl(head + functions + "void main() { " + body + " }\n", "count", &error);
    EXPECT_FALSE(spirv.empty()) << error;
    return InlinedInstructions(spirv);
  };
  const uint64_t none = count(""), one = count("b[0] = one(2.0);") - none, two = count("b[0] = two(2.0);") - none;
  const uint64_t three = count("b[0] = two(one(2.0));") - none;
  EXPECT_GT(two, one);
  EXPECT_GT(three, two);
  EXPECT_GE(count("b[0] = two(two(two(two(2.0))));") - none, 4 * (two - one));
  EXPECT_LT(count(""), count("b[0] = 1.0;"));
  EXPECT_EQ(InlinedInstructions({}), 0u);
}

TEST(MaterialGen, LongClosureChain) {
  MaterialNetwork network;
  network.path = "/m";
  network.nodes.push_back({"/surface", "ND_surface", {}});
  network.surfaceNode = "/surface";
  network.surfaceOutput = "out";
  network.nodes.push_back({"/d", "ND_oren_nayar_diffuse_bsdf", {}});
  std::string upstream = "/d";
  for (int i = 0; i < 10000; ++i) {
    const std::string path = "/n" + std::to_string(i);
    network.nodes.push_back({path, "ND_multiply_bsdfF", {{"in2", 0.9999f}}});
    network.connections.push_back({upstream, "out", path, "in1"});
    upstream = path;
  }
  network.connections.push_back({upstream, "out", "/surface", "bsdf"});
  ExpectCompiles(RunNetwork(network).material, "closure chain");
}

// Random wiring of random nodes, wrong types and all: no crash, and what comes out compiles.
TEST(MaterialGen, FuzzedNetworks) {
  const std::vector<std::string> kinds = {"UsdPreviewSurface",
                                          "UsdUVTexture",
                                          "UsdPrimvarReader_float2",
                                          "UsdTransform2d",
                                          "ND_add_color3",
                                          "ND_mix_float",
                                          "ND_multiply_vector2",
                                          "ND_image_color3",
                                          "ND_noise2d_float",
                                          "ND_fractal3d_vector3",
                                          "ND_ifgreater_color3",
                                          "ND_switch_float",
                                          "ND_combine3_color3",
                                          "ND_separate4_color4",
                                          "ND_standard_surface_surfaceshader",
                                          "ND_normalmap_float",
                                          "ND_layer_bsdf",
                                          "ND_mix_bsdf",
                                          "ND_dielectric_bsdf",
                                          "ND_conductor_bsdf",
                                          "ND_sheen_bsdf",
                                          "ND_uniform_edf",
                                          "ND_surface",
                                          "ND_place2d_vector2",
                                          "ND_tiledimage_color3",
                                          "ND_ramplr_color3",
                                          "ND_hsvadjust_color3",
                                          "ND_contrast_float",
                                          "Nonsense",
                                          "ND_convert_float_color3",
                                          "ND_extract_color3",
                                          "ND_rotate3d_vector3",
                                          "ND_creatematrix_vector3_matrix33",
                                          "ND_transformmatrix_vector3",
                                          "ND_position_vector3",
                                          "ND_geompropvalue_color3",
                                          "ND_ifequal_colorB",
                                          "ND_mix_surfaceshader"};
  const std::vector<std::string> inputs = {"in",           "in1",      "in2",    "fg",         "bg",    "mix",
                                           "diffuseColor", "opacity",  "normal", "st",         "file",  "texcoord",
                                           "base",         "top",      "bsdf",   "edf",        "color", "roughness",
                                           "weight",       "which",    "value1", "base_color", "coat",  "transmission",
                                           "varname",      "geomprop", "mat",    "tangent"};
  const std::vector<std::string> outputs = {"out", "rgb", "r", "a", "result", "outx", "surface", ""};
  std::mt19937 random(7);
  const auto pick = [&](const std::vector<std::string>& from) { return from[random() % from.size()]; };
  for (int round = 0; round < 100; ++round) {
    MaterialNetwork network;
    network.path = "/fuzz" + std::to_string(round);
    const int count = 2 + int(random() % 12);
    for (int i = 0; i < count; ++i) {
      Node node{"/n" + std::to_string(i),
                i == 0 ? (round % 2 ? "UsdPreviewSurface" : "ND_standard_surface_surfaceshader") : pick(kinds),
                {}};
      for (int k = int(random() % 4); k-- > 0;) {
        const Value values[] = {0.5f,
                                int32_t(random() % 4),
                                true,
                                Color{0.1f, 0.9f, 0.5f},
                                std::array<float, 2>{1, 2},
                                std::array<float, 4>{1, 2, 3, 4},
                                std::string("text"),
                                AssetValue{"a.png", "a.png", ""},
                                {}};
        node.parameters[pick(inputs)] = values[random() % std::size(values)];
      }
      network.nodes.push_back(std::move(node));
    }
    for (int k = int(random() % (3 * unsigned(count))); k-- > 0;) {
      network.connections.push_back({"/n" + std::to_string(random() % unsigned(count)), pick(outputs),
                                     "/n" + std::to_string(random() % unsigned(count)), pick(inputs)});
    }
    network.surfaceNode = "/n0";
    network.surfaceOutput = "out";
    ExpectCompiles(RunNetwork(network).material, network.path);
    if (HasFailure()) return;
  }
}

TEST(MaterialGen, MissingLibrariesAreSaid) {
  std::vector<Message> messages;
  EXPECT_EQ(Generator::Create("/no/such/folder", [&](const Message& m) { messages.push_back(m); }), nullptr);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].code, "materialx-libraries-missing");
}

}  // namespace
}  // namespace materialgen
