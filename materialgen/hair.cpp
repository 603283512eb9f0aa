// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Nodes that turn what an artist says of hair into the inputs of chiang_hair_bsdf. The library's GLSL for them shares a
// file with the lobe, whose code needs MaterialX's own shader framework; as expressions the CPU folds them.
#include <string_view>

#include "materialgen/builder.h"

namespace materialgen {
namespace {

// Polynomial of x, the constant first (Horner).
Id Polynomial(Expressions& e, Id x, std::initializer_list<float> coefficients) {
  Id sum = kNone;
  for (auto c = std::rbegin(coefficients); c != std::rend(coefficients); ++c) {
    sum = sum == kNone ? e.Number(*c) : e.Arithmetic("add", {e.Arithmetic("multiply", {sum, x}), e.Number(*c)});
  }
  return sum;
}

}  // namespace

bool NodeEvaluator::EvaluateHair(Port* result) {
  const std::string_view category = node_.definition->category;
  const auto multiply = [&](Id a, Id b) { return e_.Arithmetic("multiply", {a, b}); };
  const auto clamp = [&](Id x, float low, float high) {
    return e_.Arithmetic("clamp", {x, e_.Number(low), e_.Number(high)});
  };
  if (category == "chiang_hair_roughness") {
    // Chiang et al. 2016, equations 7 and 8; TT and TRT are scaled as Marschner et al. 2003 found.
    const Id along = clamp(In("longitudinal"), 0.001f, 1), around = clamp(In("azimuthal"), 0.001f, 1);
    const auto widen = [&](Id x, float power) { return e_.Arithmetic("power", {x, e_.Number(power)}); };
    const Id deviation = e_.Arithmetic(
        "add", {Polynomial(e_, along, {0, 0.726f, 0.812f}), multiply(e_.Number(3.7f), widen(along, 20))});
    const Id width = e_.Arithmetic(
        "add", {Polynomial(e_, around, {0, 0.265f, 1.194f}), multiply(e_.Number(5.372f), widen(around, 22))});
    Id variance = multiply(deviation, deviation);
    for (const char* term : {"TT", "TRT"}) {
      if (output_ != std::string("roughness_") + term) continue;
      const Id scale = In(std::string("scale_") + term);
      variance = multiply(variance, multiply(scale, scale));
    }
    return Number(result, e_.Make("construct", Type::Vec2, {variance, width}));
  }
  if (category == "deon_hair_absorption_from_melanin") {
    // d'Eon et al. 2011; the colours are exp(-absorption) of the pigments.
    const Id left = e_.Arithmetic("subtract", {e_.Number(1), In("melanin_concentration")});
    const Id melanin = e_.Arithmetic("ln", {e_.Arithmetic("max", {left, e_.Number(1e-4f)})});
    const Id redness = In("melanin_redness");
    const auto absorbed = [&](const char* color, Id share) {
      return multiply(multiply(melanin, share), e_.Arithmetic("ln", {clamp(In(color), 1e-4f, 1e4f)}));
    };
    const Id sum = e_.Arithmetic(
        "add", {absorbed("eumelanin_color", e_.Arithmetic("subtract", {e_.Number(1), redness})),
                absorbed("pheomelanin_color", redness)});
    return Number(result, e_.Arithmetic("max", {sum, e_.Number(0)}));
  }
  if (category == "chiang_hair_absorption_from_color") {
    // Chiang et al. 2016, equation 9.
    const Id divisor =
        Polynomial(e_, In("azimuthal_roughness"), {5.969f, -0.215f, 2.532f, -10.73f, 5.574f, 0.245f});
    const Id root = e_.Arithmetic("divide", {e_.Arithmetic("ln", {clamp(In("color"), 0.001f, 1)}), divisor});
    return Number(result, multiply(root, root));
  }
  return false;
}

}  // namespace materialgen
