// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/materialgen/mtlx_network.h"

#include <MaterialXCore/Document.h>
#include <MaterialXFormat/Util.h>
#include <MaterialXFormat/XmlIo.h>

#include <algorithm>
#include <set>

namespace mx = MaterialX;
using materialgen::MaterialNetwork;
using materialgen::Node;
using materialgen::Value;

namespace materialgen_test {
namespace {

template <size_t N, typename V>
Value Numbers(const V& from) {
  std::array<float, N> result;
  for (size_t i = 0; i < N; ++i) result[i] = from[i];
  return result;
}

Value ValueOf(const mx::InputPtr& input) {
  const std::string type = input->getType();
  if (type == "filename") {
    const std::string path = input->getResolvedValueString();
    return materialgen::AssetValue{path, path, input->getActiveColorSpace()};
  }
  const mx::ValuePtr value = input->getValue();
  if (!value || input->getValueString().empty()) return {};
  if (value->isA<bool>()) return value->asA<bool>();
  if (value->isA<int>()) return int32_t(value->asA<int>());
  if (value->isA<float>()) return value->asA<float>();
  if (value->isA<mx::Vector2>()) return Numbers<2>(value->asA<mx::Vector2>());
  if (value->isA<mx::Vector3>()) return Numbers<3>(value->asA<mx::Vector3>());
  if (value->isA<mx::Vector4>()) return Numbers<4>(value->asA<mx::Vector4>());
  if (value->isA<mx::Color3>()) return Numbers<3>(value->asA<mx::Color3>());
  if (value->isA<mx::Color4>()) return Numbers<4>(value->asA<mx::Color4>());
  return input->getValueString();
}

// Nodes and node graphs of the file, graphs flattened into the one list.
class Reader {
 public:
  explicit Reader(MaterialNetwork* network) : network_(*network) {}

  std::string Add(const mx::NodePtr& node) {
    const std::string path = "/" + node->getNamePath();
    if (!added_.insert(path).second) return path;
    const mx::NodeDefPtr definition = node->getNodeDef();
    const size_t index = network_.nodes.size();
    network_.nodes.push_back({path, definition ? definition->getName() : node->getCategory(), {}});
    for (const mx::InputPtr& input : node->getInputs()) Read(index, path, input, input->getName());
    return path;
  }

 private:
  void Read(size_t index, const std::string& path, const mx::InputPtr& source, const std::string& name) {
    const mx::InputPtr interface = source->getInterfaceInput();
    const mx::InputPtr input = interface ? interface : source;
    mx::OutputPtr output = input->getConnectedOutput();
    mx::NodePtr upstream = input->getConnectedNode();
    std::string outputName = input->getOutputString();
    if (output && output->getConnectedNode() && !input->hasNodeName()) {
      upstream = output->getConnectedNode();
      outputName = output->getOutputString();
    }
    if (upstream) {
      network_.connections.push_back({Add(upstream), outputName.empty() ? "out" : outputName, path, name});
    } else {
      network_.nodes[index].parameters[name] = ValueOf(input);
    }
  }

  MaterialNetwork& network_;
  std::set<std::string> added_;
};

// Graphs take the place of the nodes that the document defines by them.
void FlattenOwnNodes(const mx::DocumentPtr& document) {
  std::set<std::string> own;
  for (const mx::ElementPtr& child : document->getChildren())
    if (child->isA<mx::NodeDef>()) own.insert(child->getName());
  const auto isOwn = [&](const mx::NodePtr& node) {
    const mx::NodeDefPtr definition = node->getNodeDef();
    return definition && own.count(definition->getName()) > 0;
  };
  document->flattenSubgraphs("", isOwn);
  for (const mx::ElementPtr& child : document->getChildren()) {
    const mx::NodeGraphPtr graph = child->asA<mx::NodeGraph>();
    if (graph && !graph->getNodeDef()) graph->flattenSubgraphs("", isOwn);
  }
}

// Those of the materials, by their names; in a document without materials, those that its graphs give out.
std::vector<std::pair<std::string, mx::NodePtr>> Surfaces(const mx::DocumentPtr& document) {
  std::vector<std::pair<std::string, mx::NodePtr>> found;
  const auto add = [&](const std::string& name, const mx::NodePtr& material) {
    const mx::InputPtr input = material ? material->getInput("surfaceshader") : nullptr;
    const mx::NodePtr surface = input ? input->getConnectedNode() : nullptr;
    if (surface) found.emplace_back(name, surface);
  };
  for (const mx::NodePtr& material : document->getMaterialNodes()) add(material->getName(), material);
  if (!document->getMaterialNodes().empty()) return found;
  for (const mx::ElementPtr& child : document->getChildren()) {
    const mx::NodeGraphPtr graph = child->asA<mx::NodeGraph>();
    if (!graph || graph->getNodeDef()) continue;
    for (const mx::OutputPtr& output : graph->getOutputs()) {
      const mx::NodePtr node = output->getConnectedNode();
      const std::string name = graph->getName() + "_" + output->getName();
      if (output->getType() == "surfaceshader" && node) found.emplace_back(name, node);
      if (output->getType() == "material") add(name, node);
    }
  }
  return found;
}

}  // namespace

mx::DocumentPtr Library(const std::string& libraryPath) {
  static const mx::DocumentPtr library = [&] {
    mx::DocumentPtr document = mx::createDocument();
    mx::loadLibraries({"targets", "stdlib", "pbrlib", "bxdf", "cmlib", "nprlib"}, mx::FileSearchPath(libraryPath),
                      document);
    return document;
  }();
  return library;
}

std::vector<MaterialNetwork> NetworksOfAllNodes(const std::string& libraryPath, size_t batch) {
  static const std::set<std::string> numbers = {"float", "color3", "color4", "vector2", "vector3", "vector4"};
  std::vector<MaterialNetwork> networks;
  std::string sum;
  size_t count = 0;
  for (const mx::NodeDefPtr& definition : Library(libraryPath)->getNodeDefs()) {
    for (const mx::OutputPtr& output : definition->getActiveOutputs()) {
      const std::string type = output->getType();
      if (!numbers.count(type) && type != "integer" && type != "boolean" && type != "EDF") continue;
      if (count++ % batch == 0) {
        MaterialNetwork network;
        network.path = "/from_" + definition->getName();
        network.nodes = {{"/surface", "UsdPreviewSurface", {}}};
        network.surfaceNode = "/surface";
        network.surfaceOutput = "surface";
        for (const std::string& name : numbers) {
          network.nodes.push_back({"/" + name, "ND_geompropvalue_" + name, {{"geomprop", name}}});
        }
        networks.push_back(std::move(network));
        sum.clear();
      }
      MaterialNetwork& network = networks.back();
      const std::string path = "/" + definition->getName() + "_" + output->getName();
      network.nodes.push_back({path, definition->getName(), {}});
      for (const mx::InputPtr& input : definition->getActiveInputs()) {
        if (input->getType() == "filename") {
          network.nodes.back().parameters[input->getName()] = materialgen::AssetValue{"a.png", "/a.png", ""};
        } else if (numbers.count(input->getType())) {
          network.connections.push_back({"/" + input->getType(), "out", path, input->getName()});
        }
      }
      const std::string add = path + "_add";
      network.nodes.push_back({add, "ND_add_color3", {}});
      network.connections.push_back({path, output->getName(), add, "in1"});
      if (!sum.empty()) network.connections.push_back({sum, "out", add, "in2"});
      sum = add;
      // The sum so far is the surface's colour.
      network.connections.erase(
          std::remove_if(network.connections.begin(), network.connections.end(),
                         [](const materialgen::Connection& c) { return c.downstreamNode == "/surface"; }),
          network.connections.end());
      network.connections.push_back({sum, "out", "/surface", "diffuseColor"});
    }
  }
  return networks;
}

std::vector<MaterialNetwork> NetworksOf(const std::string& mtlxFile, const std::string& libraryPath) {
  std::vector<MaterialNetwork> networks;
  try {
    mx::DocumentPtr document = mx::createDocument();
    mx::readFromXmlFile(document, mtlxFile);
    document->setDataLibrary(Library(libraryPath));
    FlattenOwnNodes(document);
    for (const auto& [name, surface] : Surfaces(document)) {
      MaterialNetwork network;
      network.path = "/" + name;
      network.surfaceNode = Reader(&network).Add(surface);
      network.surfaceOutput = "out";
      networks.push_back(std::move(network));
    }
  } catch (const std::exception&) {
    return {};
  }
  return networks;
}

}  // namespace materialgen_test
