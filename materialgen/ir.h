// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The expressions of one material: a hash-consed DAG, folded while it is built. Ids ascend from arguments to results,
// so every walk is a loop and a chain of any length is safe.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "materialgen/network.h"
#include "materialgen/ops.h"
#include "materialgen/type.h"

namespace materialgen {

using Id = uint32_t;
constexpr Id kNone = 0xffffffffu;

// Literal: same for every material of this topology. Uniform: depends on values of the material, computed here and
// stored in the parameter block. Varying: computed by the kernel.
enum class Class : uint8_t { Literal, Uniform, Varying };

struct Expression {
  const Op* op = nullptr;
  Type type = Type::None;
  Class rate = Class::Varying;
  std::vector<Id> arguments;
  std::string text;  // what else the operation needs: a swizzle, a primvar name, an inline expression ...
  Constant value{};  // Literal and Uniform
};

// A value that a user can edit: an input of a node of the network.
struct Leaf {
  std::string node, input;
  Id id = kNone;
};

// A texture that an image node reads.
struct TextureLeaf {
  std::string node;
  AssetValue file;
  std::string sourceColorSpace;
  bool isColor = true;
};

class Expressions {
 public:
  // `frozen`: leaves that a decision of an earlier pass took for constant, as "node\ninput".
  explicit Expressions(const std::vector<std::string>* frozen) : frozen_(frozen) {}

  Id Literal(Type type, const Constant& value);
  Id Number(float value) { return Literal(Type::Float, {value}); }
  Id Boolean(bool value) { return Literal(Type::Bool, {value ? 1.0f : 0.0f}); }
  Id Color(float r, float g, float b) { return Literal(Type::Vec3, {r, g, b}); }
  Id Text(const std::string& text);   // a string
  Id Asset(const AssetValue& asset);  // a file name, held aside: see AssetOf
  Id Parameter(Type type, const Constant& value, const std::string& node, const std::string& input);
  Id Texture(TextureLeaf texture);
  // Folds and simplifies. Arguments that are kNone are not allowed, except for operations that say so.
  Id Make(const Op& op, Type type, std::vector<Id> arguments, std::string text = {});
  Id Make(std::string_view op, Type type, std::vector<Id> arguments, std::string text = {}) {
    return Make(FindOp(op), type, std::move(arguments), std::move(text));
  }
  // Converts between numbers: splats a scalar, drops or adds components (missing alpha is 1). kNone where impossible.
  Id Convert(Id id, Type type);
  // Componentwise with the type of the widest argument.
  Id Arithmetic(std::string_view op, std::vector<Id> arguments);

  const Expression& operator[](Id id) const { return nodes_[id]; }
  size_t size() const { return nodes_.size(); }
  bool IsLiteral(Id id) const { return nodes_[id].rate == Class::Literal; }
  bool IsUniform(Id id) const { return nodes_[id].rate != Class::Varying; }
  bool IsConstant(Id id, float value) const;  // Literal, all components equal to value
  float Scalar(Id id) const { return nodes_[id].value[0]; }
  const AssetValue* AssetOf(Id id) const;

  // A decision on the topology: true if the value is 0 (or `value`) for this material and not Varying. Freezes what
  // decides: the same question about an edited value gives another topology.
  bool Decide(Id id, float value) { return Decide(id, value, 0); }
  const std::vector<std::string>& NewlyFrozen() const { return newlyFrozen_; }

  const std::vector<Leaf>& Leaves() const { return leaves_; }
  const std::vector<TextureLeaf>& Textures() const { return textures_; }

 private:
  Id Add(Expression expression, const std::string& salt = {});
  Id Simplify(const Op& op, Type type, std::vector<Id>& arguments, std::string& text);
  Id SimplifyArithmetic(const Op& op, Type type, const std::vector<Id>& arguments);
  Id SimplifySwizzle(Type type, Id source, const std::string& text);
  void Freeze(Id id);
  bool Decide(Id id, float value, int depth);

  std::vector<Expression> nodes_;
  std::unordered_map<std::string, Id> index_;
  std::vector<Leaf> leaves_;
  std::unordered_map<Id, uint32_t> leafOf_;
  std::vector<TextureLeaf> textures_;
  std::vector<AssetValue> assets_;
  const std::vector<std::string>* frozen_;
  std::vector<std::string> newlyFrozen_;
  int narrowingDepth_ = 0;
};

}  // namespace materialgen
