// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/ops.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <unordered_map>

namespace materialgen {
namespace {

using A = const OpArguments&;

float Clamp(float x, float low, float high) {
  return std::min(std::max(x, low), high);
}

void Select(A a, Constant* r) {
  const int which = (*a.values[0])[0] != 0 ? 1 : 2;
  for (int i = 0; i < a.resultComponents; ++i) {
    (*r)[i] = (*a.values[which])[a.components[which] == 1 ? 0 : i];
  }
}
void Construct(A a, Constant* r) {
  int at = 0;
  for (int k = 0; k < a.count; ++k) {
    for (int i = 0; i < a.components[k] && at < 16; ++i) (*r)[at++] = (*a.values[k])[i];
  }
  if (a.count == 1 && a.components[0] == 1) {
    for (int i = 1; i < a.resultComponents; ++i) (*r)[i] = (*r)[0];
  }
}
void Swizzle(A a, Constant* r) {
  for (int i = 0; i < a.resultComponents; ++i) {
    const size_t from = std::string_view("xyzw").find(a.text[i]);
    (*r)[i] = (*a.values[0])[from < 4 ? from : 0];
  }
}
void Dot(A a, Constant* r) {
  float sum = 0;
  for (int i = 0; i < a.components[0]; ++i) sum += (*a.values[0])[i] * (*a.values[1])[i];
  (*r)[0] = sum;
}
void Length(A a, Constant* r) {
  float sum = 0;
  for (int i = 0; i < a.components[0]; ++i) sum += (*a.values[0])[i] * (*a.values[0])[i];
  (*r)[0] = std::sqrt(sum);
}
void Normalize(A a, Constant* r) {
  Constant length{};
  Length(a, &length);
  for (int i = 0; i < a.components[0]; ++i) (*r)[i] = (*a.values[0])[i] / length[0];
}
void Cross(A a, Constant* r) {
  const Constant &u = *a.values[0], &v = *a.values[1];
  *r = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
void MaximumAbs(A a, Constant* r) {
  (*r)[0] = 0;
  for (int i = 0; i < a.components[0]; ++i) (*r)[0] = std::max((*r)[0], std::fabs((*a.values[0])[i]));
}
// Degrees, counter-clockwise positive amounts turn the *space*, as MaterialX's rotate2d.
void Rotate2d(A a, Constant* r) {
  const float angle = (*a.values[1])[0] * 0.01745329251994f;
  const float s = std::sin(angle), c = std::cos(angle), x = (*a.values[0])[0], y = (*a.values[0])[1];
  *r = {c * x + s * y, c * y - s * x};
}
// MaterialX roughness_anisotropy: alpha along and across the tangent.
void RoughnessAnisotropy(A a, Constant* r) {
  const float alpha = Clamp((*a.values[0])[0] * (*a.values[0])[0], 1e-6f, 1.0f);
  const float anisotropy = Clamp((*a.values[1])[0], 0.0f, 0.98f);
  const float aspect = std::sqrt(1.0f - anisotropy);
  *r = {std::min(alpha / aspect, 1.0f), alpha * aspect};
}
void IsotropicAlpha(A a, Constant* r) {
  const float alpha = Clamp((*a.values[0])[0] * (*a.values[0])[0], 1e-6f, 1.0f);
  *r = {alpha, alpha};
}
// Gulbrandsen 2014, "Artist Friendly Metallic Fresnel".
float ArtisticIor(float reflectivity, float edge, float) {
  const float r = Clamp(reflectivity, 0.0f, 0.99f), root = std::sqrt(r);
  const float low = (1 - r) / (1 + r), high = (1 + root) / (1 - root);
  return high + (low - high) * edge;
}
float ArtisticExtinction(float reflectivity, float edge, float) {
  const float r = Clamp(reflectivity, 0.0f, 0.99f), n = ArtisticIor(reflectivity, edge, 0);
  const float k2 = ((n + 1) * (n + 1) * r - (n - 1) * (n - 1)) / (1 - r);
  return std::sqrt(std::max(k2, 0.0f));
}

// clang-format off
const Op kOps[] = {
    // Leaves; the emitter knows them.
    {"literal", ""}, {"parameter", ""}, {"texture", ""}, {"text", ""}, {"asset", ""},
    // Arithmetic.
    {"add", "$0 + $1", [](float a, float b, float) { return a + b; }, nullptr, true},
    {"subtract", "$0 - $1", [](float a, float b, float) { return a - b; }, nullptr, true},
    {"multiply", "$0 * $1", [](float a, float b, float) { return a * b; }, nullptr, true},
    {"divide", "$0 / $1", [](float a, float b, float) { return a / b; }, nullptr, true},
    {"modulo", "mod($0, $1)", [](float a, float b, float) { return a - b * std::floor(a / b); }},
    {"power", "pow(max($0, 0.0), $1)", [](float a, float b, float) { return std::pow(std::max(a, 0.0f), b); }, nullptr, false, true},
    {"min", "min($0, $1)", [](float a, float b, float) { return std::min(a, b); }},
    {"max", "max($0, $1)", [](float a, float b, float) { return std::max(a, b); }},
    {"mix", "mix($0, $1, $2)", [](float a, float b, float t) { return a + (b - a) * t; }},
    {"clamp", "clamp($0, $1, $2)", [](float a, float b, float c) { return Clamp(a, b, c); }},
    {"absval", "abs($0)", [](float a, float, float) { return std::fabs(a); }},
    {"floor", "floor($0)", [](float a, float, float) { return std::floor(a); }},
    {"ceil", "ceil($0)", [](float a, float, float) { return std::ceil(a); }},
    {"round", "round($0)", [](float a, float, float) { return std::round(a); }},
    {"fract", "fract($0)", [](float a, float, float) { return a - std::floor(a); }},
    {"positive", "patternPositive($0)", [](float a, float, float) { return a > 0 ? a : 0; }},
    {"sign", "sign($0)", [](float a, float, float) { return float(a > 0) - float(a < 0); }},
    {"sqrt", "sqrt(max($0, 0.0))", [](float a, float, float) { return std::sqrt(std::max(a, 0.0f)); }},
    {"exp", "exp($0)", [](float a, float, float) { return std::exp(a); }},
    {"ln", "log($0)", [](float a, float, float) { return std::log(a); }},
    {"sin", "sin($0)", [](float a, float, float) { return std::sin(a); }},
    {"cos", "cos($0)", [](float a, float, float) { return std::cos(a); }},
    {"tan", "tan($0)", [](float a, float, float) { return std::tan(a); }},
    {"asin", "asin($0)", [](float a, float, float) { return std::asin(a); }},
    {"acos", "acos($0)", [](float a, float, float) { return std::acos(a); }},
    {"atan2", "atan($0, $1)", [](float a, float b, float) { return std::atan2(a, b); }, nullptr, false, true},
    // Comparison of scalars, and choice.
    {"greater", "$0 > $1", [](float a, float b, float) { return float(a > b); }, nullptr, true},
    {"greater_equal", "$0 >= $1", [](float a, float b, float) { return float(a >= b); }, nullptr, true},
    {"equal", "$0 == $1", [](float a, float b, float) { return float(a == b); }, nullptr, true},
    {"and", "$0 && $1", [](float a, float b, float) { return float(a != 0 && b != 0); }, nullptr, true},
    {"or", "$0 || $1", [](float a, float b, float) { return float(a != 0 || b != 0); }, nullptr, true},
    {"xor", "$0 != $1", [](float a, float b, float) { return float((a != 0) != (b != 0)); }, nullptr, true},
    {"not", "!$0", [](float a, float, float) { return float(a == 0); }, nullptr, true},
    {"select", "$0 ? $1 : $2", nullptr, Select, true, true},
    // Shape.
    {"construct", "$T(*)", nullptr, Construct},
    {"swizzle", "$0.$t", nullptr, Swizzle},
    {"to_float", "float($0)", [](float a, float, float) { return a; }},
    {"to_int", "int($0)", [](float a, float, float) { return std::trunc(a); }},
    // Vectors.
    {"dotproduct", "dot($0, $1)", nullptr, Dot},
    {"crossproduct", "cross($0, $1)", nullptr, Cross},
    {"magnitude", "length($0)", nullptr, Length},
    {"normalize", "normalize($0)", nullptr, Normalize},
    {"maximum_abs", "patternMaximumAbs($0)", nullptr, MaximumAbs},
    {"rotate2d", "patternRotate2d($0, $1)", nullptr, Rotate2d},
    // Surfaces.
    {"roughness_anisotropy", "patternRoughnessAnisotropy($0, $1)", nullptr, RoughnessAnisotropy},
    {"isotropic_alpha", "patternIsotropicAlpha($0)", nullptr, IsotropicAlpha},
    {"artistic_ior", "patternArtisticIor($0, $1)", ArtisticIor},
    {"artistic_extinction", "patternArtisticExtinction($0, $1)", ArtisticExtinction},
    {"schlick", "patternSchlick($0, $1, $2, sp.wo)"},
    {"cone", "patternCone($0, $1, $2, sp.wo)"},
    {"light_profile", "patternLightProfile($0, $1, $2, sp.wo)"},
    // Never folded into a vector: that both components are one value lets the compiler drop what anisotropy needs.
    {"one_alpha", "vec2($0)"},
    {"relative_ior", "$0 / sp.exteriorIor", nullptr, nullptr, true},
    {"faced_ior", "sp.frontFacing ? $0 : 1.0 / $0", nullptr, nullptr, true},
    // What a material reads at a hit. The text of a primvar reader is the primvar's name.
    {"position_world", "patternWorldPosition(sp)"}, {"position_object", "sp.positionObject"},
    {"normal_world", "sp.normalWorld"}, {"view", "-sp.wo"}, {"time", "frameSeconds()"}, {"frame_number", "frameNumber()"},
    {"primvar", ""},
    // The same a step along an edge of the triangle, 1 or 2.
    {"primvar_moved1", ""}, {"primvar_moved2", ""}, {"uv_moved", "patternUvMoved(sp, $0, $tu)"},
    {"position_world_moved", "patternWorldMoved(sp, $tu)"}, {"position_object_moved", "patternObjectMoved(sp, $tu)"},
    {"height_to_normal", "patternHeightToNormal($0, $1, $2, $3, $4, $5, $6)"},
    {"soft_step", "patternSoftStep($0, $1, $2)"},
    // Texture coordinates: one fetch serves the value, its footprint and the tangents.
    {"uv", "patternUv(sp, $s, $0)"}, {"uv_value", "$0.uv"}, {"footprint", "$0.footprint"},
    {"uv_frame", "patternUvFrame(sp, $0)"}, {"tangent", "$0.x"}, {"bitangent", "$0.y"},
    {"footprint_world", "sp.footprint"}, {"footprint_object", "patternObjectFootprint(sp)"},
    {"to_object_normal", "worldToObjectNormal(sp, $0)"}, {"to_object_vector", "worldToObjectVector(sp, $0)"},
    {"to_object_point", "worldToObjectPoint(sp, $0 - sceneOrigin())"}, {"to_world_normal", "objectToWorldNormal(sp, $0)"},
    {"to_world_vector", "objectToWorldVector(sp, $0)"}, {"to_world_point", "(objectToWorldPoint(sp, $0) + sceneOrigin())"},
    {"normalmap", "patternNormalMap($0, $1, $2, $3, $4)"},
    // texture, uv, footprint, outside, fallback; text: the filter, and for an image the wrap modes.
    {"image", "patternImage$t, $0, $1, $2, $3, $4)"},
    {"image_tiles", "patternTiles$t($0, $1, $2, $3)"},
    // texture, uv, footprint, amounts, ranges, ...: see lib/hextile.glsl.
    {"hextiles", "hexTiledImage($0, $1, $2, $3, $4, $5, $6, $7)"},
    {"hextiled_normal", "hexTiledNormal($0, $1, $2, $3, $4, $5, $6, $7, $8, $9)"},
    // Library code: an inline expression, or a call with its outputs.
    {"inline", ""}, {"call", ""}, {"output", ""},
    // Closures.
    {"frame", ""}, {"lobe", ""}, {"albedo", ""}, {"throughput", ""},
};
// clang-format on

}  // namespace

const Op& FindOp(std::string_view name) {
  static const auto* map = [] {
    auto* result = new std::unordered_map<std::string_view, const Op*>;
    for (const Op& op : kOps) result->emplace(op.name, &op);
    return result;
  }();
  const auto found = map->find(name);
  if (found == map->end()) {
    std::fprintf(stderr, "materialgen: no operation '%s'\n", std::string(name).c_str());
    std::abort();
  }
  return *found->second;
}

}  // namespace materialgen
