// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Network -> expressions and closures. Node graphs of the library are instantiated only as far as they are reached.
#pragma once

#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "materialgen/closure.h"
#include "materialgen/ir.h"
#include "materialgen/library.h"
#include "materialgen/materialgen.h"

namespace materialgen {

// What closures must know of the whole surface before it is built: found by a pass, given to the next.
struct SurfaceFacts {
  bool transmits = false;     // lobes refract into a body: reflection inside must know the side
  bool isThinWalled = false;  // no inside: nothing bends, and no medium is entered
  bool operator==(const SurfaceFacts&) const = default;
};

struct Surface {
  BsdfId bsdf = kNone;
  Id emission = kNone;  // radiance towards the viewer; kNone: none
  Id opacity = kNone;   // kNone: opaque
};

// Value of an input or output.
struct Port {
  Type type = Type::None;
  Id id = kNone;           // expression, Bsdf, Vdf or Surface by type; kNone with Bsdf: no closure. Displacement: an
                           // expression, a number along the normal or a vector in (dPdu, dPdv, N); kNone: none
  bool isUnknown = false;  // comes from a node that nobody knows
};

// What one pass over the network yields.
struct Material {
  LinearClosure closure;
  SurfaceFacts facts;
  Id opacity = kNone;  // Surface's, before pass-through
  Id emission = kNone;
  std::string closureTree;  // in words
  Id displacement = kNone;  // of BuildDisplacement only: by how much a point moves, in object space
  int priority = 0;  // of its inside, 0..31
};

class Builder {
 public:
  // `facts`: what a pass before found out. `diffuseSubsurface`: GenerateOptions.
  Builder(Library* library, const MaterialNetwork& network, Expressions* expressions, const SurfaceFacts& facts,
          bool diffuseSubsurface = false);

  Material Build();
  Material BuildDisplacement();
  // Inputs of one node being evaluated, in the definition's order.
  struct Node {
    const NodeDefinition* definition = nullptr;
    std::vector<Port> inputs;
    std::string name;                       // within its graph; empty for nodes of the network
    const NodeDefinition* owner = nullptr;  // definition whose graph holds it; null for nodes of the network
    const std::vector<Port>* ownerInputs = nullptr;  // of that definition, in its order
  };
  std::vector<Message> TakeMessages() { return std::move(messages_); }
  bool CallsLibrary() const { return callsLibrary_; }
  const std::set<std::string>& FunctionFiles() const { return functionFiles_; }

 private:
  friend class NodeEvaluator;
  struct Entry {
    const materialgen::Node* node = nullptr;
    const NodeDefinition* definition = nullptr;
    std::map<std::string, const Connection*> connections;  // by input
    std::set<std::string> outputs;                         // asked for by others
    std::map<std::string, Port> values;                    // by output
  };

  void Index();
  std::vector<uint32_t> Order(uint32_t root);
  void SayIgnoredTransmission(const Entry& entry);
  void SayUnconnectedDisplacement(const Entry& entry);
  void SayWorldSpace(Id root);
  void SayMixedInsides(const LinearClosure& closure);
  void BuildEntry(Entry* entry);
  Port NetworkInput(Entry* entry, const PortDefinition& definition);
  void SayUnusedComponents(const std::string& what, Type have, const PortDefinition& definition,
                           const materialgen::Node& node);
  Port AuthoredInput(const materialgen::Node& node, const PortDefinition& definition, const Value& value);
  Port DefaultInput(const materialgen::Node* node, const PortDefinition& definition);
  Port Literal(Type type, const std::string& text);
  Port GeometricProperty(const std::string& name);
  // A vec2 primvar, as what textures read; `part`: "uv_value", "footprint", "tangent" or "bitangent".
  Id TextureCoordinates(std::string_view part, const std::string& primvar, Id fallback);
  // Fits a port to an input; a type error gives a message and the input's default.
  Port Fit(Port port, const PortDefinition& definition, const materialgen::Node* node);
  Port Evaluate(const Node& node, const std::string& output, int depth);
  Port EvaluateGraph(const Node& node, const std::string& output, int depth);
  Port EvaluateInline(const Node& node);
  Port EvaluateFunction(const Node& node, const std::string& output);
  Surface Fallback();
  void Say(Severity severity, const std::string& code, const std::string& location, const std::string& text);

  Library& library_;
  const MaterialNetwork& network_;
  Expressions& e_;
  SurfaceFacts facts_;
  bool diffuseSubsurface_;
  std::vector<Bsdf> bsdfs_;
  std::vector<Vdf> vdfs_;
  std::vector<Surface> surfaces_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string, uint32_t> entryOf_;
  const materialgen::Node* current_ = nullptr;  // node of the network that is being built
  std::vector<Message> messages_;
  std::set<std::string> said_;
  std::set<std::string> functionFiles_;
  bool callsLibrary_ = false;
};

// Nodes that are not left to the library's code: values, geometry, images, closures, surfaces (nodes.cpp,
// closures.cpp).
class NodeEvaluator {
 public:
  NodeEvaluator(Builder* builder, const Builder::Node& node, const std::string& output)
      : b_(*builder), e_(builder->e_), node_(node), output_(output) {}
  // False where the library's code or graph serves.
  bool Evaluate(Port* result);

 private:
  Id In(std::string_view name, Type type = Type::None);  // the expression, converted where a type is given
  Id OwnerIn(std::string_view name);  // an input of the definition whose graph holds this node
  bool InText(std::string_view name, std::string* text);
  bool Number(Port* result, Id id);
  Type OutputType() const;
  bool EvaluateOverride(Port* result);
  bool EvaluateTransmissionDepth(Port* result);
  bool EvaluateLamaInterior(Port* result);
  bool EvaluateText(Port* result);
  bool EvaluateVdf(Port* result);
  bool AddVdf(Port* result, const Vdf& vdf);
  bool EvaluateArithmetic(Port* result);
  bool EvaluateChannels(Port* result);
  bool EvaluateChoice(Port* result);
  bool EvaluateGeometry(Port* result);
  bool EvaluateTexture(Port* result);  // texture_nodes.cpp
  bool EvaluateImage(Port* result);
  void SayLayersAndFrames(const AssetValue& file);
  bool EvaluateHexTiles(Port* result);
  bool EvaluateNormalMap(Port* result);
  bool EvaluateHeightToNormal(Port* result);
  bool EvaluateSplit(Port* result);
  bool EvaluateMicrofacet(Port* result);
  bool EvaluateHair(Port* result);
  bool EvaluateBsdf(Port* result);
  bool EvaluateCombiner(Port* result);
  bool EvaluateEmission(Port* result);
  bool EvaluateMicrofacetBsdf(Port* result);
  bool AddThinTransmission(Port* result, std::string_view reflecting, std::vector<Id> arguments, Bsdf lobe, Id ior);
  bool IsThinWalled();
  bool EvaluateSurface(Port* result);
  Id PresenceOf(const Surface& surface);
  Id ShareOfPresent(Id factor, Id front, Id back, Id whole);
  bool EvaluateDisplacement(Port* result);
  Id Primvar(const std::string& name, Type type, Id fallback);
  Id Footprint(Id uv, int depth = 0);
  Id UvOf(Id id, int depth = 0);
  // A file input as a texture; kNone where no file is named.
  Id TextureOf(std::string_view input);
  // A tangent or bitangent for a normal map that reads the texture coordinates `uv` (kNone: the usual ones).
  Id TangentFor(std::string_view name, Id uv);
  // `root` where the surface is a step further along an edge of the triangle (1 or 2).
  Id Moved(Id root, int edge);
  Id FrameOf(bool isAnisotropic);
  bool AddLobe(Port* result, std::string_view kind, std::vector<Id> arguments, Bsdf lobe, bool hasAlpha);
  void Unsupported(const std::string& what);

  Builder& b_;
  Expressions& e_;
  const Builder::Node& node_;
  const std::string& output_;
};

}  // namespace materialgen
