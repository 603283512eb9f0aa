// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Networks -> kernels: what shares a kernel, and what UsdPreviewSurface becomes.
#include "tests/materialgen/fixture.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <thread>

namespace materialgen {
namespace {

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
// Layers of a file and sequences of files, which are not read: said where they change the picture, and only there.
TEST(MaterialGen, LayersAndFramesOfImagesAreSaid) {
  struct Case {
    const char *identifier, *file, *input;
    Value value;
    const char* said;  // empty: nothing
  };
  const Case cases[] = {
      {"ND_image_color3", "a.exr", "layer", std::string("specular"), "'layer'"},
      {"ND_image_color3", "a.exr", "layer", std::string(), ""},
      {"ND_image_float", "a.exr", "framerange", std::string("1-4"), "sequences"},
      {"ND_image_color3", "a.{0frame}.exr", "frameoffset", int32_t{2}, "sequences"},
      {"ND_image_vector3", "a.exr", "frameoffset", int32_t{2}, ""},
      {"ND_image_color3", "a.exr", "frameendaction", std::string("mirror"), ""},
      {"ND_tiledimage_color3", "a.exr", "framerange", std::string("1-4"), "sequences"},
      {"ND_triplanarprojection_color3", "a.exr", "layerx", std::string("specular"), "'layer'"},
  };
  for (const Case& c : cases) {
    const AssetValue file{c.file, std::string("/resolved/") + c.file, ""};
    const bool isTriplanar = std::string_view(c.identifier).find("triplanar") != std::string_view::npos;
    MaterialNetwork network = Standard();
    network.nodes.push_back({"/i", c.identifier, {{isTriplanar ? "filex" : "file", file}, {c.input, c.value}}});
    network.connections.push_back({"/i", "out", network.surfaceNode, "base_color"});
    const Result result = RunNetwork(network);
    const std::string where = std::string(c.identifier) + " " + c.input;
    if (!*c.said) {
      EXPECT_TRUE(result.messages.empty()) << where;
      continue;
    }
    ASSERT_EQ(result.messages.size(), 1u) << where;
    EXPECT_EQ(result.messages[0].code, "material-unsupported-feature");
    EXPECT_EQ(result.messages[0].location, "/i");
    EXPECT_NE(result.messages[0].text.find(c.said), std::string::npos) << result.messages[0].text;
  }
}

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

TEST(MaterialGen, OpacityModes) {
  const auto opacity = [](std::map<std::string, Value> p) {
    return !RunNetwork(Preview(std::move(p))).material.kernel->opacity.empty();
  };
  EXPECT_FALSE(opacity({{"opacity", 1.0f}}));
  EXPECT_FALSE(opacity({{"opacity", 0.99f}})) << "light refracts, and does not pass";
  EXPECT_TRUE(opacity({{"opacity", 0.99f}, {"ior", 1.0f}}));
  EXPECT_TRUE(opacity({{"opacity", 0.5f}, {"opacityMode", std::string("presence")}}));
  EXPECT_FALSE(opacity({{"opacity", 0.5f}, {"opacityThreshold", 0.25f}})) << "above the threshold: opaque";
  EXPECT_TRUE(opacity({{"opacity", 0.2f}, {"opacityThreshold", 0.25f}})) << "below the threshold: absent";
}

// A constant opacity makes a body that refracts, as MaterialX's graph says; one that varies over the surface, an open sheet
// that light passes straight; a threshold or `presence`, a hole.
TEST(MaterialGen, TransparencyOfPreviewSurfacesRefractsWhereOpacityDoesNotVary) {
  const auto refracts = [](const MaterialNetwork& network) {
    const std::vector<std::string> lobes = Lobes(RunNetwork(network));
    return std::count(lobes.begin(), lobes.end(), "dielectric_transmission") > 0;
  };
  const auto connected = [](const std::string& kind, std::map<std::string, Value> parameters, const char* output) {
    MaterialNetwork network = Preview();
    network.nodes.push_back({"/Looks/m/opacity", kind, std::move(parameters)});
    network.connections.push_back({"/Looks/m/opacity", output, "/Looks/m/surface", "opacity"});
    return network;
  };
  EXPECT_TRUE(refracts(Preview({{"opacity", 0.0f}})));
  EXPECT_TRUE(refracts(Preview({{"opacity", 0.3f}, {"opacityMode", std::string("transparent")}})));
  EXPECT_TRUE(refracts(connected("ND_constant_float", {{"value", 0.3f}}, "out"))) << "the same all over";
  EXPECT_FALSE(refracts(connected("UsdPrimvarReader_float", {{"varname", std::string("o")}}, "result")));
  EXPECT_FALSE(refracts(Preview({{"opacity", 1.0f}})));
  EXPECT_FALSE(refracts(Preview({{"opacity", 0.3f}, {"opacityThreshold", 0.1f}})));
  EXPECT_FALSE(refracts(Preview({{"opacity", 0.3f}, {"opacityMode", std::string("presence")}})));
  EXPECT_FALSE(refracts(Preview({{"opacity", 0.3f}, {"ior", 1.0f}}))) << "that is straight on";
}

TEST(MaterialGen, EmissionEntryOnlyWhereItEmits) {
  EXPECT_TRUE(RunNetwork(Preview({{"emissiveColor", Color{0, 0, 0}}})).material.kernel->emission.empty());
  EXPECT_FALSE(RunNetwork(Preview({{"emissiveColor", Color{0, 0.1f, 0}}})).material.kernel->emission.empty());
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

}  // namespace
}  // namespace materialgen
