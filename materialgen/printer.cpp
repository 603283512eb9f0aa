// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/printer.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "materialgen/closure.h"

namespace materialgen {
namespace {

constexpr size_t kInlineLength = 90;  // longer expressions get a name, so that the source can be read

std::string NumberText(float value) {
  if (!std::isfinite(value)) value = 0;
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  std::string text(buffer, end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string LiteralText(Type type, const Constant& value) {
  if (type == Type::Bool) return value[0] != 0 ? "true" : "false";
  if (type == Type::Int) return std::to_string(int(std::clamp(value[0], -1e9f, 1e9f)));
  const int components = Components(type);
  if (components == 1) return NumberText(value[0]);
  bool isSame = components <= 4;
  for (int i = 1; i < components; ++i) isSame = isSame && value[size_t(i)] == value[0];
  std::string text = std::string(GlslName(type)) + "(" + NumberText(value[0]);
  for (int i = 1; i < components && !isSame; ++i) text += ", " + NumberText(value[size_t(i)]);
  return text + ")";
}

// Ids that the roots need: all of them ascending, Varying ones followed to their arguments.
std::vector<Id> Live(const Expressions& e, const std::vector<Id>& roots) {
  std::vector<bool> live(e.size(), false);
  for (Id root : roots) live[root] = true;
  for (Id id = Id(e.size()); id-- > 0;) {
    if (!live[id] || e[id].rate != Class::Varying) continue;
    for (Id argument : e[id].arguments) live[argument] = true;
  }
  std::vector<Id> result;
  for (Id id = 0; id < e.size(); ++id) {
    if (live[id]) result.push_back(id);
  }
  return result;
}

bool ReadsPrimvar(const Expression& expression) {
  return expression.op->name.substr(0, 7) == "primvar" || expression.op->name == "uv";
}

// How often an argument's text appears, so that nothing costly is written twice.
int Occurrences(std::string_view pattern, size_t argument) {
  int count = 0;
  for (size_t at = pattern.find('$'); at != std::string_view::npos; at = pattern.find('$', at + 1)) {
    if (at + 1 < pattern.size() && pattern[at + 1] == char('0' + argument)) ++count;
  }
  return count;
}

}  // namespace

uint32_t Layout::SlotOf(const std::string& primvar) const {
  return uint32_t(std::find(primvars.begin(), primvars.end(), primvar) - primvars.begin());
}

Layout LayOut(const Expressions& e, const std::vector<std::vector<Id>>& entries, uint32_t reserved) {
  Layout layout;
  std::set<Id> stored;
  for (const std::vector<Id>& roots : entries) {
    for (Id id : Live(e, roots)) {
      const Expression& expression = e[id];
      if (expression.rate == Class::Uniform || expression.op->name == "texture") stored.insert(id);
      if (ReadsPrimvar(expression) && layout.SlotOf(expression.text) == layout.primvars.size()) {
        layout.primvars.push_back(expression.text);
      }
    }
  }
  // Widest first leaves no holes but at the end.
  std::vector<uint32_t> used(reserved, 4);
  for (int components = 4; components >= 1; --components) {
    for (Id id : stored) {
      if (Components(e[id].type) != components) continue;
      size_t texel = 0;
      while (texel < used.size() && used[texel] + uint32_t(components) > 4) ++texel;
      if (texel == used.size()) used.push_back(0);
      layout.offsets[id] = uint32_t(4 * texel) + used[texel];
      used[texel] += uint32_t(components);
    }
  }
  layout.floats = uint32_t(4 * used.size());
  return layout;
}

Printer::Printer(const Expressions& expressions, const Layout& layout, const std::vector<Id>& roots)
    : e_(expressions), layout_(layout) {
  const std::vector<Id> live = Live(e_, roots);
  for (Id id : roots) ++uses_[id];
  for (Id id : live) {
    const Expression& expression = e_[id];
    if (expression.rate != Class::Varying) continue;
    const std::string_view pattern =
        expression.op->name == "inline" ? std::string_view(expression.text) : expression.op->glsl;
    for (size_t i = 0; i < expression.arguments.size(); ++i)
      uses_[expression.arguments[i]] += std::max(1, Occurrences(pattern, i));
  }
  for (Id id : live) Print(id);
  body_ = parameters_ + body_;
}

std::string Printer::ParameterTexel(uint32_t texel) {
  const std::string name = "q" + std::to_string(texel);
  if (texels_.insert(texel).second) {
    parameters_ += "  vec4 " + name + " = materialParameter(sp, " + std::to_string(texel) + "u);\n";
  }
  return name;
}

std::string Printer::Parameter(Id id) {
  const uint32_t offset = layout_.offsets.at(id);
  const int components = Components(e_[id].type);
  std::string text = ParameterTexel(offset / 4);
  if (components < 4) text += "." + std::string("xyzw").substr(offset % 4, size_t(components));
  if (e_[id].op->name == "texture") return "floatBitsToUint(" + text + ")";
  if (e_[id].type == Type::Bool) return "(" + text + " != 0.0)";
  if (e_[id].type == Type::Int) return "int(" + text + ")";
  return text;
}

std::string Printer::TextAs(Id id, Type type) const {
  const std::string text = texts_.at(id).text;
  return e_[id].type == type ? text : std::string(GlslName(type)) + "(" + text + ")";
}

// Arguments as text, scalars widened where GLSL has no overload for the mixture.
std::vector<std::string> Printer::Arguments(const Expression& expression) const {
  const std::string_view op = expression.op->name;
  const int components = Components(expression.type);
  std::vector<std::string> texts;
  bool isMixed = false;
  const auto width = [&](size_t i) { return Components(e_[expression.arguments[i]].type); };
  for (size_t i = 0; i < expression.arguments.size(); ++i) isMixed = isMixed || width(i) != components;
  bool widen = isMixed && ((expression.op->component && !expression.op->infix) || expression.op->sameTypes);
  if (op == "min" || op == "max" || op == "modulo") widen = isMixed && width(0) != components;
  if (op == "mix") widen = isMixed && (width(0) != components || width(1) != components);
  if (op == "clamp") widen = isMixed && !(width(0) == components && width(1) == 1 && width(2) == 1);
  const bool wraps = expression.op->infix || op == "swizzle" || op == "inline" || op == "select";
  for (size_t i = 0; i < expression.arguments.size(); ++i) {
    const Id argument = expression.arguments[i];
    const Printed& printed = texts_.at(argument);
    const bool isCondition = op == "select" && i == 0;
    if (widen && !isCondition && width(i) != components) {
      texts.push_back(std::string(GlslName(expression.type)) + "(" + printed.text + ")");
    } else {
      texts.push_back(printed.infix && wraps ? "(" + printed.text + ")" : printed.text);
    }
  }
  return texts;
}

// "$0": argument; "$t": the text; "$s": slot of the primvar named by the text.
std::string Printer::Substitute(const Expression& expression, const std::string& pattern,
                                const std::vector<std::string>& arguments) const {
  std::string out;
  for (size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '$' || i + 1 == pattern.size()) {
      out.push_back(pattern[i]);
      continue;
    }
    const char c = pattern[++i];
    if (c == 't') {
      out += expression.text;
    } else if (c == 's') {
      out += std::to_string(layout_.SlotOf(expression.text)) + "u";
    } else if (size_t(c - '0') < arguments.size()) {
      out += arguments[size_t(c - '0')];
    }
  }
  return out;
}

void Printer::WriteFrame(const Expression& expression, const std::string& name) {
  const std::vector<std::string> a = Arguments(expression);
  body_ += "  Frame " + name + " = " +
           (a.size() > 1 ? "patternFrameTangent(sp, " + a[0] + ", " + a[1] : "patternFrame(sp, " + a[0]) +
           ");\n  vec3 o" + name + " = toLocal(" + name + ", sp.wo);\n";
}

Printer::Printed Printer::Write(const Expression& expression) {
  const std::string_view op = expression.op->name;
  const std::vector<std::string> a = Arguments(expression);
  const auto join = [&](size_t from) {
    std::string list;
    for (size_t i = from; i < a.size(); ++i) list += (i > from ? ", " : "") + a[i];
    return list;
  };
  if (op == "construct") return {std::string(GlslName(expression.type)) + "(" + join(0) + ")"};
  if (op.substr(0, 7) == "primvar") {
    const std::string point = op == "primvar" ? "sp" : "patternMoved(sp, " + std::string(op.substr(13)) + "u)";
    const Type type = expression.type == Type::Int || expression.type == Type::Bool ? Type::Float : expression.type;
    const std::string suffix = type == Type::Float ? "Float" : "Vec" + std::to_string(Components(type));
    return {"primvar" + suffix + "(" + point + ", " + std::to_string(layout_.SlotOf(expression.text)) + "u, " + a[0] + ")"};
  }
  if (op == "inline") return {Substitute(expression, expression.text, a), true};
  if (op == "albedo" || op == "throughput") {
    const LobeKind& kind = FindLobe(expression.text);
    const Id frame = e_[expression.arguments[0]].arguments[0];
    return {std::string(kind.function) + (op == "albedo" ? "Albedo(" : "Throughput(") + a[0] + ", o" +
            texts_.at(frame).text + ")"};
  }
  return {Substitute(expression, std::string(expression.op->glsl), a), expression.op->infix};
}

void Printer::Print(Id id) {
  const Expression& expression = e_[id];
  const std::string_view op = expression.op->name;
  if (expression.rate == Class::Literal) {
    texts_[id] = {LiteralText(expression.type, expression.value)};
    return;
  }
  if (expression.rate == Class::Uniform || op == "texture") {
    texts_[id] = {Parameter(id)};
    return;
  }
  if (op == "uv" || op == "uv_frame") {
    const std::string name = "v" + std::to_string(values_++);
    body_ += "  " + std::string(GlslName(expression.type)) + " " + name + " = " + Write(expression).text + ";\n";
    texts_[id] = {name};
    return;
  }
  if (op == "frame") {
    const std::string name = "f" + std::to_string(frames_++);
    WriteFrame(expression, name);
    texts_[id] = {name};
    return;
  }
  if (op == "lobe") {
    const LobeKind& kind = FindLobe(expression.text);
    lobeFiles_.insert(expression.text);
    const std::string name = "l" + std::to_string(lobes_++);
    const std::vector<std::string> a = Arguments(expression);
    std::string list = "o" + a[0];
    for (size_t i = 1; i < a.size(); ++i) list += ", " + a[i];
    body_ +=
        "  " + std::string(kind.structure) + " " + name + " = " + std::string(kind.function) + "Make(" + list + ");\n";
    texts_[id] = {name};
    return;
  }
  if (op == "call") {
    callsLibrary_ = true;
    const std::string name = "v" + std::to_string(values_++);
    std::string list;
    for (const std::string& argument : Arguments(expression)) list += argument + ", ";
    // "function type type": one variable per output.
    size_t at = expression.text.find(' ');
    const std::string function = expression.text.substr(0, at);
    std::string outputs;
    for (int index = 0; at != std::string::npos; ++index) {
      const size_t next = expression.text.find(' ', at + 1);
      const std::string variable = name + "_" + std::to_string(index);
      body_ += "  " + expression.text.substr(at + 1, next - at - 1) + " " + variable + ";\n";
      outputs += (index ? ", " : "") + variable;
      at = next;
    }
    body_ += "  " + function + "(" + list + outputs + ");\n";
    texts_[id] = {name};
    return;
  }
  if (op == "output") {
    texts_[id] = {texts_.at(expression.arguments[0]).text + "_" + expression.text};
    return;
  }
  if (op.substr(0, 7) == "hextile") callsHexTiles_ = true;
  if (op == "inline" && expression.text.find("mx_") != std::string::npos) callsLibrary_ = true;
  Printed printed = Write(expression);
  const bool isCheap = op == "swizzle" || op == "uv_value" || op == "footprint" || op == "tangent" ||
                       op == "bitangent" || printed.text.rfind("sp.", 0) == 0;
  if ((uses_[id] <= 1 || isCheap) && printed.text.size() <= kInlineLength) {
    texts_[id] = std::move(printed);
    return;
  }
  const std::string name = "v" + std::to_string(values_++);
  body_ += "  " + std::string(GlslName(expression.type)) + " " + name + " = " + printed.text + ";\n";
  texts_[id] = {name};
}

}  // namespace materialgen
