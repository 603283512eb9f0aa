// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Networks -> kernels: what shares a kernel, what compiles, and what bad input does.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <random>
#include <set>
#include <thread>

#include "materialgen/materialgen.h"
#include "tests/materialgen/mtlx_network.h"

namespace materialgen {
namespace {

using Color = std::array<float, 3>;

Generator& SharedGenerator() {
  static const std::unique_ptr<Generator> generator = Generator::Create(
      HDWAVEFRONT_MATERIALX_LIBRARIES, [](const Message& m) { std::cerr << m.code << ": " << m.text << "\n"; });
  return *generator;
}

struct Result {
  CompiledMaterial material;
  std::vector<Message> messages;
  bool Has(const std::string& code) const {
    return std::any_of(messages.begin(), messages.end(), [&](const Message& m) { return m.code == code; });
  }
};

Result RunNetwork(const MaterialNetwork& network) {
  Result result;
  result.material = SharedGenerator().Generate(network, [&](const Message& m) { result.messages.push_back(m); });
  return result;
}

std::string NumberedLines(const std::string& source) {
  std::string out;
  size_t line = 1, at = 0;
  while (at < source.size()) {
    const size_t end = source.find('\n', at);
    out += std::to_string(line++) + ": " + source.substr(at, end - at) + "\n";
    if (end == std::string::npos) break;
    at = end + 1;
  }
  return out;
}

// Every entry of the kernel compiles; returns the words of SPIR-V of the surface.
size_t ExpectCompiles(const CompiledMaterial& material, const std::string& name) {
  size_t words = 0;
  const KernelSource& kernel = *material.kernel;
  const std::pair<const char*, const std::string*> entries[] = {
      {"surface", &kernel.surface}, {"opacity", &kernel.opacity}, {"emission", &kernel.emission}};
  for (const auto& [entry, source] : entries) {
    if (source->empty()) continue;
    std::string error;
    const std::vector<uint32_t> spirv = CompileGlsl(*source, name + "." + entry, &error);
    EXPECT_FALSE(spirv.empty()) << error << "\n" << NumberedLines(*source);
    if (source == &kernel.surface) words = spirv.size();
  }
  EXPECT_EQ(material.parameters.size() % 4, 0u);
  for (const ParameterSlot& slot : material.slots) EXPECT_LE(slot.offset + slot.components, material.parameters.size());
  return words;
}

MaterialNetwork Preview(std::map<std::string, Value> parameters = {}) {
  MaterialNetwork network;
  network.path = "/Looks/m";
  network.nodes = {{"/Looks/m/surface", "UsdPreviewSurface", std::move(parameters)}};
  network.surfaceNode = "/Looks/m/surface";
  network.surfaceOutput = "surface";
  return network;
}

// A texture and its primvar reader, connected to `input` of the surface.
void AddTexture(MaterialNetwork* network, const std::string& input, const std::string& output, const std::string& file,
                std::map<std::string, Value> parameters = {}) {
  const std::string texture = "/Looks/m/texture_" + input, reader = "/Looks/m/reader";
  parameters["file"] = AssetValue{file, "/resolved/" + file, ""};
  network->nodes.push_back({texture, "UsdUVTexture", std::move(parameters)});
  if (std::none_of(network->nodes.begin(), network->nodes.end(), [&](const Node& n) { return n.path == reader; })) {
    network->nodes.push_back({reader, "UsdPrimvarReader_float2", {{"varname", std::string("st")}}});
  }
  network->connections.push_back({texture, output, network->surfaceNode, input});
  network->connections.push_back({reader, "result", texture, "st"});
}

std::vector<std::string> Lobes(const Result& result) {
  return result.material.kernel->lobes;
}

TEST(MaterialGen, DefaultMaterialReadsDisplayPrimvars) {
  const CompiledMaterial material = SharedGenerator().GenerateDefault();
  ExpectCompiles(material, "default");
  EXPECT_EQ(std::set<std::string>(material.kernel->primvars.begin(), material.kernel->primvars.end()),
            (std::set<std::string>{"displayColor", "displayOpacity"}));
  EXPECT_FALSE(material.kernel->opacity.empty());
  EXPECT_TRUE(material.kernel->emission.empty());
  const CompiledMaterial opaque = SharedGenerator().GenerateDefault(true);
  ExpectCompiles(opaque, "opaque default");
  EXPECT_EQ(opaque.kernel->primvars, std::vector<std::string>{"displayColor"});
  EXPECT_TRUE(opaque.kernel->opacity.empty());
}

TEST(MaterialGen, PlainPreviewSurfaceIsDiffuseAndOneSpecular) {
  const Result result = RunNetwork(Preview());
  EXPECT_EQ(Lobes(result), (std::vector<std::string>{"oren_nayar", "generalized_schlick"}));
  EXPECT_TRUE(result.material.kernel->opacity.empty());
  EXPECT_TRUE(result.material.kernel->emission.empty());
  EXPECT_TRUE(result.material.kernel->primvars.empty());
  EXPECT_TRUE(result.messages.empty());
  ExpectCompiles(result.material, "plain");
}

// The host loads a set where the resolved path is a pattern: the kernel must read it as one, and nothing else.
TEST(MaterialGen, TilesAreReadWhereTheFileIsAPattern) {
  const std::map<std::string, bool> files = {{"t.<UDIM>.png", true}, {"t_<UVTILE>.png", true}, {"t.1001.png", false}};
  for (const auto& [file, isPattern] : files) {
    MaterialNetwork network = Preview();
    AddTexture(&network, "diffuseColor", "rgb", file);
    const Result result = RunNetwork(network);
    EXPECT_EQ(result.material.kernel->surface.find("patternTiles(") != std::string::npos, isPattern) << file;
    EXPECT_EQ(result.material.kernel->surface.find("patternImage(") != std::string::npos, !isPattern) << file;
    ExpectCompiles(result.material, file);
  }
}

// Every input with a value of its own, and with a texture: compiles, and asks for what it should.
TEST(MaterialGen, EveryPreviewSurfaceInputCompiles) {
  const std::map<std::string, Value> values = {{"diffuseColor", Color{0.5f, 0.2f, 0.1f}},
                                               {"emissiveColor", Color{1, 2, 3}},
                                               {"useSpecularWorkflow", int32_t(1)},
                                               {"specularColor", Color{0.1f, 0.2f, 0.3f}},
                                               {"metallic", 0.5f},
                                               {"roughness", 0.1f},
                                               {"clearcoat", 0.3f},
                                               {"clearcoatRoughness", 0.2f},
                                               {"opacity", 0.5f},
                                               {"opacityMode", std::string("presence")},
                                               {"opacityThreshold", 0.4f},
                                               {"ior", 1.3f},
                                               {"normal", Color{0, 0, 1}},
                                               {"displacement", 0.1f},
                                               {"occlusion", 0.5f}};
  for (const auto& [name, value] : values) {
    const Result result = RunNetwork(Preview({{name, value}}));
    ExpectCompiles(result.material, name);
    EXPECT_FALSE(result.Has("material-unsupported-feature")) << name;
    EXPECT_EQ(result.Has("material-displacement-not-connected"), name == "displacement") << name;
    if (name == "useSpecularWorkflow" || name == "opacityMode") continue;
    MaterialNetwork network = Preview();
    const bool isColor = std::holds_alternative<Color>(value);
    AddTexture(&network, name, isColor ? "rgb" : "r", name + ".png");
    const Result textured = RunNetwork(network);
    ExpectCompiles(textured.material, name + " texture");
    const bool isUsed =
        name != "displacement" && name != "occlusion" && name != "specularColor" && name != "clearcoatRoughness";
    EXPECT_EQ(textured.material.textures.size(), isUsed ? 1u : 0u) << name;
  }
  const Result all = RunNetwork(Preview(values));
  ExpectCompiles(all.material, "all");
}

TEST(MaterialGen, MetallicPrunesDiffuse) {
  EXPECT_EQ(Lobes(RunNetwork(Preview({{"metallic", 1.0f}}))), (std::vector<std::string>{"conductor"}));
  EXPECT_EQ(Lobes(RunNetwork(Preview({{"metallic", 0.5f}}))),
            (std::vector<std::string>{"oren_nayar", "conductor", "generalized_schlick"}));
  EXPECT_EQ(Lobes(RunNetwork(Preview({{"clearcoat", 0.5f}}))),
            (std::vector<std::string>{"generalized_schlick", "oren_nayar", "generalized_schlick"}));
}

TEST(MaterialGen, ValueEditsKeepTheKernel) {
  const Result a = RunNetwork(Preview());
  const Result b =
      RunNetwork(Preview({{"diffuseColor", Color{0.9f, 0.1f, 0.3f}}, {"roughness", 0.23f}, {"ior", 1.8f}}));
  EXPECT_EQ(a.material.kernel, b.material.kernel);
  EXPECT_NE(a.material.parameters, b.material.parameters);
  // Accidental equality of two values is no structure either.
  EXPECT_EQ(a.material.kernel,
            RunNetwork(Preview({{"diffuseColor", Color{0.5f, 0.5f, 0.5f}}, {"roughness", 0.5f}})).material.kernel);
  const Result c = RunNetwork(Preview({{"clearcoat", 0.2f}}));
  EXPECT_NE(a.material.kernel->key, c.material.kernel->key) << "a pruned lobe woke up";
  EXPECT_EQ(c.material.kernel,
            RunNetwork(Preview({{"clearcoat", 0.9f}, {"clearcoatRoughness", 0.4f}})).material.kernel);
}

TEST(MaterialGen, NamesAndTexturesAreNotTopology) {
  MaterialNetwork a = Preview(), b = Preview();
  AddTexture(&a, "diffuseColor", "rgb", "a.png");
  AddTexture(&a, "roughness", "g", "r.png");
  AddTexture(&b, "roughness", "g", "other.png");
  AddTexture(&b, "diffuseColor", "rgb", "b.png", {{"scale", std::array<float, 4>{2, 2, 2, 2}}});
  b.path = "/Elsewhere/n";
  const auto rename = [](std::string* path) { *path = "/Elsewhere/zz" + std::string(path->rbegin(), path->rend()); };
  for (Node& node : b.nodes) rename(&node.path);
  for (Connection& c : b.connections) rename(&c.upstreamNode), rename(&c.downstreamNode);
  rename(&b.surfaceNode);
  std::reverse(b.nodes.begin(), b.nodes.end());
  std::reverse(b.connections.begin(), b.connections.end());
  const Result ra = RunNetwork(a), rb = RunNetwork(b);
  EXPECT_EQ(ra.material.kernel, rb.material.kernel) << ra.material.kernel->surface << rb.material.kernel->surface;
  ASSERT_EQ(ra.material.textures.size(), 2u);
  ASSERT_EQ(rb.material.textures.size(), 2u);
  EXPECT_EQ(ra.material.textures[0].offset, rb.material.textures[0].offset);
  EXPECT_EQ(ra.material.textures[0].sourceColorSpace, "auto");
  ExpectCompiles(ra.material, "textured");
}

TEST(MaterialGen, TwoGeneratorsAgreeToTheByte) {
  const auto other = Generator::Create(HDWAVEFRONT_MATERIALX_LIBRARIES, {});
  ASSERT_NE(other, nullptr);
  MaterialNetwork network = Preview({{"clearcoat", 0.5f}, {"opacity", 0.5f}, {"metallic", 0.3f}});
  AddTexture(&network, "normal", "rgb", "n.png", {{"scale", std::array<float, 4>{2, 2, 2, 1}}});
  const CompiledMaterial a = RunNetwork(network).material, b = other->Generate(network, {});
  EXPECT_EQ(a.kernel->key, b.kernel->key);
  EXPECT_EQ(a.kernel->surface, b.kernel->surface);
  ASSERT_EQ(a.parameters.size(), b.parameters.size());  // as bits: ids of missing textures are NaNs
  EXPECT_EQ(std::memcmp(a.parameters.data(), b.parameters.data(), a.parameters.size() * sizeof(float)), 0);
}

MaterialNetwork Standard(std::map<std::string, Value> parameters = {}) {
  MaterialNetwork network = Preview(std::move(parameters));
  network.nodes[0].identifier = "ND_standard_surface_surfaceshader";
  return network;
}

TEST(MaterialGen, StandardSurfaceWakesWhatIsSwitchedOn) {
  using Names = std::vector<std::string>;
  const Result plain = RunNetwork(Standard());
  EXPECT_EQ(Lobes(plain), (Names{"dielectric_reflection", "oren_nayar"}));
  EXPECT_EQ(plain.material.kernel,
            RunNetwork(Standard({{"base", 0.3f}, {"specular_roughness", 0.7f}})).material.kernel);
  EXPECT_EQ(Lobes(RunNetwork(Standard({{"metalness", 1.0f}}))), (Names{"conductor"}));
  EXPECT_EQ(Lobes(RunNetwork(Standard({{"transmission", 1.0f}}))),
            (Names{"dielectric"}));
  EXPECT_EQ(Lobes(RunNetwork(Standard({{"sheen", 0.5f}}))),
            (Names{"dielectric_reflection", "sheen_conty_kulla", "oren_nayar"}));
  const Result coated = RunNetwork(Standard({{"coat", 0.5f}}));
  EXPECT_EQ(Lobes(coated), (Names{"dielectric_reflection", "dielectric_reflection", "oren_nayar"}));
  EXPECT_EQ(coated.material.kernel,
            RunNetwork(Standard({{"coat", 0.9f}, {"coat_color", Color{1, 0, 0}}})).material.kernel);
  EXPECT_FALSE(RunNetwork(Standard({{"emission", 1.0f}})).material.kernel->emission.empty());
  EXPECT_TRUE(plain.messages.empty());
}

// The way into a random walk is a lobe; where the host wants none, or there is no distance to walk, it is diffuse.
TEST(MaterialGen, SubsurfaceIsALobe) {
  using Names = std::vector<std::string>;
  const MaterialNetwork network = Standard({{"subsurface", 0.5f}, {"subsurface_radius", Color{1, 0.5f, 0.2f}}});
  const Result walk = RunNetwork(network);
  EXPECT_TRUE(walk.messages.empty());
  EXPECT_EQ(Lobes(walk), (Names{"dielectric_reflection", "subsurface", "oren_nayar"}));
  EXPECT_TRUE(walk.material.scatters);
  ExpectCompiles(walk.material, "subsurface");
  const CompiledMaterial diffuse = SharedGenerator().Generate(network, {}, {.diffuseSubsurface = true});
  EXPECT_EQ(diffuse.kernel->lobes, (Names{"dielectric_reflection", "oren_nayar", "oren_nayar"}));
  EXPECT_FALSE(diffuse.scatters);
  EXPECT_FALSE(RunNetwork(Standard({{"subsurface", 0.5f}, {"subsurface_scale", 0.0f}})).material.scatters);
  EXPECT_FALSE(RunNetwork(Standard({{"subsurface", 0.0f}})).material.scatters);
}

// Bodies start their block with the medium inside and its index; editing one compiles nothing.
TEST(MaterialGen, BodiesHoldTheirMedium) {
  const auto body = [](float depth, Color scatter, int priority) {
    return RunNetwork(Standard({{"transmission", 1.0f}, {"transmission_color", Color{0.5f, 0.25f, 1}}, {"specular_IOR", 1.3f},
                                {"transmission_depth", depth}, {"transmission_scatter", scatter},
                                {"transmission_scatter_anisotropy", 0.25f}, {"dielectric_priority", priority}})).material;
  };
  const CompiledMaterial wax = body(2, {0.1f, 0.2f, 0}, 7), jelly = body(4, {0.3f, 0.2f, 0.1f}, 0);
  EXPECT_EQ(wax.kernel, jelly.kernel);
  EXPECT_EQ(wax.mediumPriority, 7);
  EXPECT_TRUE(wax.scatters);
  ASSERT_GE(wax.parameters.size(), 8u);
  const float expected[] = {(std::log(2.0f) - 0.1f) / 2, (std::log(4.0f) - 0.2f) / 2, 0, 0.25f, 0.05f, 0.1f, 0, 1.3f};
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(wax.parameters[i], expected[i], 1e-6f) << i;
  // More scattering than there is extinction: grey absorption is added.
  EXPECT_NEAR(jelly.parameters[2], 0, 1e-6f);
  EXPECT_NEAR(jelly.parameters[0], (std::log(2.0f) - 0.3f + 0.1f) / 4, 1e-6f);
  EXPECT_FALSE(body(0, {0.5f, 0.5f, 0.5f}, 0).scatters);
}

// A thin wall has no inside: light goes through it unbent, and enters no body.
TEST(MaterialGen, ThinWalledSurfacesDoNotRefract) {
  using Names = std::vector<std::string>;
  const auto isBody = [](const Result& result) {
    return result.material.kernel->surface.find("kHasTransmission = true") != std::string::npos;
  };
  const Result body = RunNetwork(Standard({{"transmission", 1.0f}}));
  const Result wall = RunNetwork(Standard({{"transmission", 1.0f}, {"thin_walled", true}}));
  EXPECT_EQ(Lobes(body), (Names{"dielectric"}));
  EXPECT_EQ(Lobes(wall), (Names{"dielectric_reflection", "thin_transmission"}));
  EXPECT_TRUE(isBody(body));
  EXPECT_FALSE(isBody(wall));
  ExpectCompiles(wall.material, "thin wall");

  MaterialNetwork pane;
  pane.path = "/Looks/m";
  pane.nodes = {{"/Looks/m/surface",
                 "ND_open_pbr_surface_surfaceshader",
                 {{"transmission_weight", 1.0f}, {"geometry_thin_walled", true}}}};
  pane.surfaceNode = "/Looks/m/surface";
  pane.surfaceOutput = "out";
  const Result open = RunNetwork(pane);
  EXPECT_EQ(std::count(open.material.kernel->lobes.begin(), open.material.kernel->lobes.end(), "thin_transmission"), 1);
  EXPECT_FALSE(isBody(open));
  ExpectCompiles(open.material, "OpenPBR thin wall");
}

// Hair: the nodes that feed the lobe are numbers by the time the kernel is made.
TEST(MaterialGen, HairIsALobeAndItsInputsAreFolded) {
  MaterialNetwork network;
  network.path = "/Looks/m";
  network.nodes = {{"/Looks/m/surface", "ND_surface", {}},
                   {"/Looks/m/hair", "ND_chiang_hair_bsdf", {}},
                   {"/Looks/m/roughness", "ND_chiang_hair_roughness", {{"longitudinal", 0.2f}, {"azimuthal", 0.5f}}},
                   {"/Looks/m/melanin", "ND_deon_hair_absorption_from_melanin", {{"melanin_concentration", 0.5f}}}};
  network.connections = {{"/Looks/m/hair", "out", "/Looks/m/surface", "bsdf"},
                         {"/Looks/m/melanin", "absorption", "/Looks/m/hair", "absorption_coefficient"}};
  for (const char* term : {"roughness_R", "roughness_TT", "roughness_TRT"}) {
    network.connections.push_back({"/Looks/m/roughness", term, "/Looks/m/hair", term});
  }
  network.surfaceNode = "/Looks/m/surface";
  network.surfaceOutput = "out";
  const Result result = RunNetwork(network);
  EXPECT_TRUE(result.messages.empty());
  EXPECT_EQ(Lobes(result), std::vector<std::string>{"chiang_hair"});
  ExpectCompiles(result.material, "hair");
  const auto holds = [&](float value) {
    const std::vector<float>& block = result.material.parameters;
    return std::any_of(block.begin(), block.end(), [&](float x) { return std::fabs(x - value) < 1e-5f; });
  };
  // Of the formulas, by hand: (0.726 b + 0.812 b^2)^2 at b = 0.2, a quarter and four times that; -ln(0.5) / 2 times
  // 0.419 + 0.187 of the red channels.
  for (float value : {0.0315702f, 0.0315702f / 4, 0.0315702f * 4}) EXPECT_TRUE(holds(value)) << value;
  EXPECT_TRUE(holds(0.6931472f * 0.5f * (0.419f + 0.187f)));
}

// A film is a value of the lobe; a kernel without film holds a constant in its place.
TEST(MaterialGen, ThinFilmIsPartOfTheLobe) {
  const Result film = RunNetwork(Standard({{"thin_film_thickness", 300.0f}})), plain = RunNetwork(Standard({}));
  EXPECT_EQ(Lobes(film), Lobes(plain));
  EXPECT_NE(film.material.kernel->key, plain.material.kernel->key);
  EXPECT_EQ(film.material.kernel->key, RunNetwork(Standard({{"thin_film_thickness", 500.0f}})).material.kernel->key);
  EXPECT_NE(plain.material.kernel->surface.find("false, vec2(0.0, 1.0))"), std::string::npos);
  ExpectCompiles(RunNetwork(Standard({{"thin_film_thickness", 300.0f}, {"transmission", 1.0f}})).material, "glass film");
}

// MaterialX's graph of standard_surface leaves these out; a user who sets them has to know.
TEST(MaterialGen, TransmissionInputsThatNothingReadsAreSaid) {
  const auto count = [](std::map<std::string, Value> parameters) {
    const Result result = RunNetwork(Standard(std::move(parameters)));
    return std::count_if(result.messages.begin(), result.messages.end(),
                         [](const Message& m) { return m.code == "material-unsupported-feature"; });
  };
  EXPECT_EQ(count({{"transmission", 1.0f}}), 0);
  EXPECT_EQ(count({{"transmission", 1.0f}, {"transmission_scatter", Color{0.5f, 0.2f, 0}}}), 1);
  EXPECT_EQ(count({{"transmission", 1.0f}, {"transmission_depth", 2.0f}, {"transmission_dispersion", 20.0f}}), 1);
  EXPECT_EQ(count({{"transmission", 1.0f}, {"transmission_scatter", Color{0, 0, 0}}, {"transmission_depth", 0.0f}}), 0);
  EXPECT_EQ(count({{"transmission", 0.0f}, {"transmission_scatter", Color{1, 1, 1}}}), 0);
}

TEST(MaterialGen, OpacityModes) {
  const auto opacity = [](std::map<std::string, Value> p) {
    return !RunNetwork(Preview(std::move(p))).material.kernel->opacity.empty();
  };
  EXPECT_FALSE(opacity({{"opacity", 1.0f}}));
  EXPECT_TRUE(opacity({{"opacity", 0.99f}}));
  EXPECT_TRUE(opacity({{"opacity", 0.5f}, {"opacityMode", std::string("presence")}}));
  EXPECT_FALSE(opacity({{"opacity", 0.5f}, {"opacityThreshold", 0.25f}})) << "above the threshold: opaque";
  EXPECT_TRUE(opacity({{"opacity", 0.2f}, {"opacityThreshold", 0.25f}})) << "below the threshold: absent";
}

TEST(MaterialGen, EmissionEntryOnlyWhereItEmits) {
  EXPECT_TRUE(RunNetwork(Preview({{"emissiveColor", Color{0, 0, 0}}})).material.kernel->emission.empty());
  EXPECT_FALSE(RunNetwork(Preview({{"emissiveColor", Color{0, 0.1f, 0}}})).material.kernel->emission.empty());
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
      const auto start = std::chrono::steady_clock::now();
      const Result result = RunNetwork(network);
      EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20.0) << kind;
      if (!isTextured) ExpectCompiles(result.material, kind);
    }
  }
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

TEST(MaterialGen, ThreadsShareOneGenerator) {
  std::vector<std::thread> threads;
  std::vector<std::string> keys(4);
  for (size_t i = 0; i < keys.size(); ++i) {
    threads.emplace_back([&keys, i] {
      for (int k = 0; k < 10; ++k) {
        const CompiledMaterial material = RunNetwork(Preview({{"clearcoat", 0.1f * float(k + 1)}})).material;
        std::string error;
        if (k == 0 && CompileGlsl(material.kernel->surface, "threads", &error).empty())
          keys[i] = error;
        else
          keys[i] = material.kernel->key;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& key : keys) EXPECT_EQ(key, keys[0]);
}

TEST(MaterialGen, MissingLibrariesAreSaid) {
  std::vector<Message> messages;
  EXPECT_EQ(Generator::Create("/no/such/folder", [&](const Message& m) { messages.push_back(m); }), nullptr);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].code, "materialx-libraries-missing");
}

std::filesystem::path Assets() {
  if (const char* assets = std::getenv("HDWAVEFRONT_ASSETS")) return assets;
  return std::filesystem::path(HDWAVEFRONT_SOURCE_DIR) / "../shared/assets";
}

// All example materials of MaterialX that use the surfaces of this issue.
TEST(MaterialGen, MaterialXExamplesCompile) {
  const std::filesystem::path root = Assets() / "materialx/resources/Materials/Examples";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "no assets at " << root << "; set HDWAVEFRONT_ASSETS";
  for (const char* folder : {"StandardSurface", "UsdPreviewSurface"}) {
    for (const auto& file : std::filesystem::directory_iterator(root / folder)) {
      if (file.path().extension() != ".mtlx") continue;
      const auto networks = materialgen_test::NetworksOf(file.path().string(), HDWAVEFRONT_MATERIALX_LIBRARIES);
      EXPECT_FALSE(networks.empty()) << file.path();
      for (const MaterialNetwork& network : networks) {
        const auto start = std::chrono::steady_clock::now();
        const Result result = RunNetwork(network);
        const auto generated = std::chrono::steady_clock::now();
        const size_t words = ExpectCompiles(result.material, file.path().filename().string());
        const auto compiled = std::chrono::steady_clock::now();
        for (const Message& m : result.messages) {
          EXPECT_NE(m.severity, Severity::Error) << file.path() << " " << m.code << " " << m.location << ": " << m.text;
        }
        const std::string& source = result.material.kernel->surface;
        const auto ms = [](auto from, auto to) { return std::chrono::duration<double, std::milli>(to - from).count(); };
        std::cout << file.path().filename().string() << ": " << std::count(source.begin(), source.end(), '\n')
                  << " lines, " << words * 4 / 1024 << " KiB SPIR-V, " << result.material.kernel->lobes.size()
                  << " lobes, generate " << ms(start, generated) << " ms, compile " << ms(generated, compiled)
                  << " ms\n";
      }
    }
  }
}

// Every document of MaterialX that there is: all its surfaces compile, and nothing of them is left out.
TEST(MaterialGen, MaterialXTestSuiteCompiles) {
  const std::filesystem::path root = Assets() / "materialx/resources/Materials";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "no assets at " << root << "; set HDWAVEFRONT_ASSETS";
  std::set<std::string> unsupported;
  size_t documents = 0, surfaces = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(root)) {
    if (file.path().extension() != ".mtlx") continue;
    ++documents;
    for (const MaterialNetwork& network :
         materialgen_test::NetworksOf(file.path().string(), HDWAVEFRONT_MATERIALX_LIBRARIES)) {
      ++surfaces;
      const Result result = RunNetwork(network);
      ExpectCompiles(result.material, file.path().filename().string());
      for (const Message& m : result.messages) {
        // What the random walk will take away; nothing else may be left out.
        if (m.text.find("subsurface scattering is rendered as diffuse") != std::string::npos) continue;
        if (m.severity != Severity::Info)
          unsupported.insert(file.path().filename().string() + " " + m.code + ": " + m.text);
      }
    }
  }
  EXPECT_EQ(documents, 77u);
  EXPECT_EQ(surfaces, 120u);  // displacement.mtlx and lama_surface.mtlx have none
  EXPECT_EQ(unsupported, std::set<std::string>());
}

// Every node of the library whose value is a number, its inputs varying. What is not supported is known here.
TEST(MaterialGen, AllLibraryNodesCompile) {
  std::set<std::string> unsupported;
  for (const MaterialNetwork& network : materialgen_test::NetworksOfAllNodes(HDWAVEFRONT_MATERIALX_LIBRARIES, 16)) {
    const Result result = RunNetwork(network);
    ExpectCompiles(result.material, network.path);
    for (const Message& m : result.messages) {
      if (m.severity == Severity::Error) unsupported.insert(m.text);
    }
  }
  EXPECT_EQ(unsupported, std::set<std::string>());
}

// To read generated code: HDWAVEFRONT_DUMP=file.mtlx hdwavefront_tests --gtest_also_run_disabled_tests --gtest_filter=*Dump
TEST(MaterialGen, DISABLED_Dump) {
  const char* file = std::getenv("HDWAVEFRONT_DUMP");
  ASSERT_NE(file, nullptr) << "set HDWAVEFRONT_DUMP to a .mtlx file to see its kernels";
  for (const MaterialNetwork& network : materialgen_test::NetworksOf(file, HDWAVEFRONT_MATERIALX_LIBRARIES)) {
    const Result result = RunNetwork(network);
    for (const Message& m : result.messages)
      std::cout << "// " << m.code << " " << m.location << ": " << m.text << "\n";
    std::cout << "// " << network.path << " " << result.material.kernel->key << "\n"
              << result.material.kernel->surface << result.material.kernel->opacity << result.material.kernel->emission;
  }
}

}  // namespace
}  // namespace materialgen
