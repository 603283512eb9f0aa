// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_material.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <map>
#include <set>

#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

constexpr const char* kColorSpacePrefix = "colorSpace:";

// HdMaterialNetwork2 is not used: its layout, and that of what HdConvertToHdMaterialNetwork2 returns, changed within
// the versions that one build may meet.
class Walk {
 public:
  Walk(const HdMaterialNetwork& source, ConvertedMaterial& result) : result_(result) {
    for (const HdMaterialNode& node : source.nodes) nodes_[node.path] = &node;
    for (const HdMaterialRelationship& r : source.relationships) inputs_[r.outputId].push_back(&r);
    for (auto& [path, inputs] : inputs_)
      std::stable_sort(inputs.begin(), inputs.end(),
                       [](const auto* a, const auto* b) { return a->outputName < b->outputName; });
  }

  // `name`: of the terminal, of which Hydra does not say which output of the node it is.
  materialgen::MaterialNetwork From(const SdfPath& material, const HdMaterialNode& terminal, const TfToken& name) {
    network_.path = material.GetString();
    const bool isSurface = name == HdMaterialTerminalTokens->surface;
    (isSurface ? network_.surfaceNode : network_.displacementNode) = terminal.path.GetString();
    (isSurface ? network_.surfaceOutput : network_.displacementOutput) = name.GetString();
    // A stack of our own: a chain of thousands of nodes must not end the thread's.
    std::vector<SdfPath> pending{terminal.path};
    while (!pending.empty()) {
      const SdfPath path = pending.back();
      pending.pop_back();
      const auto found = nodes_.find(path);
      if (found == nodes_.end() || !seen_.insert(path).second) continue;
      AddNode(*found->second, pending);
    }
    return std::move(network_);
  }

 private:
  void AddNode(const HdMaterialNode& node, std::vector<SdfPath>& pending) {
    materialgen::Node converted;
    converted.path = node.path.GetString();
    converted.identifier = node.identifier.GetString();
    for (const auto& [name, value] : node.parameters) AddParameter(node, name, value, converted);
    // Hydra names the ends of a relationship the other way round: its input is the node above, its output the one
    // below.
    for (const HdMaterialRelationship* r : inputs_[node.path]) {
      network_.connections.push_back(
          {r->inputId.GetString(), r->inputName.GetString(), converted.path, r->outputName.GetString()});
      pending.push_back(r->inputId);
    }
    network_.nodes.push_back(std::move(converted));
  }

  void AddParameter(const HdMaterialNode& node, const TfToken& name, const VtValue& value,
                    materialgen::Node& converted) {
    // "colorSpace:file" tells the colour space of "file"; "typeName:file" its type, which the node's definition knows.
    if (TfStringStartsWith(name.GetString(), kColorSpacePrefix) || TfStringStartsWith(name.GetString(), "typeName:"))
      return;
    if (value.IsEmpty()) return;
    materialgen::Value parameter = ToParameter(value);
    if (std::holds_alternative<std::monostate>(parameter)) {
      result_.messages.emplace_back("material-value-type", converted.path + "." + name.GetString() +
                                                               ": values of type " + value.GetTypeName() +
                                                               " are not supported in material networks; the input "
                                                               "keeps its default");
      return;
    }
    if (auto* asset = std::get_if<materialgen::AssetValue>(&parameter)) {
      if (asset->authoredPath.empty()) return;
      const auto space = node.parameters.find(TfToken(kColorSpacePrefix + name.GetString()));
      if (space != node.parameters.end()) asset->colorSpace = ToString(space->second);
    }
    converted.parameters[name.GetString()] = std::move(parameter);
  }

  ConvertedMaterial& result_;
  std::map<SdfPath, const HdMaterialNode*> nodes_;
  std::map<SdfPath, std::vector<const HdMaterialRelationship*>> inputs_;
  materialgen::MaterialNetwork network_;
  std::set<SdfPath> seen_;
};

// MaterialX's nodes name their definitions.
const char* ContextOf(const materialgen::MaterialNetwork& network) {
  for (const materialgen::Node& node : network.nodes)
    if (TfStringStartsWith(node.identifier, "ND_")) return "mtlx";
  return "";
}

bool HasNode(const materialgen::MaterialNetwork& network, const std::string& path) {
  return std::any_of(network.nodes.begin(), network.nodes.end(), [&](const auto& node) { return node.path == path; });
}

}  // namespace

ConvertedMaterial ToMaterial(const SdfPath& id, const HdMaterialNetworkMap& networks) {
  ConvertedMaterial result;
  // The last node of a network is its terminal.
  const auto terminal = [&](const TfToken& name) -> const HdMaterialNetwork* {
    const auto found = networks.map.find(name);
    return found == networks.map.end() || found->second.nodes.empty() ? nullptr : &found->second;
  };
  for (const TfToken& name : {HdMaterialTerminalTokens->surface, HdMaterialTerminalTokens->displacement}) {
    const HdMaterialNetwork* source = terminal(name);
    if (!source) continue;
    materialgen::MaterialNetwork network = Walk(*source, result).From(id, source->nodes.back(), name);
    // A UsdPreviewSurface is both terminals: one network.
    auto& contexts = result.update.contexts;
    if (!contexts.empty() && HasNode(contexts[0].second, network.displacementNode)) {
      contexts[0].second.displacementNode = network.displacementNode;
      contexts[0].second.displacementOutput = network.displacementOutput;
      continue;
    }
    const std::string context = ContextOf(network);
    contexts.emplace_back(context, std::move(network));
  }
  if (terminal(HdMaterialTerminalTokens->volume))
    result.messages.emplace_back("material-volume-unsupported", "volume is not rendered yet; it is ignored");
  return result;
}

}  // namespace hydra
