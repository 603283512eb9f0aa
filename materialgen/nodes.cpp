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
    if (port.type == Type::Bsdf || port.type == Type::Surface || port.type == Type::Displacement) return port.id;
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
  if (type == Type::Surface) return EvaluateSurface(result);
  if (type == Type::Displacement) return EvaluateDisplacement(result);
  return EvaluateArithmetic(result) || EvaluateChannels(result) || EvaluateChoice(result) || EvaluateGeometry(result) ||
         EvaluateImage(result) || EvaluateNormalMap(result) || EvaluateMicrofacet(result) || EvaluateHair(result) ||
         EvaluateEmission(result);
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
    if (e_.IsUniform(which)) return Number(result, input(IndexOf(e_.Scalar(which), count - 1)));
    Id chosen = input(count - 1);
    for (int i = count - 1; i-- > 0;) {
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
  if (category == "tangent" || category == "bitangent") {
    const Id tangent = b_.TextureCoordinates(category, "st", e_.Literal(Type::Vec2, {}));
    return Number(result, isWorld ? tangent : e_.Make("to_object_vector", Type::Vec3, {tangent}));
  }
  if (category == "viewdirection") {
    return Number(result, isWorld ? value("view") : e_.Make("to_object_vector", Type::Vec3, {value("view")}));
  }
  if (category == "time" || category == "frame") return Number(result, value("time", Type::Float));
  if (category == "texcoord") {
    const Id which = In("index");
    const int set = which == kNone ? 0 : IndexOf(e_.Scalar(which), 99);
    const std::string name = set > 0 ? "st" + std::to_string(set) : "st";
    return Number(result, Primvar(name, Type::Vec2, e_.Literal(Type::Vec2, {})));
  }
  if (category == "geomcolor") return Number(result, Primvar("displayColor", type, e_.Literal(type, {})));
  if (category == "geompropvalue" || category == "geompropvalueuniform") {
    std::string name;
    if (type == Type::String || type == Type::Asset) {
      Unsupported("a text read from a primvar is not supported; the fallback is used");
      *result = {type, In("default")};
      return result->id != kNone;
    }
    if (!InText("geomprop", &name) || !IsVector(type)) return false;
    const Id fallback = In("default", type);
    if (name.empty()) {
      Unsupported("a primvar reader without a name; the fallback is used");
      return Number(result, fallback);
    }
    const bool isNumber = type == Type::Int || type == Type::Bool;
    return Number(result, Primvar(name, isNumber ? Type::Float : type, fallback));
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

// Width of the ray cone in units of the texture coordinate `uv`, followed through what scales it.
Id NodeEvaluator::Footprint(Id uv, int depth) {
  const Expression expression = e_[uv];
  if (depth > 16 || expression.rate != Class::Varying) return kNone;
  const std::string_view op = expression.op->name;
  if (op == "uv_value") return e_.Make("footprint", Type::Float, {expression.arguments[0]});
  if (op == "tangent" || op == "bitangent") return kNone;
  for (size_t i = 0; i < expression.arguments.size(); ++i) {
    const Id footprint = Footprint(expression.arguments[i], depth + 1);
    if (footprint == kNone) continue;
    const Id other = expression.arguments.size() == 2 ? expression.arguments[1 - i] : kNone;
    const bool isScaled = (op == "multiply" || (op == "divide" && i == 0)) && e_.IsUniform(other);
    if (!isScaled) return footprint;
    const Id scale = op == "multiply" ? other : e_.Arithmetic("divide", {e_.Number(1), other});
    return e_.Arithmetic("multiply", {footprint, e_.Make("maximum_abs", Type::Float, {scale})});
  }
  return kNone;
}

// The texture coordinates ("uv") that feed a value: a normal map's tangents follow them. kNone: none.
Id NodeEvaluator::UvOf(Id id, int depth) {
  const Expression& expression = e_[id];
  if (depth > 16 || expression.rate != Class::Varying) return kNone;
  if (expression.op->name == "uv") return id;
  for (Id argument : expression.arguments) {
    const Id uv = UvOf(argument, depth + 1);
    if (uv != kNone) return uv;
  }
  return kNone;
}

bool NodeEvaluator::EvaluateImage(Port* result) {
  if (node_.definition->category != "image") return false;
  const Type type = OutputType();
  const Id fallback = In("default", type), uv = In("texcoord", Type::Vec2);
  const AssetValue* asset = e_.AssetOf(In("file"));
  if (fallback == kNone || uv == kNone || !asset) return false;
  if (asset->authoredPath.empty() && asset->resolvedPath.empty()) return Number(result, fallback);

  TextureLeaf texture;
  texture.node = b_.current_ ? b_.current_->path : b_.network_.path;
  texture.file = *asset;
  texture.isColor = node_.definition->name.find("color") != std::string::npos;
  const bool isUsd = b_.current_ && b_.current_->identifier == "UsdUVTexture";
  if (isUsd || node_.owner) {
    if (b_.current_) {
      const auto space = b_.current_->parameters.find("sourceColorSpace");
      const auto* text = space == b_.current_->parameters.end() ? nullptr : std::get_if<std::string>(&space->second);
      if (text) texture.sourceColorSpace = *text;
    }
    if (isUsd && texture.sourceColorSpace.empty()) texture.sourceColorSpace = "auto";
  }
  // Numbers of WrapMode in wavefront/scene.h.
  bool isConstant = false;
  const auto wrap = [&](std::string_view input, const char* usd) {
    std::string mode = "periodic";
    InText(input, &mode);
    // USD's default is "useMetadata": what the file says. Image files in use say nothing, USD's text leaves that case
    // open, and assets rely on what MaterialX's definition of the node and production renderers do: repeat.
    if (isUsd && !b_.current_->parameters.count(usd)) mode = "useMetadata";
    if (mode == "clamp") return "1u";
    if (mode == "mirror") return "2u";
    isConstant = isConstant || mode == "constant";
    return mode == "black" || mode == "constant" ? "3u" : "0u";
  };
  const std::string modes = std::string(wrap("uaddressmode", "wrapS")) + ", " + wrap("vaddressmode", "wrapT");
  Id footprint = Footprint(uv);
  if (footprint == kNone) footprint = e_.Number(0);
  const Id whole = e_.Convert(fallback, Type::Vec4);
  const Id outside = isConstant ? whole : e_.Literal(Type::Vec4, {});
  const Id texel = e_.Make("image", Type::Vec4, {e_.Texture(texture), uv, footprint, outside, whole}, modes);
  return Number(result, texel);
}

bool NodeEvaluator::EvaluateNormalMap(Port* result) {
  if (node_.definition->category != "normalmap") return false;
  const Id in = In("in", Type::Vec3), normal = In("normal", Type::Vec3), scale = In("scale", Type::Vec2);
  if (in == kNone || normal == kNone || scale == kNone) return false;
  const Id direction = e_.Arithmetic("subtract", {e_.Arithmetic("multiply", {in, e_.Number(2)}), e_.Number(1)});
  // A straight normal, however it is spelled, is no normal map at all.
  if (e_.IsLiteral(direction)) {
    const Constant& d = e_[direction].value;
    if (d[0] == 0 && d[1] == 0 && d[2] > 0) return Number(result, normal);
  }
  const Id uv = UvOf(in);
  const auto tangent = [&](std::string_view name) {
    const Id given = In(name, Type::Vec3);
    const bool isDefault = given == kNone || e_[given].op->name == name;
    if (!isDefault) return given;
    if (uv == kNone) return b_.TextureCoordinates(name, "st", e_.Literal(Type::Vec2, {}));
    return e_.Make(name, Type::Vec3, {e_.Make("uv_frame", Type::Frame, {uv})});
  };
  const Id t = tangent("tangent"), b = tangent("bitangent");
  return Number(result, e_.Make("normalmap", Type::Vec3, {direction, scale, normal, t, b}));
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
