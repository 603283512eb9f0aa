// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Materials as materialgen makes them, for tests in Python: a network in, sources and the parameter block out.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "materialgen/materialgen.h"

namespace nb = nanobind;

namespace {

using namespace materialgen;

template <size_t N>
std::array<float, N> Floats(const std::vector<float>& from) {
  std::array<float, N> to;
  std::copy(from.begin(), from.end(), to.begin());
  return to;
}

// bool, int, float and str as they are; ("asset", path, colour space); other tuples hold 2, 3, 4, 9 or 16 floats.
Value ValueOf(nb::handle from) {
  if (nb::isinstance<nb::bool_>(from)) return nb::cast<bool>(from);
  if (nb::isinstance<nb::int_>(from)) return nb::cast<int32_t>(from);
  if (nb::isinstance<nb::float_>(from)) return nb::cast<float>(from);
  if (nb::isinstance<nb::str>(from)) return nb::cast<std::string>(from);
  if (nb::len(from) == 3 && nb::isinstance<nb::str>(from[0])) {
    const auto path = nb::cast<std::string>(from[1]);
    return AssetValue{path, path, nb::cast<std::string>(from[2])};
  }
  const auto numbers = nb::cast<std::vector<float>>(from);
  switch (numbers.size()) {
    case 2: return Floats<2>(numbers);
    case 3: return Floats<3>(numbers);
    case 4: return Floats<4>(numbers);
    case 9: return Floats<9>(numbers);
    case 16: return Floats<16>(numbers);
    default: throw std::runtime_error("a value of " + std::to_string(numbers.size()) + " numbers");
  }
}

// nodes: (path, identifier, {input: value}); connections: (node, output, node, input).
nb::dict Generate(Generator& generator, const std::vector<std::tuple<std::string, std::string, nb::dict>>& nodes,
                  const std::vector<std::tuple<std::string, std::string, std::string, std::string>>& connections,
                  const std::string& surface) {
  MaterialNetwork network;
  network.path = "/Material";
  network.surfaceNode = surface;
  network.surfaceOutput = "out";
  for (const auto& [path, identifier, values] : nodes) {
    Node node{path, identifier, {}};
    for (auto [name, value] : values) node.parameters[nb::cast<std::string>(name)] = ValueOf(value);
    network.nodes.push_back(std::move(node));
  }
  for (const auto& [from, output, to, input] : connections) network.connections.push_back({from, output, to, input});
  nb::list messages;
  const CompiledMaterial material = generator.Generate(
      network, [&](const Message& m) { messages.append(nb::make_tuple(m.code, m.location, m.text)); });
  nb::list textures;
  for (const TextureRequest& request : material.textures) {
    textures.append(nb::make_tuple(request.file.authoredPath, request.sourceColorSpace, request.file.colorSpace,
                                   request.isColor, request.offset));
  }
  nb::dict out;
  out["key"] = material.kernel->key;
  out["surface"] = material.kernel->surface;
  out["opacity"] = material.kernel->opacity;
  out["emission"] = material.kernel->emission;
  out["primvars"] = material.kernel->primvars;
  out["parameters"] = material.parameters;
  out["textures"] = textures;
  out["messages"] = messages;
  return out;
}

}  // namespace

void bindMaterial(nb::module_& module) {
  nb::class_<Generator>(module, "Generator").def("generate", &Generate, nb::arg("nodes"), nb::arg("connections"), nb::arg("surface"));
  module.def("materialx_libraries", [] { return std::string(HDWAVEFRONT_MATERIALX_LIBRARIES); });
  module.def("create_generator", [] {
    std::string error;
    auto generator = Generator::Create(HDWAVEFRONT_MATERIALX_LIBRARIES, [&](const Message& m) { error = m.text; });
    if (!generator) throw std::runtime_error(error);
    return generator;
  });
}
