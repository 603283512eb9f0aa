// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_material.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>
#include <set>

#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

constexpr const char* kColorSpacePrefix = "colorSpace:";

class Walk {
 public:
  Walk(const HdMaterialNetwork2& source, ConvertedMaterial& result) : source_(source), result_(result) {}

  materialgen::MaterialNetwork From(const SdfPath& material, const HdMaterialConnection2& surface) {
    network_.path = material.GetString();
    network_.surfaceNode = surface.upstreamNode.GetString();
    network_.surfaceOutput = surface.upstreamOutputName.GetString();
    // A stack of our own: a chain of thousands of nodes must not end the thread's.
    std::vector<SdfPath> pending{surface.upstreamNode};
    while (!pending.empty()) {
      const SdfPath path = pending.back();
      pending.pop_back();
      const auto found = source_.nodes.find(path);
      if (found == source_.nodes.end() || !seen_.insert(path).second) continue;
      AddNode(path, found->second, pending);
    }
    return std::move(network_);
  }

 private:
  void AddNode(const SdfPath& path, const HdMaterialNode2& node, std::vector<SdfPath>& pending) {
    materialgen::Node converted;
    converted.path = path.GetString();
    converted.identifier = node.nodeTypeId.GetString();
    for (const auto& [name, value] : node.parameters) AddParameter(path, node, name, value, converted);
    for (const auto& [input, connections] : node.inputConnections)
      for (const HdMaterialConnection2& connection : connections) {
        network_.connections.push_back({connection.upstreamNode.GetString(),
                                        connection.upstreamOutputName.GetString(), converted.path, input.GetString()});
        pending.push_back(connection.upstreamNode);
      }
    network_.nodes.push_back(std::move(converted));
  }

  void AddParameter(const SdfPath& path, const HdMaterialNode2& node, const TfToken& name, const VtValue& value,
                    materialgen::Node& converted) {
    // "colorSpace:file" tells the colour space of "file"; "typeName:file" its type, which the node's definition knows.
    if (TfStringStartsWith(name.GetString(), kColorSpacePrefix) || TfStringStartsWith(name.GetString(), "typeName:"))
      return;
    if (value.IsEmpty()) return;
    materialgen::Value parameter = ToParameter(value);
    if (std::holds_alternative<std::monostate>(parameter)) {
      result_.messages.emplace_back("material-value-type", path.AppendProperty(name).GetString() +
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

  const HdMaterialNetwork2& source_;
  ConvertedMaterial& result_;
  materialgen::MaterialNetwork network_;
  std::set<SdfPath> seen_;
};

// MaterialX's nodes name their definitions.
const char* ContextOf(const materialgen::MaterialNetwork& network) {
  for (const materialgen::Node& node : network.nodes)
    if (TfStringStartsWith(node.identifier, "ND_")) return "mtlx";
  return "";
}

// UsdPreviewSurface's displacement is often connected by habit and never set.
bool DoesSomething(const HdMaterialNetwork2& network, const HdMaterialConnection2& displacement) {
  const auto node = network.nodes.find(displacement.upstreamNode);
  if (node == network.nodes.end()) return false;
  if (node->second.nodeTypeId != TfToken("UsdPreviewSurface")) return true;
  if (node->second.inputConnections.count(TfToken("displacement"))) return true;
  const auto value = node->second.parameters.find(TfToken("displacement"));
  return value != node->second.parameters.end() && ToNumber(value->second).value_or(0) != 0;
}

}  // namespace

ConvertedMaterial ToMaterial(const SdfPath& id, const HdMaterialNetworkMap& networks) {
  ConvertedMaterial result;
  const HdMaterialNetwork2 source = HdConvertToHdMaterialNetwork2(networks);
  const auto terminal = [&](const TfToken& name) {
    const auto found = source.terminals.find(name);
    return found == source.terminals.end() ? nullptr : &found->second;
  };
  if (const HdMaterialConnection2* surface = terminal(HdMaterialTerminalTokens->surface)) {
    materialgen::MaterialNetwork network = Walk(source, result).From(id, *surface);
    const std::string context = ContextOf(network);
    result.update.contexts.emplace_back(context, std::move(network));
  } else {
    result.messages.emplace_back("material-no-surface",
                                 "the material has no surface that can be rendered; the default is used");
  }
  if (const auto* displacement = terminal(HdMaterialTerminalTokens->displacement);
      displacement && DoesSomething(source, *displacement))
    result.messages.emplace_back("material-displacement-unsupported",
                                 "displacement is not rendered yet; it is ignored");
  if (terminal(HdMaterialTerminalTokens->volume))
    result.messages.emplace_back("material-volume-unsupported", "volume is not rendered yet; it is ignored");
  return result;
}

}  // namespace hydra
