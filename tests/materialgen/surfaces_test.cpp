// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Surfaces of MaterialX: which lobes they wake, and what their bodies hold.
#include "tests/materialgen/fixture.h"

#include <cmath>

namespace materialgen {
namespace {

TEST(MaterialGen, StandardSurfaceWakesWhatIsSwitchedOn) {
  const Result plain = RunNetwork(Standard());
  EXPECT_EQ(Lobes(plain), (LobeNames{"dielectric_reflection", "oren_nayar"}));
  EXPECT_EQ(plain.material.kernel,
            RunNetwork(Standard({{"base", 0.3f}, {"specular_roughness", 0.7f}})).material.kernel);
  EXPECT_EQ(Lobes(RunNetwork(Standard({{"metalness", 1.0f}}))), (LobeNames{"conductor"}));
  EXPECT_EQ(Lobes(RunNetwork(Standard({{"transmission", 1.0f}}))),
            (LobeNames{"dielectric"}));
  EXPECT_EQ(Lobes(RunNetwork(Standard({{"sheen", 0.5f}}))),
            (LobeNames{"dielectric_reflection", "sheen_conty_kulla", "oren_nayar"}));
  const Result coated = RunNetwork(Standard({{"coat", 0.5f}}));
  EXPECT_EQ(Lobes(coated), (LobeNames{"dielectric_reflection", "dielectric_reflection", "oren_nayar"}));
  EXPECT_EQ(coated.material.kernel,
            RunNetwork(Standard({{"coat", 0.9f}, {"coat_color", Color{1, 0, 0}}})).material.kernel);
  EXPECT_FALSE(RunNetwork(Standard({{"emission", 1.0f}})).material.kernel->emission.empty());
  EXPECT_TRUE(plain.messages.empty());
}

// The way into a random walk is a lobe; where the host wants none, or there is no distance to walk, it is diffuse.
TEST(MaterialGen, SubsurfaceIsALobe) {
  const MaterialNetwork network = Standard({{"subsurface", 0.5f}, {"subsurface_radius", Color{1, 0.5f, 0.2f}}});
  const Result walk = RunNetwork(network);
  EXPECT_TRUE(walk.messages.empty());
  EXPECT_EQ(Lobes(walk), (LobeNames{"dielectric_reflection", "subsurface", "oren_nayar"}));
  EXPECT_TRUE(walk.material.scatters);
  EXPECT_TRUE(walk.material.lightEnters);
  ExpectCompiles(walk.material, "subsurface");
  const CompiledMaterial diffuse = SharedGenerator().Generate(network, {}, {.diffuseSubsurface = true});
  EXPECT_EQ(diffuse.kernel->lobes, (LobeNames{"dielectric_reflection", "oren_nayar", "oren_nayar"}));
  EXPECT_FALSE(diffuse.scatters);
  EXPECT_FALSE(diffuse.lightEnters);
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
  EXPECT_TRUE(body(0, {0.5f, 0.5f, 0.5f}, 0).lightEnters);
}

// What the CPU computes for bodies follows the rule of lib/media.glsl: a logarithm of 0 absorbs all, 0 / 0 nothing.
TEST(MaterialGen, BodiesOfInfinitiesHoldTheMostThereIs) {
  const auto body = [](Color over, Color under) {
    MaterialNetwork network;
    network.path = "/Looks/m";
    network.nodes = {{"/Looks/m/surface", "ND_surface", {}},
                     {"/Looks/m/filled", "ND_layer_vdf", {}},
                     {"/Looks/m/bsdf", "ND_dielectric_bsdf", {{"scatter_mode", std::string("RT")}}},
                     {"/Looks/m/inside", "ND_absorption_vdf", {}},
                     {"/Looks/m/ratio", "ND_divide_vector3", {{"in1", over}, {"in2", under}}}};
    network.connections = {{"/Looks/m/filled", "out", "/Looks/m/surface", "bsdf"},
                           {"/Looks/m/bsdf", "out", "/Looks/m/filled", "top"},
                           {"/Looks/m/inside", "out", "/Looks/m/filled", "base"},
                           {"/Looks/m/ratio", "out", "/Looks/m/inside", "absorption"}};
    network.surfaceNode = "/Looks/m/surface";
    network.surfaceOutput = "out";
    return RunNetwork(network).material.parameters;
  };
  const std::vector<float> block = body({1, 0, -1}, {0, 0, 0});
  ASSERT_GE(block.size(), 8u);
  EXPECT_EQ(block[0], 1e9f);
  EXPECT_EQ(block[1], 0);
  EXPECT_EQ(block[2], 0);
}

// Lama says that an absorptionColor of 1 is a clear body; its colours are no coefficients.
TEST(MaterialGen, LamaBodiesAreWhatTheirDefinitionSays) {
  for (const char* node : {"ND_lama_dielectric", "ND_lama_generalized_schlick"}) {
    const auto body = [&](std::map<std::string, Value> parameters) {
      MaterialNetwork network;
      network.path = "/Looks/m";
      network.nodes = {{"/Looks/m/surface", "ND_surface", {}}, {"/Looks/m/lama", node, std::move(parameters)}};
      network.connections = {{"/Looks/m/lama", "out", "/Looks/m/surface", "bsdf"}};
      network.surfaceNode = "/Looks/m/surface";
      network.surfaceOutput = "out";
      const Result result = RunNetwork(network);
      EXPECT_TRUE(result.messages.empty());
      ExpectCompiles(result.material, node);
      return result.material;
    };
    const auto holds = [](const CompiledMaterial& material, std::array<float, 7> expected) {
      ASSERT_GE(material.parameters.size(), 8u);
      for (size_t i = 0; i < 7; ++i) EXPECT_NEAR(material.parameters[i], expected[i], 1e-6f) << i;
    };
    holds(body({}), {0, 0, 0, 0, 0, 0, 0});
    EXPECT_FALSE(body({}).scatters);
    // Absorption, anisotropy, scattering: extinctions ln(2) / 4, ln(4) / 4 and 0, of which 1, 1/4 and 1/2 are scattered.
    const CompiledMaterial milk = body({{"absorptionColor", Color{0.5f, 0.25f, 1}}, {"absorptionRadius", 4.0f},
                                        {"scatterColor", Color{1, 0.25f, 0.5f}}, {"scatterAnisotropy", 0.5f}});
    const float two = std::log(2.0f) / 4;
    holds(milk, {0, 1.5f * two, 0, 0.5f, two, 0.5f * two, 0});
    EXPECT_TRUE(milk.scatters);
  }
}

// A thin wall has no inside: light goes through it unbent, and enters no body.
TEST(MaterialGen, ThinWalledSurfacesDoNotRefract) {
  const auto isBody = [](const Result& result) {
    return result.material.kernel->surface.find("kHasTransmission = true") != std::string::npos;
  };
  const Result body = RunNetwork(Standard({{"transmission", 1.0f}}));
  const Result wall = RunNetwork(Standard({{"transmission", 1.0f}, {"thin_walled", true}}));
  EXPECT_EQ(Lobes(body), (LobeNames{"dielectric"}));
  EXPECT_EQ(Lobes(wall), (LobeNames{"dielectric_reflection", "thin_transmission"}));
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

namespace mixed {

using Values = std::map<std::string, Value>;

// `mix` of `front`, the rest `back`: standard_surfaces that are all glass unless they say otherwise.
MaterialNetwork Glasses(Values front, Values back, float mix) {
  MaterialNetwork network;
  network.path = "/Looks/m";
  front.emplace("transmission", 1.0f);
  back.emplace("transmission", 1.0f);
  network.nodes = {{"/Looks/m/mix", "ND_mix_surfaceshader", {{"mix", mix}}},
                   {"/Looks/m/front", "ND_standard_surface_surfaceshader", std::move(front)},
                   {"/Looks/m/back", "ND_standard_surface_surfaceshader", std::move(back)}};
  network.connections = {{"/Looks/m/front", "out", "/Looks/m/mix", "fg"}, {"/Looks/m/back", "out", "/Looks/m/mix", "bg"}};
  network.surfaceNode = "/Looks/m/mix";
  network.surfaceOutput = "out";
  return network;
}

void ExpectAbsorption(const Result& result, std::array<float, 3> expected) {
  ExpectCompiles(result.material, "mixed glass");
  ASSERT_GE(result.material.parameters.size(), 8u);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(result.material.parameters[i], expected[i], 1e-5f) << i;
}

const Values kGreen = {{"transmission_depth", 1.0f}, {"transmission_color", Color{0.1f, 0.9f, 0.1f}}};
const Values kRed = {{"transmission_depth", 2.0f}, {"transmission_color", Color{0.9f, 0.1f, 0.2f}}};

}  // namespace mixed

// The inside of a mix of bodies is their media, by what each lets in; what lets nothing in dilutes nothing.
TEST(MaterialGen, MixedBodiesHoldTheMixOfTheirMedia) {
  using namespace mixed;
  const std::array<float, 3> green = {std::log(10.0f), -std::log(0.9f), std::log(10.0f)};
  const std::array<float, 3> red = {-std::log(0.9f) / 2, std::log(10.0f) / 2, std::log(5.0f) / 2};
  const auto blend = [&](float g, float r) {
    return std::array{g * green[0] + r * red[0], g * green[1] + r * red[1], g * green[2] + r * red[2]};
  };
  const Result most = RunNetwork(Glasses(kGreen, kRed, 0.1f)), least = RunNetwork(Glasses(kGreen, kRed, 0.7f));
  ExpectAbsorption(most, blend(0.1f, 0.9f));
  ExpectAbsorption(least, blend(0.7f, 0.3f));
  EXPECT_EQ(most.material.kernel, least.material.kernel) << "an edited factor compiles nothing";
  EXPECT_TRUE(most.messages.empty());
  ExpectAbsorption(RunNetwork(Glasses(kGreen, kRed, 1)), green);
  ExpectAbsorption(RunNetwork(Glasses({}, kRed, 0.5f)), blend(0, 0.5f));
  ExpectAbsorption(RunNetwork(Glasses({{"transmission", 0.0f}}, kRed, 0.5f)), red);

  MaterialNetwork masked = Glasses(kGreen, kRed, 0.5f);
  masked.nodes.push_back({"/Looks/m/mask", "UsdPrimvarReader_float", {{"varname", std::string("mask")}}});
  masked.connections.push_back({"/Looks/m/mask", "result", "/Looks/m/mix", "mix"});
  const Result varying = RunNetwork(masked);
  ExpectCompiles(varying.material, "masked glass");
  EXPECT_NE(varying.material.kernel->surface.find("c.interior = Medium("), std::string::npos);
}

// One body has one index, and either an inside or none: those of the greatest part, which is said once.
TEST(MaterialGen, WhatNoMixHasIsThatOfItsGreatestPart) {
  using namespace mixed;
  const auto said = [](const Result& result, const std::string& text) {
    return std::count_if(result.messages.begin(), result.messages.end(), [&](const Message& m) {
      return m.code == "material-unsupported-feature" && m.location == "/Looks/m/mix" &&
             m.text.find(text) != std::string::npos;
    });
  };
  for (const float mix : {0.1f, 0.9f}) {
    const Result result = RunNetwork(Glasses({{"specular_IOR", 1.3f}}, {{"specular_IOR", 1.7f}}, mix));
    ASSERT_GE(result.material.parameters.size(), 8u);
    EXPECT_EQ(result.material.parameters[7], mix < 0.5f ? 1.7f : 1.3f);
    EXPECT_EQ(said(result, "index of refraction"), 1);
    EXPECT_EQ(result.messages.size(), 1u);
  }
  const Result solid = RunNetwork(Glasses({{"thin_walled", true}}, kGreen, 0.1f));
  const Result thin = RunNetwork(Glasses({{"thin_walled", true}}, kGreen, 0.9f));
  const auto isBody = [](const Result& result) {
    return result.material.kernel->surface.find("kHasTransmission = true") != std::string::npos;
  };
  EXPECT_TRUE(isBody(solid));
  EXPECT_FALSE(isBody(thin));
  ExpectAbsorption(solid, {0.9f * std::log(10.0f), -0.9f * std::log(0.9f), 0.9f * std::log(10.0f)});
  ExpectCompiles(thin.material, "thin mix");
  EXPECT_EQ(said(solid, ": solid"), 1);
  EXPECT_EQ(said(thin, ": thin-walled"), 1);
  EXPECT_EQ(solid.messages.size() + thin.messages.size(), 2u);

  // What transmits nothing has no say.
  const Result pane = RunNetwork(Glasses({{"thin_walled", true}}, {{"transmission", 0.0f}}, 0.1f));
  EXPECT_FALSE(isBody(pane));
  EXPECT_EQ(std::count(pane.material.kernel->lobes.begin(), pane.material.kernel->lobes.end(), "thin_transmission"), 1);
  EXPECT_TRUE(pane.messages.empty());
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
  const auto dispersion = [](const char* node, const char* weight, const char* input, float amount) {
    MaterialNetwork network = Preview({{weight, 1.0f}, {input, amount}});
    network.nodes[0].identifier = node;
    return RunNetwork(network).Has("material-unsupported-feature");
  };
  for (float amount : {0.0f, 0.5f}) {
    EXPECT_EQ(dispersion("ND_open_pbr_surface_surfaceshader", "transmission_weight", "transmission_dispersion_scale", amount),
              amount > 0);
    EXPECT_EQ(dispersion("ND_gltf_pbr_surfaceshader", "transmission", "dispersion", amount), amount > 0);
  }
}

}  // namespace
}  // namespace materialgen
