// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/materialgen/fixture.h"

#include <iostream>

namespace materialgen {

Generator& SharedGenerator() {
  static const std::unique_ptr<Generator> generator = Generator::Create(
      HDWAVEFRONT_MATERIALX_LIBRARIES, [](const Message& m) { std::cerr << m.code << ": " << m.text << "\n"; });
  return *generator;
}

Result RunNetwork(const MaterialNetwork& network) {
  Result result;
  result.material = SharedGenerator().Generate(network, [&](const Message& m) { result.messages.push_back(m); });
  return result;
}

namespace {

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

}  // namespace

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

MaterialNetwork Preview(std::map<std::string, Value> parameters) {
  MaterialNetwork network;
  network.path = "/Looks/m";
  network.nodes = {{"/Looks/m/surface", "UsdPreviewSurface", std::move(parameters)}};
  network.surfaceNode = "/Looks/m/surface";
  network.surfaceOutput = "surface";
  return network;
}

// A texture and its primvar reader, connected to `input` of the surface.
MaterialNetwork Standard(std::map<std::string, Value> parameters) {
  MaterialNetwork network = Preview(std::move(parameters));
  network.nodes[0].identifier = "ND_standard_surface_surfaceshader";
  return network;
}

}  // namespace materialgen
