// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pattern nodes that we evaluate ourselves: those the CPU can compute or simplify, and those that read the hit.
#include <algorithm>
#include <string>
#include <string_view>

#include "materialgen/builder.h"

namespace materialgen {
namespace {

struct ArithmeticRow {
  std::string_view category, op, inputs[3];
};
constexpr ArithmeticRow kArithmetic[] = {
    {"add", "add", {"in1", "in2"}},
    {"subtract", "subtract", {"in1", "in2"}},
    {"multiply", "multiply", {"in1", "in2"}},
    {"divide", "divide", {"in1", "in2"}},
    {"modulo", "modulo", {"in1", "in2"}},
    {"power", "power", {"in1", "in2"}},
    {"min", "min", {"in1", "in2"}},
    {"max", "max", {"in1", "in2"}},
    {"mix", "mix", {"bg", "fg", "mix"}},
    {"clamp", "clamp", {"in", "low", "high"}},
    {"absval", "absval", {"in"}},
    {"floor", "floor", {"in"}},
    {"ceil", "ceil", {"in"}},
    {"round", "round", {"in"}},
    {"fract", "fract", {"in"}},
    {"sign", "sign", {"in"}},
    {"sqrt", "sqrt", {"in"}},
    {"exp", "exp", {"in"}},
    {"ln", "ln", {"in"}},
    {"sin", "sin", {"in"}},
    {"cos", "cos", {"in"}},
    {"tan", "tan", {"in"}},
    {"asin", "asin", {"in"}},
    {"acos", "acos", {"in"}},
    {"atan2", "atan2", {"iny", "inx"}},
};

constexpr std::string_view kComponentNames = "xyzw";

// A number as an index from 0 to `last`; whatever the number is.
int IndexOf(float number, int last) {
  return number >= 1 ? (number < float(last) ? int(number) : last) : 0;
}

}  // namespace

Id NodeEvaluator::OwnerIn(std::string_view name) {
  for (size_t i = 0; node_.owner && node_.ownerInputs && i < node_.ownerInputs->size(); ++i)
    if (node_.owner->inputs[i].name == name) return (*node_.ownerInputs)[i].id;
  return kNone;
}

Id NodeEvaluator::In(std::string_view name, Type type) {
  for (size_t i = 0; i < node_.inputs.size(); ++i) {
    if (node_.definition->inputs[i].name != name) continue;
    const Port& port = node_.inputs[i];
    if (port.type == Type::Bsdf || port.type == Type::Vdf || port.type == Type::Surface ||
        port.type == Type::Displacement) {
      return port.id;
    }
    if (type != Type::None && port.id != kNone && port.type != type) return e_.Convert(port.id, type);
    return port.id;
  }
  return kNone;
}

bool NodeEvaluator::InText(std::string_view name, std::string* text) {
  const Id id = In(name);
  if (id == kNone || e_[id].type != Type::String) return false;
  *text = e_[id].text;
  return true;
}

Type NodeEvaluator::OutputType() const {
  const PortDefinition* output = node_.definition->FindOutput(output_);
  return output ? output->type : Type::None;
}

// Sets the result, converted to the output's type.
bool NodeEvaluator::Number(Port* result, Id id) {
  if (id == kNone) return false;
  result->type = OutputType();
  result->id = e_.Convert(id, result->type);
  return result->id != kNone;
}

bool NodeEvaluator::Evaluate(Port* result) {
  const Type type = OutputType();
  if (EvaluateOverride(result)) return true;
  if (type == Type::Bsdf) return EvaluateBsdf(result);
  if (type == Type::Vdf) return EvaluateVdf(result);
  if (type == Type::Surface) return EvaluateSurface(result);
  if (type == Type::Displacement) return EvaluateDisplacement(result);
  if (type == Type::String || type == Type::Asset) return EvaluateText(result);
  return EvaluateArithmetic(result) || EvaluateChannels(result) || EvaluateChoice(result) || EvaluateGeometry(result) ||
         EvaluateTexture(result) || EvaluateMicrofacet(result) || EvaluateHair(result) || EvaluateEmission(result);
}

// Texts and file names are known before the kernel is: they pass through the nodes that only hand on, or choose.
bool NodeEvaluator::EvaluateText(Port* result) {
  const std::string_view category = node_.definition->category;
  *result = {OutputType(), kNone};
  if (category == "constant") result->id = In("value");
  if (category == "dot") result->id = In("in");
  if (category == "geompropvalueuniform") {
    Unsupported("'" + node_.definition->name + "': a text read from a primvar is not supported; the default is used");
    result->id = In("default");
  }
  return result->id != kNone;
}

void NodeEvaluator::Unsupported(const std::string& what) {
  b_.Say(Severity::Warning, "material-unsupported-feature", b_.current_ ? b_.current_->path : b_.network_.path, what);
}

bool NodeEvaluator::EvaluateArithmetic(Port* result) {
  const Type type = OutputType();
  if (!IsVector(type)) return false;
  const std::string_view category = node_.definition->category;
  for (const ArithmeticRow& row : kArithmetic) {
    if (row.category != category) continue;
    std::vector<Id> arguments;
    for (std::string_view input : row.inputs) {
      if (input.empty()) continue;
      const Id id = In(input);
      if (id == kNone || !IsVector(e_[id].type)) return false;
      arguments.push_back(id);
    }
    return Number(result, e_.Arithmetic(row.op, std::move(arguments)));
  }
  if (category == "constant") return Number(result, In("value"));
  if (category == "dot") return Number(result, In("in"));
  if (category == "invert") return Number(result, e_.Arithmetic("subtract", {In("amount"), In("in")}));
  if (category == "dotproduct") return Number(result, e_.Make("dotproduct", Type::Float, {In("in1"), In("in2")}));
  if (category == "crossproduct") return Number(result, e_.Make("crossproduct", Type::Vec3, {In("in1"), In("in2")}));
  if (category == "magnitude") return Number(result, e_.Make("magnitude", Type::Float, {In("in")}));
  if (category == "normalize") return Number(result, e_.Make("normalize", type, {In("in")}));
  if (category == "rotate2d") return Number(result, e_.Make("rotate2d", Type::Vec2, {In("in"), In("amount")}));
  if (category == "remap") {
    const Id low = In("inlow"), span = e_.Arithmetic("subtract", {In("inhigh"), low});
    const Id outSpan = e_.Arithmetic("subtract", {In("outhigh"), In("outlow")});
    const Id scale = e_.Arithmetic("divide", {outSpan, span});
    const Id scaled = e_.Arithmetic("multiply", {e_.Arithmetic("subtract", {In("in"), low}), scale});
    return Number(result, e_.Arithmetic("add", {scaled, In("outlow")}));
  }
  if (category == "luminance") {
    const Id in = In("in"), coefficients = In("lumacoeffs", Type::Vec3);
    const Id luminance = e_.Make("dotproduct", Type::Float, {e_.Convert(in, Type::Vec3), coefficients});
    if (type != Type::Vec4) return Number(result, luminance);
    const Id alpha = e_.Make("swizzle", Type::Float, {in}, "w");
    return Number(result, e_.Make("construct", type, {e_.Convert(luminance, Type::Vec3), alpha}));
  }
  return false;
}

bool NodeEvaluator::EvaluateChannels(Port* result) {
  const std::string_view category = node_.definition->category;
  const Type type = OutputType();
  if (category == "convert") {
    // Where the library has a graph, it says which components a missing one becomes.
    if (node_.definition->implementation == NodeDefinition::Implementation::Graph || !IsVector(type)) return false;
    return Number(result, In("in"));
  }
  if (category == "combine2" || category == "combine3" || category == "combine4") {
    std::vector<Id> parts;
    for (const PortDefinition& input : node_.definition->inputs) parts.push_back(In(input.name));
    if (std::count(parts.begin(), parts.end(), kNone)) return false;
    return Number(result, e_.Make("construct", type, std::move(parts)));
  }
  if (category == "separate2" || category == "separate3" || category == "separate4") {
    for (size_t i = 0; i < node_.definition->outputs.size() && i < 4; ++i) {
      if (node_.definition->outputs[i].name != output_) continue;
      return Number(result, e_.Make("swizzle", Type::Float, {In("in")}, std::string(1, kComponentNames[i])));
    }
    return false;
  }
  if (category == "extract") {
    const Id in = In("in"), index = In("index");
    if (in == kNone || index == kNone || !IsVector(e_[in].type) || !e_.IsLiteral(index)) return false;
    const int last = Components(e_[in].type) - 1;
    const int at = IndexOf(e_.Scalar(index), last);
    return Number(result, e_.Make("swizzle", Type::Float, {in}, std::string(1, kComponentNames[size_t(at)])));
  }
  return false;
}

bool NodeEvaluator::EvaluateChoice(Port* result) {
  const std::string_view category = node_.definition->category;
  const Type type = OutputType();
  if (category == "and" || category == "or" || category == "xor") {
    return Number(result, e_.Make(category, Type::Bool, {In("in1", Type::Bool), In("in2", Type::Bool)}));
  }
  if (category == "not") return Number(result, e_.Make("not", Type::Bool, {In("in", Type::Bool)}));
  const bool isComparison = category == "ifgreater" || category == "ifgreatereq" || category == "ifequal";
  if (isComparison) {
    const Id a = In("value1"), b = In("value2");
    if (a == kNone || b == kNone || !IsVector(e_[a].type)) return false;
    const std::string_view op = category == "ifgreater" ? "greater" : category == "ifequal" ? "equal" : "greater_equal";
    const Id condition = e_.Make(op, Type::Bool, {a, b});
    if (type == Type::Bool && In("in1") == kNone) return Number(result, condition);
    if (!IsVector(type)) return false;
    return Number(result, e_.Make("select", type, {condition, In("in1", type), In("in2", type)}));
  }
  if (category == "switch") {
    const Id which = In("which", Type::Float);
    if (which == kNone || !IsVector(type)) return false;
    const auto input = [&](int i) { return In("in" + std::to_string(i + 1), type); };
    int count = 0;
    while (count < 10 && input(count) != kNone) ++count;
    if (count == 0) return false;
    // As in the library's graph, what lies past the last input is zero.
    const Id past = e_.Literal(type, {});
    if (e_.IsUniform(which)) {
      const int at = IndexOf(e_.Scalar(which), count);
      return Number(result, at < count ? input(at) : past);
    }
    Id chosen = past;
    for (int i = count; i-- > 0;) {
      const Id isBelow = e_.Make("greater", Type::Bool, {e_.Number(float(i + 1)), which});
      chosen = e_.Make("select", type, {isBelow, input(i), chosen});
    }
    return Number(result, chosen);
  }
  return false;
}

Id NodeEvaluator::Primvar(const std::string& name, Type type, Id fallback) {
  if (type == Type::Vec2) return b_.TextureCoordinates("uv_value", name, e_.Convert(fallback, type));
  return e_.Make("primvar", type, {e_.Convert(fallback, type)}, name);
}

bool NodeEvaluator::EvaluateGeometry(Port* result) {
  const std::string_view category = node_.definition->category;
  const Type type = OutputType();
  std::string space = "object", index = "0";
  InText("space", &space);
  const bool isWorld = space == "world";
  const auto value = [&](std::string_view op, Type t = Type::Vec3) { return e_.Make(op, t, {}); };
  if (category == "position") return Number(result, value(isWorld ? "position_world" : "position_object"));
  if (category == "normal") {
    const Id normal = value("normal_world");
    return Number(result, isWorld ? normal : e_.Make("to_object_normal", Type::Vec3, {normal}));
  }
  const auto direction = [&](Id world) {
    if (isWorld) return world;
    return e_.Make("normalize", Type::Vec3, {e_.Make("to_object_vector", Type::Vec3, {world})});
  };
  if (category == "tangent" || category == "bitangent") {
    return Number(result, direction(b_.TextureCoordinates(category, "st", e_.Literal(Type::Vec2, {}))));
  }
  if (category == "viewdirection") return Number(result, direction(value("view")));
  if (category == "time") return Number(result, value("time", Type::Float));
  if (category == "frame") return Number(result, value("frame_number", Type::Float));
  if (category == "texcoord") {
    const Id which = In("index");
    const int set = which == kNone ? 0 : IndexOf(e_.Scalar(which), 99);
    const std::string name = set > 0 ? "st" + std::to_string(set) : "st";
    return Number(result, Primvar(name, Type::Vec2, e_.Literal(Type::Vec2, {})));
  }
  if (category == "geomcolor") {
    const Id which = In("index");
    const int set = which == kNone ? 0 : IndexOf(e_.Scalar(which), 99);
    const std::string name = set > 0 ? "displayColor" + std::to_string(set) : "displayColor";
    return Number(result, Primvar(name, type, e_.Literal(type, {})));
  }
  if (category == "geompropvalue") {
    std::string name;
    if (!InText("geomprop", &name) || !IsVector(type)) return false;
    const Id fallback = In("default", type);
    if (name.empty()) {
      Unsupported("a primvar reader without a name; the fallback is used");
      return Number(result, fallback);
    }
    if (type != Type::Int && type != Type::Bool) return Number(result, Primvar(name, type, fallback));
    // Weights of the corners add up to one but for rounding: truncating would give the next smaller number.
    return Number(result, e_.Arithmetic("round", {Primvar(name, Type::Float, fallback)}));
  }
  if (category == "transformpoint" || category == "transformvector" || category == "transformnormal") {
    std::string from, to;
    if (!InText("fromspace", &from) || !InText("tospace", &to)) return false;
    const bool fromWorld = from == "world", toWorld = to == "world";
    if (fromWorld == toWorld) return Number(result, In("in"));
    const std::string op = std::string(toWorld ? "to_world_" : "to_object_") + std::string(category.substr(9));
    return Number(result, e_.Make(op, Type::Vec3, {In("in")}));
  }
  return false;
}

bool NodeEvaluator::EvaluateMicrofacet(Port* result) {
  const std::string_view category = node_.definition->category;
  if (category == "roughness_anisotropy") {
    const Id roughness = In("roughness"), anisotropy = In("anisotropy");
    // No anisotropy: no tangents to compute.
    if (e_.Decide(anisotropy, 0)) return Number(result, e_.Make("isotropic_alpha", Type::Vec2, {roughness}));
    return Number(result, e_.Make("roughness_anisotropy", Type::Vec2, {roughness, anisotropy}));
  }
  if (category == "artistic_ior") {
    const std::string_view op = output_ == "ior" ? "artistic_ior" : "artistic_extinction";
    return Number(result, e_.Arithmetic(op, {In("reflectivity"), In("edge_color")}));
  }
  return false;
}

}  // namespace materialgen
