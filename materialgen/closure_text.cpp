// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/closure_text.h"

#include <cstdio>

namespace materialgen {
namespace {

std::string ValueText(const Expressions& e, Id id) {
  if (id == kNone) return "1";
  const Expression& expression = e[id];
  if (expression.rate == Class::Varying) return "varies";
  std::string text;
  const int count = Components(expression.type);
  for (int i = 0; i < count; ++i) {
    char number[32];
    std::snprintf(number, sizeof(number), "%s%.4g", i ? ", " : "", double(expression.value[size_t(i)]));
    text += number;
  }
  return count > 1 ? "(" + text + ")" : text;
}

bool IsZero(const Expressions& e, Id id) {
  if (id == kNone || e[id].rate == Class::Varying) return false;
  for (int i = 0; i < Components(e[id].type); ++i)
    if (e[id].value[size_t(i)] != 0.0f) return false;
  return true;
}

std::string VdfText(const Expressions& e, const Vdf& v) {
  const auto part = [&](Id id) { return id == kNone ? std::string("0") : ValueText(e, id); };
  return "absorption " + part(v.absorption) + ", scattering " + part(v.scattering) + ", anisotropy " + part(v.anisotropy);
}

std::string Line(const Expressions& e, const Bsdf& bsdf) {
  switch (bsdf.kind) {
    case Bsdf::Kind::Lobe: {
      std::string text(bsdf.lobe ? bsdf.lobe->name : "lobe");
      text += ", weight " + ValueText(e, bsdf.weight);
      if (bsdf.tint != kNone) text += ", tint " + ValueText(e, bsdf.tint);
      if (IsZero(e, bsdf.weight) || IsZero(e, bsdf.tint)) text += " (left out)";
      return text;
    }
    case Bsdf::Kind::PassThrough: return "light passes straight through";
    case Bsdf::Kind::Layer: return "layer: the first over the second";
    case Bsdf::Kind::Mix: return "mix: the first by " + ValueText(e, bsdf.factor) + ", else the second";
    case Bsdf::Kind::Add: return "add";
    case Bsdf::Kind::Scale: return "multiply by " + ValueText(e, bsdf.factor);
    case Bsdf::Kind::Volume: return "body below, " + VdfText(e, bsdf.inside);
    case Bsdf::Kind::ThinWall: return "thin-walled";
  }
  return "?";
}

}  // namespace

std::string ClosureText(const Expressions& expressions, const std::vector<Bsdf>& nodes, BsdfId root) {
  if (root == kNone) return "no closure: black\n";
  std::string text;
  // A stack, not recursion: networks may be of any depth. A node that is used twice stands there twice.
  std::vector<std::pair<BsdfId, int>> stack{{root, 0}};
  for (int lines = 0; !stack.empty(); ++lines) {
    if (lines == kClosureTextLines) return text + "...\n";
    const auto [id, depth] = stack.back();
    stack.pop_back();
    text += std::string(2 * size_t(depth), ' ');
    if (id == kNone) {
      text += "nothing\n";
      continue;
    }
    const Bsdf& bsdf = nodes[id];
    text += Line(expressions, bsdf) + "\n";
    const bool hasTwo = bsdf.kind == Bsdf::Kind::Layer || bsdf.kind == Bsdf::Kind::Mix || bsdf.kind == Bsdf::Kind::Add;
    const bool hasOne = !hasTwo && bsdf.kind != Bsdf::Kind::Lobe && bsdf.kind != Bsdf::Kind::PassThrough;
    if (hasTwo) stack.emplace_back(bsdf.second, depth + 1);
    if (hasTwo || hasOne) stack.emplace_back(bsdf.first, depth + 1);
  }
  return text;
}

}  // namespace materialgen
