// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/ir.h"

#include <algorithm>
#include <cstring>

namespace materialgen {
namespace {

// Both walks below visit arguments of arguments; a host's network can be thousands of nodes deep.
constexpr int kMaximumDecisionDepth = 8;
constexpr int kMaximumNarrowingDepth = 32;

bool Is(const Expression& e, std::string_view op) {
  return e.op->name == op;
}

void AppendBytes(std::string* key, const void* data, size_t size) {
  key->append(static_cast<const char*>(data), size);
}

std::string KeyOf(const Expression& e, const std::string& salt) {
  std::string key(e.op->name);
  key.push_back(char('A' + int(e.type)));
  for (Id id : e.arguments) AppendBytes(&key, &id, sizeof(id));
  if (e.op->name == "literal") AppendBytes(&key, e.value.data(), sizeof(float) * size_t(Components(e.type)));
  key.push_back('|');
  key += e.text;
  key.push_back('|');
  key += salt;
  return key;
}

}  // namespace

Id Expressions::Add(Expression expression, const std::string& salt) {
  auto [at, isNew] = index_.emplace(KeyOf(expression, salt), Id(nodes_.size()));
  if (isNew) nodes_.push_back(std::move(expression));
  return at->second;
}

Id Expressions::Literal(Type type, const Constant& value) {
  Expression e;
  e.op = &FindOp("literal");
  e.type = type;
  e.rate = Class::Literal;
  e.value = value;
  return Add(std::move(e));
}

Id Expressions::Text(const std::string& text) {
  Expression e;
  e.op = &FindOp("text");
  e.type = Type::String;
  e.rate = Class::Literal;
  e.text = text;
  return Add(std::move(e));
}

Id Expressions::Asset(const AssetValue& asset) {
  Expression e;
  e.op = &FindOp("asset");
  e.type = Type::Asset;
  e.rate = Class::Literal;
  e.value[0] = float(assets_.size());
  assets_.push_back(asset);
  return Add(std::move(e), std::to_string(assets_.size()));
}

const AssetValue* Expressions::AssetOf(Id id) const {
  if (id == kNone || nodes_[id].op->name != "asset") return nullptr;
  return &assets_[size_t(nodes_[id].value[0])];
}

Id Expressions::Parameter(Type type, const Constant& value, const std::string& node, const std::string& input) {
  const std::string name = node + "\n" + input;
  if (std::find(frozen_->begin(), frozen_->end(), name) != frozen_->end()) return Literal(type, value);
  Expression e;
  e.op = &FindOp("parameter");
  e.type = type;
  e.rate = Class::Uniform;
  e.value = value;
  const Id id = Add(std::move(e), name);
  if (leafOf_.emplace(id, uint32_t(leaves_.size())).second) leaves_.push_back({node, input, id});
  return id;
}

Id Expressions::Texture(TextureLeaf texture) {
  Expression e;
  e.op = &FindOp("texture");
  e.type = Type::Int;
  e.value[0] = float(textures_.size());
  // Two image nodes share a texture id only if the network says so by sharing the node.
  const std::string salt = texture.node + "\n" + texture.file.resolvedPath + "\n" + texture.file.authoredPath + "\n" +
                           texture.file.colorSpace + "\n" + texture.sourceColorSpace + (texture.isColor ? "c" : "d");
  const size_t before = nodes_.size();
  const Id id = Add(std::move(e), salt);
  if (nodes_.size() != before) textures_.push_back(std::move(texture));
  return id;
}

Id Expressions::Make(const Op& op, Type type, std::vector<Id> arguments, std::string text) {
  const Id simple = Simplify(op, type, arguments, text);
  if (simple != kNone) return simple;
  Expression e;
  e.op = &op;
  e.type = type;
  e.rate = Class::Varying;
  const bool onCpu = (op.component || op.evaluate) && arguments.size() <= 8 && Components(type) > 0;
  if (onCpu) {
    e.rate = Class::Literal;
    for (Id id : arguments) e.rate = std::max(e.rate, nodes_[id].rate);
  }
  if (e.rate != Class::Varying) {
    OpArguments a;
    a.resultComponents = Components(type);
    a.text = text;
    for (Id id : arguments) {
      a.values[a.count] = &nodes_[id].value;
      a.components[a.count++] = Components(nodes_[id].type);
    }
    if (op.evaluate) {
      op.evaluate(a, &e.value);
    } else {
      const auto read = [&](int argument, int i) {
        if (argument >= a.count) return 0.0f;
        return (*a.values[argument])[size_t(a.components[argument] == 1 ? 0 : i)];
      };
      for (int i = 0; i < a.resultComponents; ++i)
        e.value[size_t(i)] = op.component(read(0, i), read(1, i), read(2, i));
    }
    if (e.rate == Class::Literal) return Literal(type, e.value);
  }
  e.arguments = std::move(arguments);
  e.text = std::move(text);
  return Add(std::move(e));
}

Id Expressions::Arithmetic(std::string_view op, std::vector<Id> arguments) {
  int widest = 1;
  for (Id id : arguments) widest = std::max(widest, Components(nodes_[id].type));
  if (widest > 4) {  // a matrix: no broadcast
    return Make(op, nodes_[arguments[0]].type, std::move(arguments));
  }
  const Type type = VectorType(widest);
  for (Id& id : arguments) {
    const Expression& e = nodes_[id];
    if (e.type == Type::Int || e.type == Type::Bool) id = Convert(id, Type::Float);
    const int components = Components(nodes_[id].type);
    if (components != 1 && components != widest) id = Convert(id, type);
  }
  return Make(op, type, std::move(arguments));
}

Id Expressions::Convert(Id id, Type type) {
  if (id == kNone) return kNone;
  const Type from = nodes_[id].type;
  if (from == type) return id;
  if (!IsVector(from) || !IsVector(type)) return kNone;
  if (from == Type::Bool || from == Type::Int) {
    if (type == Type::Bool)
      return Make("equal", Type::Bool, {Make("equal", Type::Bool, {id, Literal(from, {})}), Literal(Type::Bool, {})});
    if (type == Type::Int) return Make("to_int", Type::Int, {id});
    return Convert(Make("to_float", Type::Float, {id}), type);
  }
  if (type == Type::Int) return Make("to_int", Type::Int, {Convert(id, Type::Float)});
  if (type == Type::Bool) return Make("greater", Type::Bool, {Convert(id, Type::Float), Number(0)});
  const int have = Components(from), want = Components(type);
  if (have == 1) return Make("construct", type, {id});
  if (want < have) return Make("swizzle", type, {id}, std::string("xyzw", size_t(want)));
  std::vector<Id> parts{id};
  for (int i = have; i < want; ++i) parts.push_back(Number(i == 3 ? 1.0f : 0.0f));
  return Make("construct", type, std::move(parts));
}

bool Expressions::IsConstant(Id id, float value) const {
  const Expression& e = nodes_[id];
  if (e.rate != Class::Literal || !IsVector(e.type)) return false;
  for (int i = 0; i < Components(e.type); ++i) {
    if (e.value[size_t(i)] != value) return false;
  }
  return true;
}

void Expressions::Freeze(Id id) {
  const auto leaf = leafOf_.find(id);
  if (leaf == leafOf_.end()) return;
  newlyFrozen_.push_back(leaves_[leaf->second].node + "\n" + leaves_[leaf->second].input);
}

bool Expressions::Decide(Id id, float value, int depth) {
  const Expression& e = nodes_[id];
  if (depth > kMaximumDecisionDepth && e.rate == Class::Varying) return false;
  if (e.rate == Class::Varying) {
    // A product is zero where a factor is.
    if (value == 0 && Is(e, "multiply"))
      return Decide(e.arguments[0], 0, depth + 1) || Decide(e.arguments[1], 0, depth + 1);
    if (value == 0 && (Is(e, "construct") || Is(e, "clamp")) && !e.arguments.empty()) {
      if (Is(e, "clamp")) return IsConstant(e.arguments[1], 0) && Decide(e.arguments[0], 0, depth + 1);
      return e.arguments.size() == 1 && Decide(e.arguments[0], 0, depth + 1);
    }
    return false;
  }
  for (int i = 0; i < Components(e.type); ++i) {
    if (e.value[size_t(i)] != value) return false;
  }
  Freeze(id);
  if (e.arguments.empty() || depth > kMaximumDecisionDepth) return true;
  if (Is(e, "multiply") && value == 0) {
    for (Id argument : e.arguments) Decide(argument, 0, depth + 1);
  } else if (Is(e, "clamp") || Is(e, "construct") || Is(e, "to_float")) {
    Decide(e.arguments[0], value, depth + 1);
  }
  return true;
}

Id Expressions::SimplifySwizzle(Type type, Id source, const std::string& text) {
  const Expression e = nodes_[source];  // a copy: making expressions moves them
  const auto position = [](char c) { return std::string_view("xyzw").find(c); };
  if (Components(e.type) == 1 && text == "x") return source;
  if (type == e.type && text == std::string("xyzw", text.size())) return source;
  if (Is(e, "swizzle")) {
    std::string joined;
    for (char c : text) joined.push_back(e.text[position(c)]);
    return Make("swizzle", type, {e.arguments[0]}, joined);
  }
  if (Is(e, "construct")) {
    if (e.arguments.size() == 1) return Convert(e.arguments[0], type);
    // Follow each component into the argument that it comes from.
    std::vector<Id> parts;
    for (char c : text) {
      size_t at = position(c);
      for (Id argument : e.arguments) {
        const size_t width = size_t(Components(nodes_[argument].type));
        if (at < width) {
          parts.push_back(Make("swizzle", Type::Float, {argument}, std::string(1, "xyzw"[at])));
          break;
        }
        at -= width;
      }
    }
    if (parts.size() != text.size()) return kNone;
    // A leading vector that is taken whole stays whole.
    const Id first = e.arguments[0];
    if (nodes_[first].type == type && text == std::string("xyzw", text.size())) return first;
    return parts.size() == 1 ? parts[0] : Make("construct", type, std::move(parts));
  }
  // Narrow componentwise arithmetic, so that only the components in use are computed and loaded.
  if (e.op->component && e.rate == Class::Varying && Components(e.type) > 1 &&
      narrowingDepth_ < kMaximumNarrowingDepth) {
    const Op& op = *e.op;
    std::vector<Id> arguments = e.arguments;
    ++narrowingDepth_;
    for (Id& argument : arguments) {
      if (Components(nodes_[argument].type) > 1) argument = Make("swizzle", type, {argument}, text);
    }
    --narrowingDepth_;
    return Make(op, type, std::move(arguments));
  }
  return kNone;
}

Id Expressions::SimplifyArithmetic(const Op& op, Type type, const std::vector<Id>& a) {
  const auto whole = [&](Id id) { return nodes_[id].type == type ? id : Convert(id, type); };
  const auto literal = [&](Id id) { return IsLiteral(id); };
  if (op.name == "add") {
    if (IsConstant(a[0], 0)) return whole(a[1]);
    if (IsConstant(a[1], 0)) return whole(a[0]);
    if (literal(a[0]) && !literal(a[1])) return Make(op, type, {a[1], a[0]});
    const Expression x = nodes_[a[0]];
    if (literal(a[1]) && Is(x, "add") && literal(x.arguments[1])) {
      return Arithmetic("add", {x.arguments[0], Arithmetic("add", {x.arguments[1], a[1]})});
    }
  } else if (op.name == "subtract") {
    if (literal(a[1]) && !literal(a[0])) {
      return Arithmetic("add", {a[0], Arithmetic("multiply", {a[1], Number(-1)})});
    }
  } else if (op.name == "multiply") {
    if (IsConstant(a[0], 0) || IsConstant(a[1], 0)) return Literal(type, {});
    if (IsConstant(a[0], 1)) return whole(a[1]);
    if (IsConstant(a[1], 1)) return whole(a[0]);
    if (literal(a[0]) && !literal(a[1])) return Make(op, type, {a[1], a[0]});
    const Expression x = nodes_[a[0]];
    if (literal(a[1]) && Is(x, "multiply") && literal(x.arguments[1])) {
      return Arithmetic("multiply", {x.arguments[0], Arithmetic("multiply", {x.arguments[1], a[1]})});
    }
    if (literal(a[1]) && Is(x, "add") && literal(x.arguments[1])) {
      return Arithmetic(
          "add", {Arithmetic("multiply", {x.arguments[0], a[1]}), Arithmetic("multiply", {x.arguments[1], a[1]})});
    }
  } else if (op.name == "divide") {
    if (IsConstant(a[1], 1)) return whole(a[0]);
    if (IsConstant(a[0], 0)) return Literal(type, {});
  } else if (op.name == "power") {
    if (IsConstant(a[1], 1)) return whole(a[0]);
  } else if (op.name == "mix") {
    if (a[0] == a[1] || IsConstant(a[2], 0)) return whole(a[0]);
    if (IsConstant(a[2], 1)) return whole(a[1]);
  }
  return kNone;
}

Id Expressions::Simplify(const Op& op, Type type, std::vector<Id>& a, std::string& text) {
  const auto isUniform = [&] {
    return std::all_of(a.begin(), a.end(), [&](Id id) { return nodes_[id].rate != Class::Varying; });
  };
  if (op.name == "swizzle") return SimplifySwizzle(type, a[0], text);
  if (op.name == "construct") {
    if (a.size() == 1 && nodes_[a[0]].type == type) return a[0];
    const bool isSplat = a.size() > 1 && Components(nodes_[a[0]].type) == 1 &&
                         std::all_of(a.begin(), a.end(), [&](Id id) { return id == a[0]; });
    if (isSplat) a.resize(1);
  }
  if (op.name == "select") {
    // A condition that the values decide is a decision of the topology, unless the CPU can choose among values.
    const Expression& condition = nodes_[a[0]];
    if (a[1] == a[2]) return a[1];
    if (condition.rate == Class::Literal || (condition.rate == Class::Uniform && !isUniform())) {
      const Id chosen = condition.value[0] != 0 ? a[1] : a[2];
      return nodes_[chosen].type == type ? chosen : Convert(chosen, type);
    }
    return kNone;
  }
  if (op.component) return SimplifyArithmetic(op, type, a);
  return kNone;
}

}  // namespace materialgen
