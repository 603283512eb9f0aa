// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/builder.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "materialgen/closure_text.h"

namespace materialgen {
namespace {

constexpr int kMaximumGraphDepth = 32;

// Reads "0.18, 0.18, 0.18", "true", "3".
bool ParseNumbers(const std::string& text, Type type, Constant* value) {
  if (type == Type::Bool) {
    (*value)[0] = text == "true" || text == "1" ? 1.0f : 0.0f;
    return true;
  }
  const char* at = text.c_str();
  for (int i = 0; i < Components(type); ++i) {
    char* end = nullptr;
    const float number = std::strtof(at, &end);
    if (end == at) return false;
    (*value)[size_t(i)] = number;
    for (at = end; *at == ',' || *at == ' ';) ++at;
  }
  return true;
}

template <size_t N>
void Copy(const std::array<float, N>& from, Constant* to) {
  std::copy(from.begin(), from.end(), to->begin());
}

// Numbers of an authored value; the type that it has. None for text and files.
Type NumbersOf(const Value& value, Constant* out) {
  if (const auto* v = std::get_if<bool>(&value)) return (*out)[0] = *v ? 1.0f : 0.0f, Type::Bool;
  if (const auto* v = std::get_if<int32_t>(&value)) return (*out)[0] = float(*v), Type::Int;
  if (const auto* v = std::get_if<float>(&value)) return (*out)[0] = *v, Type::Float;
  if (const auto* v = std::get_if<std::array<float, 2>>(&value)) return Copy(*v, out), Type::Vec2;
  if (const auto* v = std::get_if<std::array<float, 3>>(&value)) return Copy(*v, out), Type::Vec3;
  if (const auto* v = std::get_if<std::array<float, 4>>(&value)) return Copy(*v, out), Type::Vec4;
  if (const auto* v = std::get_if<std::array<float, 9>>(&value)) return Copy(*v, out), Type::Mat3;
  if (const auto* v = std::get_if<std::array<float, 16>>(&value)) return Copy(*v, out), Type::Mat4;
  return Type::None;
}

}  // namespace

Builder::Builder(Library* library, const MaterialNetwork& network, Expressions* expressions, const SurfaceFacts& facts,
                 bool diffuseSubsurface)
    : library_(*library), network_(network), e_(*expressions), facts_(facts), diffuseSubsurface_(diffuseSubsurface) {}

void Builder::Say(Severity severity, const std::string& code, const std::string& location, const std::string& text) {
  const std::string where = location.empty() ? network_.path : location;
  if (said_.insert(code + "\n" + where + "\n" + text).second) messages_.push_back({severity, code, where, text});
}

void Builder::Index() {
  entries_.resize(network_.nodes.size());
  for (size_t i = 0; i < entries_.size(); ++i) {
    const materialgen::Node& node = network_.nodes[i];
    entries_[i].node = &node;
    if (!entryOf_.emplace(node.path, uint32_t(i)).second) {
      Say(Severity::Warning, "material-duplicate-node", node.path, "two nodes have this path; the first one is used");
    }
  }
  for (const Connection& connection : network_.connections) {
    const auto downstream = entryOf_.find(connection.downstreamNode);
    const auto upstream = entryOf_.find(connection.upstreamNode);
    if (downstream == entryOf_.end()) continue;
    if (upstream == entryOf_.end()) {
      Say(Severity::Warning, "material-dangling-connection", connection.downstreamNode,
          "input '" + connection.downstreamInput + "' is connected to '" + connection.upstreamNode +
              "', which is not in the network; the input's own value is used");
      continue;
    }
    entries_[downstream->second].connections.emplace(connection.downstreamInput, &connection);
  }
}

// Nodes that the root reaches, upstream first, without recursion. Connections that close a cycle are dropped.
std::vector<uint32_t> Builder::Order(uint32_t root) {
  enum : uint8_t { kNew, kOpen, kDone };
  std::vector<uint8_t> state(entries_.size(), kNew);
  struct Step {
    uint32_t entry;
    std::map<std::string, const Connection*>::iterator next;
  };
  std::vector<uint32_t> order;
  std::vector<Step> stack;
  const auto open = [&](uint32_t entry) {
    state[entry] = kOpen;
    stack.push_back({entry, entries_[entry].connections.begin()});
  };
  open(root);
  while (!stack.empty()) {
    Step& step = stack.back();
    Entry& entry = entries_[step.entry];
    if (step.next == entry.connections.end()) {
      state[step.entry] = kDone;
      order.push_back(step.entry);
      stack.pop_back();
      continue;
    }
    const uint32_t upstream = entryOf_.at(step.next->second->upstreamNode);
    if (state[upstream] == kOpen) {
      Say(Severity::Error, "material-cycle", entry.node->path,
          "the connection of input '" + step.next->first + "' to '" + entries_[upstream].node->path +
              "' closes a cycle; the input's own value is used");
      step.next = entry.connections.erase(step.next);
      continue;
    }
    entries_[upstream].outputs.insert(step.next->second->upstreamOutput);
    ++step.next;
    if (state[upstream] == kNew) open(upstream);
  }
  return order;
}

Material Builder::Build() {
  Index();
  Surface surface;
  const auto root = entryOf_.find(network_.surfaceNode);
  if (root == entryOf_.end()) {
    Say(Severity::Error, "material-no-surface", network_.path,
        "the surface terminal '" + network_.surfaceNode + "' is not in the network; the material shows magenta");
    surface = Fallback();
  } else {
    const std::vector<uint32_t> order = Order(root->second);
    entries_[root->second].outputs.insert(network_.surfaceOutput);
    for (uint32_t entry : order) BuildEntry(&entries_[entry]);
    const Entry& terminal = entries_[root->second];
    const auto value = terminal.values.find(network_.surfaceOutput);
    if (value != terminal.values.end() && value->second.type == Type::Surface && value->second.id != kNone) {
      surface = surfaces_[value->second.id];
    } else {
      if (value == terminal.values.end() || !value->second.isUnknown) {
        Say(Severity::Error, "material-no-surface", terminal.node->path,
            "output '" + network_.surfaceOutput + "' of '" + terminal.node->identifier +
                "' is not a surface shader; the material shows magenta");
      }
      surface = Fallback();
    }
  }
  Material material;
  material.closureTree = ClosureText(e_, bsdfs_, surface.bsdf);
  material.closure = Linearise(&e_, bsdfs_, surface.bsdf);
  SayMixedInsides(material.closure);
  material.facts = {material.closure.transmits, material.closure.isThinWalled};
  if (surface.opacity != kNone && !e_.Decide(surface.opacity, 1)) {
    material.opacity = e_.Arithmetic("clamp", {surface.opacity, e_.Number(0), e_.Number(1)});
  }
  if (surface.emission != kNone && !e_.Decide(surface.emission, 0)) {
    material.emission = e_.Convert(surface.emission, Type::Vec3);
  }
  if (root != entryOf_.end()) {
    const auto priority = entries_[root->second].node->parameters.find("dielectric_priority");
    Constant value{};
    if (priority != entries_[root->second].node->parameters.end() && IsVector(NumbersOf(priority->second, &value))) {
      material.priority = int(std::clamp(value[0], 0.0f, 31.0f));
    }
  }
  return material;
}

// What cannot be blended is that of the greatest part.
void Builder::SayMixedInsides(const LinearClosure& closure) {
  const auto say = [&](const std::string& text) {
    Say(Severity::Warning, "material-unsupported-feature", network_.surfaceNode, text);
  };
  if (closure.mixesWalls) {
    const std::string kind = closure.isThinWalled ? "thin-walled" : "solid";
    say("a mix of thin-walled and solid surfaces is as most of what it transmits: " + kind);
  }
  if (closure.mixesIndices) {
    say("a mix of bodies has one index of refraction for what lies inside it: that of the greatest part");
  }
}

// What shows where there is nothing right to show.
Surface Builder::Fallback() {
  Bsdf lobe;
  lobe.lobe = &FindLobe("oren_nayar");
  const Id frame = e_.Make("frame", Type::Frame, {e_.Make("normal_world", Type::Vec3, {})});
  lobe.expression = e_.Make("lobe", Type::Lobe, {frame, e_.Color(1, 0, 1), e_.Number(0)}, "oren_nayar");
  lobe.weight = e_.Number(1);
  lobe.tint = e_.Number(1);
  bsdfs_.push_back(lobe);
  Surface surface;
  surface.bsdf = BsdfId(bsdfs_.size() - 1);
  return surface;
}

// MaterialX's graph of standard_surface does not read these inputs at all, so nobody else could say it.
// (transmission_depth and what comes with it is rendered: see EvaluateTransmissionDepth.)
void Builder::SayIgnoredTransmission(const Entry& entry) {
  const auto isSet = [&](const char* input) {
    if (entry.connections.count(input)) return true;
    const auto found = entry.node->parameters.find(input);
    if (found == entry.node->parameters.end()) return false;
    if (const float* number = std::get_if<float>(&found->second)) return *number != 0;
    const auto* color = std::get_if<std::array<float, 3>>(&found->second);
    return color && *color != std::array<float, 3>{};
  };
  const std::string_view category = entry.definition->category;
  if (!isSet(category == "open_pbr_surface" ? "transmission_weight" : "transmission")) return;
  const auto say = [&](const char* input, const char* text) {
    if (isSet(input)) Say(Severity::Warning, "material-unsupported-feature", entry.node->path, text);
  };
  if (category == "standard_surface" && !isSet("transmission_depth")) {
    say("transmission_scatter", "transmission_scatter is ignored: without a transmission_depth the body is clear");
  }
  for (const char* input : {"transmission_dispersion", "transmission_dispersion_scale", "dispersion"}) {
    say(input, "dispersion is ignored: all colours refract alike");
  }
}

void Builder::BuildEntry(Entry* entry) {
  current_ = entry->node;
  entry->definition = library_.Find(entry->node->identifier);
  if (!entry->definition) {
    Say(Severity::Error, "material-unknown-node", entry->node->path,
        "node '" + entry->node->identifier + "' is not known; what reads it shows magenta");
    Port unknown;
    unknown.isUnknown = true;
    for (const std::string& output : entry->outputs) entry->values[output] = unknown;
    return;
  }
  const bool isPreview = entry->definition->category == "UsdPreviewSurface";
  if (isPreview) SayUnconnectedDisplacement(*entry);
  const std::string_view category = entry->definition->category;
  if (category == "standard_surface" || category == "open_pbr_surface" || category == "gltf_pbr")
    SayIgnoredTransmission(*entry);
  Node node;
  node.definition = entry->definition;
  for (const PortDefinition& input : entry->definition->inputs) node.inputs.push_back(NetworkInput(entry, input));
  for (const std::string& output : entry->outputs) {
    // USD names some outputs of its own ("result", "surface"); a node with one output has no other to mean.
    std::string name = output;
    if (isPreview && output == "displacement") {  // USD's; MaterialX's definition has the input only
      for (size_t i = 0; i < node.inputs.size(); ++i)
        if (entry->definition->inputs[i].name == output) entry->values[output] = {Type::Displacement, node.inputs[i].id};
      continue;
    }
    if (!entry->definition->FindOutput(name)) {
      if (entry->definition->outputs.size() != 1) {
        Say(Severity::Warning, "material-unknown-output", entry->node->path,
            "'" + entry->node->identifier + "' has no output '" + output + "'; what reads it shows magenta");
        entry->values[output].isUnknown = true;
        continue;
      }
      name = entry->definition->outputs[0].name;
    }
    entry->values[output] = Evaluate(node, name, 0);
  }
}

Port Builder::NetworkInput(Entry* entry, const PortDefinition& definition) {
  const bool isPreview = entry->definition->category == "UsdPreviewSurface";
  if (isPreview && definition.name == "normal" && !entry->connections.count("normal")) {
    // A constant normal would bend every surface the same way; nobody means that, and it would cost the tangents.
    return Literal(Type::Vec3, "0, 0, 1");
  }
  const auto connection = entry->connections.find(definition.name);
  if (connection != entry->connections.end()) {
    const Entry& upstream = entries_[entryOf_.at(connection->second->upstreamNode)];
    const auto value = upstream.values.find(connection->second->upstreamOutput);
    if (value != upstream.values.end()) {
      SayUnusedComponents("what is connected to input '", value->second.type, definition, *entry->node);
      return Fit(value->second, definition, entry->node);
    }
  }
  const auto authored = entry->node->parameters.find(definition.name);
  if (authored != entry->node->parameters.end() && !std::holds_alternative<std::monostate>(authored->second)) {
    return AuthoredInput(*entry->node, definition, authored->second);
  }
  return DefaultInput(entry->node, definition);
}

// A number for a colour fills it, as everybody expects; a colour for a number loses something.
void Builder::SayUnusedComponents(const std::string& what, Type have, const PortDefinition& definition,
                                  const materialgen::Node& node) {
  const Type want = definition.type;
  if (!IsVector(have) || !IsVector(want) || Components(have) <= Components(want)) return;
  const std::string given = std::to_string(Components(have)), used = std::to_string(Components(want));
  Say(Severity::Warning, "material-type-mismatch", node.path,
      what + definition.name + "' has " + given + " components; of them " + used +
          (used == "1" ? " is used" : " are used"));
}

Port Builder::AuthoredInput(const materialgen::Node& node, const PortDefinition& definition, const Value& value) {
  const Type want = definition.type;
  Constant numbers{};
  const Type have = NumbersOf(value, &numbers);
  if (have != Type::None && Components(want) > 0) {
    for (float& number : numbers) {
      if (!std::isfinite(number)) {
        Say(Severity::Warning, "material-bad-value", node.path,
            "input '" + definition.name + "' is not finite; 0 is used");
        number = 0;
      }
    }
    // Integers and booleans choose among structures: they belong to the topology.
    const bool isTopology = want == Type::Int || want == Type::Bool || !IsVector(want);
    if (have == want)
      return {want, isTopology ? e_.Literal(want, numbers) : e_.Parameter(want, numbers, node.path, definition.name)};
    SayUnusedComponents("the value of input '", have, definition, node);
    if (isTopology || !IsVector(have)) return Fit({have, e_.Literal(have, numbers)}, definition, &node);
    if (Components(have) == 1) {
      const Id scalar = e_.Parameter(Type::Float, numbers, node.path, definition.name);
      return Fit({Type::Float, scalar}, definition, &node);
    }
    return Fit({have, e_.Parameter(have, numbers, node.path, definition.name)}, definition, &node);
  }
  if (const auto* asset = std::get_if<AssetValue>(&value)) {
    if (want == Type::Asset) return {want, e_.Asset(*asset)};
    if (want == Type::String) return {want, e_.Text(asset->authoredPath)};
  }
  if (const auto* text = std::get_if<std::string>(&value)) {
    if (want == Type::String) return {want, e_.Text(*text)};
    if (want == Type::Asset) return {want, e_.Asset({*text, {}, {}})};
    // UsdPreviewSurface's opacityMode is a token in USD and an integer in MaterialX.
    if (want == Type::Int && *text == "transparent") return {want, e_.Literal(want, {0})};
    if (want == Type::Int && *text == "presence") return {want, e_.Literal(want, {1})};
  }
  Say(Severity::Warning, "material-type-mismatch", node.path,
      "the value of input '" + definition.name + "' has the wrong type; the default is used");
  return DefaultInput(&node, definition);
}

Port Builder::DefaultInput(const materialgen::Node* node, const PortDefinition& definition) {
  if (!definition.geomprop.empty()) return GeometricProperty(definition.geomprop);
  Constant numbers{};
  const Type type = definition.type;
  // A default is as good as a value: authoring another one later must not change the topology.
  if (node && IsVector(type) && type != Type::Int && type != Type::Bool &&
      ParseNumbers(definition.value, type, &numbers)) {
    return {type, e_.Parameter(type, numbers, node->path, definition.name)};
  }
  return Literal(type, definition.value);
}

Port Builder::Literal(Type type, const std::string& text) {
  if (type == Type::String) return {type, e_.Text(text)};
  if (type == Type::Asset) return {type, e_.Asset({text, {}, {}})};
  if (type == Type::Bsdf || type == Type::Vdf || type == Type::Surface || type == Type::Displacement ||
      type == Type::None) {
    return {type, kNone};
  }
  Constant numbers{};
  ParseNumbers(text, type, &numbers);
  return {type, e_.Literal(type, numbers)};
}

Port Builder::GeometricProperty(const std::string& name) {
  const auto expression = [&](std::string_view op, Type type, std::vector<Id> arguments = {}) {
    return Port{type, e_.Make(op, type, std::move(arguments))};
  };
  const Id none = e_.Literal(Type::Vec2, {});
  const auto tangent = [&](std::string_view part) { return TextureCoordinates(part, "st", none); };
  if (name == "Pworld") return expression("position_world", Type::Vec3);
  if (name == "Pobject") return expression("position_object", Type::Vec3);
  if (name == "Nworld") return expression("normal_world", Type::Vec3);
  if (name == "Nobject") return expression("to_object_normal", Type::Vec3, {e_.Make("normal_world", Type::Vec3, {})});
  if (name == "Tworld") return {Type::Vec3, tangent("tangent")};
  if (name == "Bworld") return {Type::Vec3, tangent("bitangent")};
  const auto toObject = [&](Id v) { return e_.Make("to_object_vector", Type::Vec3, {v}); };
  if (name == "Tobject") return expression("normalize", Type::Vec3, {toObject(tangent("tangent"))});
  if (name == "Bobject") return expression("normalize", Type::Vec3, {toObject(tangent("bitangent"))});
  if (name == "Vworld") return expression("view", Type::Vec3);
  return {Type::Vec2, TextureCoordinates("uv_value", "st", none)};  // UV0
}

Id Builder::TextureCoordinates(std::string_view part, const std::string& primvar, Id fallback) {
  const Id uv = e_.Make("uv", Type::Uv, {fallback}, primvar);
  if (part == "uv_value") return e_.Make(part, Type::Vec2, {uv});
  if (part == "footprint") return e_.Make(part, Type::Float, {uv});
  return e_.Make(part, Type::Vec3, {e_.Make("uv_frame", Type::Frame, {uv})});
}

Port Builder::Fit(Port port, const PortDefinition& definition, const materialgen::Node* node) {
  const Type want = definition.type;
  if (port.isUnknown) {
    if (definition.isColor && want == Type::Vec3) return {want, e_.Color(1, 0, 1)};
    if (definition.isColor && want == Type::Vec4) return {want, e_.Literal(want, {1, 0, 1, 1})};
    return DefaultInput(nullptr, definition);
  }
  if (port.type == want) {
    return port;
  }
  if (port.id != kNone && IsVector(port.type) && IsVector(want)) return {want, e_.Convert(port.id, want)};
  if (port.type == Type::String && want == Type::Asset && port.id != kNone)
    return {want, e_.Asset({e_[port.id].text, {}, {}})};
  if (want == Type::None) return port;
  const std::string location = node ? node->path : current_ ? current_->path : network_.path;
  Say(Severity::Warning, "material-type-mismatch", location,
      "what is connected to input '" + definition.name + "' has the wrong type; the default is used");
  return DefaultInput(node, definition);
}

Port Builder::Evaluate(const Node& node, const std::string& output, int depth) {
  Port result;
  if (NodeEvaluator(this, node, output).Evaluate(&result)) return result;
  switch (node.definition->implementation) {
    case NodeDefinition::Implementation::Graph:
      if (depth < kMaximumGraphDepth) return EvaluateGraph(node, output, depth + 1);
      break;
    case NodeDefinition::Implementation::Inline:
      return EvaluateInline(node);
    case NodeDefinition::Implementation::Function:
      result = EvaluateFunction(node, output);
      if (!result.isUnknown) return result;
      break;
    case NodeDefinition::Implementation::None:
      break;
  }
  Say(Severity::Error, "material-unsupported-node", current_ ? current_->path : network_.path,
      "node '" + node.definition->name + "' is not supported; what reads it shows magenta");
  result.isUnknown = true;
  return result;
}

Port Builder::EvaluateGraph(const Node& node, const std::string& output, int depth) {
  Port unknown;
  unknown.isUnknown = true;
  const Graph* graph = library_.GraphOf(*node.definition);
  const GraphOutput* wanted = nullptr;
  if (graph) {
    for (const GraphOutput& candidate : graph->outputs) {
      if (candidate.name == output) wanted = &candidate;
    }
  }
  if (!wanted) {
    Say(Severity::Error, "material-broken-library", current_ ? current_->path : network_.path,
        "the library's graph for '" + node.definition->name + "' has no output '" + output + "'");
    return unknown;
  }
  // Only what the output reaches, upstream first: a graph's nodes are in that order.
  std::vector<std::map<std::string, Port>> values(graph->nodes.size());
  const auto outputName = [&](uint32_t index, const std::string& name) {
    const NodeDefinition& definition = *graph->nodes[index].definition;
    return name.empty() && !definition.outputs.empty() ? definition.outputs[0].name : name;
  };
  values[wanted->node][outputName(wanted->node, wanted->output)];
  for (uint32_t i = wanted->node + 1; i-- > 0;) {
    if (values[i].empty()) continue;
    for (const GraphInput& input : graph->nodes[i].inputs) {
      if (input.source == GraphInput::Source::Node) values[input.node][outputName(input.node, input.output)];
    }
  }
  for (uint32_t i = 0; i <= wanted->node; ++i) {
    if (values[i].empty()) continue;
    const GraphNode& inner = graph->nodes[i];
    Node instance;
    instance.definition = inner.definition;
    instance.name = inner.name;
    instance.owner = node.definition;
    instance.ownerInputs = &node.inputs;
    for (const PortDefinition& input : inner.definition->inputs) {
      const auto given = std::find_if(inner.inputs.begin(), inner.inputs.end(),
                                      [&](const GraphInput& candidate) { return candidate.name == input.name; });
      Port port;
      if (given == inner.inputs.end()) {
        port = DefaultInput(nullptr, input);
      } else if (given->source == GraphInput::Source::Value) {
        port = Literal(input.type, given->value);
      } else if (given->source == GraphInput::Source::Node) {
        port = Fit(values[given->node][outputName(given->node, given->output)], input, nullptr);
      } else {
        port = DefaultInput(nullptr, input);
        for (size_t k = 0; k < node.definition->inputs.size(); ++k) {
          if (node.definition->inputs[k].name == given->value) port = Fit(node.inputs[k], input, nullptr);
        }
      }
      instance.inputs.push_back(port);
    }
    for (auto& [name, value] : values[i]) value = Evaluate(instance, name, depth);
  }
  return values[wanted->node][outputName(wanted->node, wanted->output)];
}

Port Builder::EvaluateInline(const Node& node) {
  Port result;
  if (node.definition->outputs.empty()) return result;
  result.type = node.definition->outputs[0].type;
  // "{{in1}} + {{in2}}" becomes "$0 + $1".
  std::string code;
  std::vector<Id> arguments;
  const std::string& source = node.definition->source;
  for (size_t at = 0; at < source.size();) {
    if (source.compare(at, 2, "{{") != 0) {
      code.push_back(source[at++]);
      continue;
    }
    const size_t end = source.find("}}", at);
    const std::string name = source.substr(at + 2, end - at - 2);
    for (size_t k = 0; k < node.inputs.size(); ++k) {
      if (node.definition->inputs[k].name != name || node.inputs[k].id == kNone) continue;
      const auto known = std::find(arguments.begin(), arguments.end(), node.inputs[k].id);
      code += "$" + std::to_string(known - arguments.begin());
      if (known == arguments.end()) arguments.push_back(node.inputs[k].id);
    }
    at = end + 2;
  }
  if (arguments.size() > 10 || Components(result.type) == 0) {
    result.isUnknown = true;
    return result;
  }
  // The library's own helpers ("mx_mod") live in its mathematics.
  if (code.find("mx_") != std::string::npos) callsLibrary_ = true;
  result.id = e_.Make("inline", result.type, std::move(arguments), code);
  return result;
}

Port Builder::EvaluateFunction(const Node& node, const std::string& output) {
  Port result;
  std::vector<Id> arguments;
  for (const Port& input : node.inputs) {
    // Texts cannot be passed to GLSL; a library function that wants one is one that we have to write ourselves.
    if (input.id == kNone || Components(input.type) == 0) {
      result.isUnknown = true;
      return result;
    }
    arguments.push_back(input.id);
  }
  std::string signature = node.definition->source;
  int index = 0, wanted = -1;
  for (const PortDefinition& port : node.definition->outputs) {
    if (port.name == output) wanted = index, result.type = port.type;
    signature += " " + std::string(GlslName(port.type));
    ++index;
  }
  std::set<std::string> seen;
  const std::string code = library_.FunctionSource(node.definition->file, &seen);
  if (wanted < 0 || Components(result.type) == 0 || code.empty() || code.find('$') != std::string::npos) {
    result.isUnknown = true;
    return result;
  }
  callsLibrary_ = true;
  functionFiles_.insert(node.definition->file);
  const Id call = e_.Make("call", Type::Call, std::move(arguments), signature);
  result.id = e_.Make("output", result.type, {call}, std::to_string(wanted));
  return result;
}

}  // namespace materialgen
