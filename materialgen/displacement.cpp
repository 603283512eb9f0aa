// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The displacement terminal: nodes that make displacement shaders, and how far a point moves.
#include <cmath>
#include <string>
#include <string_view>

#include "materialgen/builder.h"

namespace materialgen {

// A UsdPreviewSurface displaces through the material's displacement terminal; without it the input does nothing, and an
// artist who set it will wonder.
void Builder::SayUnconnectedDisplacement(const Entry& entry) {
  if (!network_.displacementNode.empty()) return;
  const auto value = entry.node->parameters.find("displacement");
  const float* amount = value == entry.node->parameters.end() ? nullptr : std::get_if<float>(&value->second);
  if (!entry.connections.count("displacement") && !(amount && *amount != 0)) return;
  Say(Severity::Info, "material-displacement-not-connected", entry.node->path,
      "the input displacement is set, but the material's displacement output is not connected; nothing is displaced");
}

// One mesh serves all instances, so a displacement cannot know where each of them stands.
void Builder::SayWorldSpace(Id root) {
  std::vector<bool> isLive(root + 1, false);
  isLive[root] = true;
  for (Id id = root + 1; id-- > 0;) {
    if (!isLive[id]) continue;
    for (Id argument : e_[id].arguments) isLive[argument] = true;
    const std::string_view op = e_[id].op->name;
    if (op != "position_world" && op != "view") continue;
    Say(Severity::Warning, "material-unsupported-feature", network_.path,
        op == "view" ? "a displacement that reads the view direction sees the normal instead"
                     : "a displacement that reads world space sees object space instead");
  }
}

// The offset of a point in object space. MaterialX 1.39, displacement: a number goes along the normal, a vector is in
// (dPdu, dPdv, N). The tangents are unit vectors, as MaterialX's own tangents are, orthogonal to the smooth normal.
Material Builder::BuildDisplacement() {
  Material material;
  Index();
  const auto root = entryOf_.find(network_.displacementNode);
  const auto fail = [&](const std::string& where, const std::string& why) {
    Say(Severity::Error, "material-no-displacement", where, why + "; nothing is displaced");
    return material;
  };
  if (root == entryOf_.end())
    return fail(network_.path, "the displacement terminal '" + network_.displacementNode + "' is not in the network");
  Entry& terminal = entries_[root->second];
  if (const NodeDefinition* definition = library_.Find(terminal.node->identifier);
      definition && definition->category == "UsdPreviewSurface") {
    // The rest of the surface belongs to the other terminal.
    std::erase_if(terminal.connections, [](const auto& connection) { return connection.first != "displacement"; });
  }
  const std::vector<uint32_t> order = Order(root->second);
  terminal.outputs = {network_.displacementOutput};
  for (uint32_t entry : order) BuildEntry(&entries_[entry]);
  const Port port = terminal.values[network_.displacementOutput];
  if (port.isUnknown) return material;  // told
  if (port.type != Type::Displacement)
    return fail(terminal.node->path, "output '" + network_.displacementOutput + "' of '" + terminal.node->identifier +
                                         "' is not a displacement shader");
  if (port.id == kNone || e_.Decide(port.id, 0)) return material;
  const Id normal = e_.Make("normal_world", Type::Vec3, {});
  if (e_[port.id].type == Type::Float) {
    material.displacement = e_.Arithmetic("multiply", {normal, port.id});
  } else {
    const auto along = [&](std::string_view component, Id direction) {
      return e_.Arithmetic("multiply",
                           {direction, e_.Make("swizzle", Type::Float, {port.id}, std::string(component))});
    };
    const Id none = e_.Literal(Type::Vec2, {});
    const Id tangent = TextureCoordinates("tangent", "st", none), bitangent = TextureCoordinates("bitangent", "st", none);
    material.displacement = e_.Arithmetic(
        "add", {e_.Arithmetic("add", {along("x", tangent), along("y", bitangent)}), along("z", normal)});
  }
  SayWorldSpace(material.displacement);
  return material;
}

// A number and a vector only meet in a mix: the number is the vector's third component.
bool NodeEvaluator::EvaluateDisplacement(Port* result) {
  const std::string_view category = node_.definition->category;
  result->type = Type::Displacement;
  if (category == "dot") {
    result->id = In("in");
    return true;
  }
  if (category == "displacement") {
    const Id amount = In("displacement"), scale = In("scale", Type::Float);
    if (amount == kNone || scale == kNone || !IsVector(e_[amount].type)) return false;
    result->id = e_.Arithmetic("multiply", {amount, scale});
    return true;
  }
  if (category != "mix") return false;
  const auto whole = [&](Id id) { return id == kNone ? e_.Number(0) : id; };
  const auto vector = [&](Id id) {
    if (e_[id].type != Type::Float) return id;
    return e_.Make("construct", Type::Vec3, {e_.Number(0), e_.Number(0), id});
  };
  Id front = whole(In("fg")), back = whole(In("bg"));
  if (e_[front].type != e_[back].type) front = vector(front), back = vector(back);
  const Id factor = e_.Arithmetic("clamp", {In("mix", Type::Float), e_.Number(0), e_.Number(1)});
  result->id = e_.Arithmetic("mix", {back, front, factor});
  return true;
}

}  // namespace materialgen
