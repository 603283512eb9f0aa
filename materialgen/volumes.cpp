// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Nodes that make media: VDFs, their combiners, and what standard_surface says about the inside of a body.
#include <string_view>

#include "materialgen/builder.h"

namespace materialgen {

// Coefficients add up in a mixture; the mean cosine is that of all that scatters.
Vdf Sum(Expressions& e, const Vdf& a, const Vdf& b) {
  const auto add = [&](Id x, Id y) { return x == kNone ? y : y == kNone ? x : e.Arithmetic("add", {x, y}); };
  Vdf sum;
  sum.absorption = add(a.absorption, b.absorption);
  sum.scattering = add(a.scattering, b.scattering);
  if (a.scattering == kNone || b.scattering == kNone || a.anisotropy == b.anisotropy) {
    sum.anisotropy = a.scattering == kNone ? b.anisotropy : a.anisotropy;
    return sum;
  }
  const Id third = e.Color(1.0f / 3, 1.0f / 3, 1.0f / 3);
  const auto mean = [&](Id color) { return e.Make("dotproduct", Type::Float, {e.Convert(color, Type::Vec3), third}); };
  const auto moment = [&](const Vdf& v) {
    return v.anisotropy == kNone ? e.Number(0) : e.Arithmetic("multiply", {mean(v.scattering), v.anisotropy});
  };
  const Id all = e.Arithmetic("max", {e.Arithmetic("add", {mean(a.scattering), mean(b.scattering)}), e.Number(1e-20f)});
  sum.anisotropy = e.Arithmetic("divide", {e.Arithmetic("add", {moment(a), moment(b)}), all});
  return sum;
}

Vdf Scaled(Expressions& e, const Vdf& v, Id factor) {
  const auto scale = [&](Id x) { return x == kNone ? x : e.Arithmetic("multiply", {x, factor}); };
  return {scale(v.absorption), scale(v.scattering), v.anisotropy};
}

bool NodeEvaluator::AddVdf(Port* result, const Vdf& vdf) {
  b_.vdfs_.push_back(vdf);
  *result = {Type::Vdf, Id(b_.vdfs_.size() - 1)};
  return true;
}

bool NodeEvaluator::EvaluateVdf(Port* result) {
  const std::string_view category = node_.definition->category;
  const auto input = [&](std::string_view name) {
    const Id id = In(name);
    return id == kNone ? Vdf() : b_.vdfs_[id];
  };
  if (category == "absorption_vdf") return AddVdf(result, {In("absorption"), kNone, kNone});
  if (category == "anisotropic_vdf") return AddVdf(result, {In("absorption"), In("scattering"), In("anisotropy")});
  if (category == "add") return AddVdf(result, Sum(e_, input("in1"), input("in2")));
  if (category == "multiply") return AddVdf(result, Scaled(e_, input("in1"), In("in2")));
  if (category == "mix") {
    const Id amount = e_.Arithmetic("clamp", {In("mix", Type::Float), e_.Number(0), e_.Number(1)});
    const Id rest = e_.Arithmetic("subtract", {e_.Number(1), amount});
    return AddVdf(result, Sum(e_, Scaled(e_, input("fg"), amount), Scaled(e_, input("bg"), rest)));
  }
  return false;
}

// Lama's interior as its own node definitions describe it: absorptionColor is what is left of white light after
// absorptionRadius (1: a clear body), scatterColor the share of the extinction that is scattered. MaterialX's graphs feed
// both colours to the coefficients as they are, which makes the default, a clear body, a dark one.
bool NodeEvaluator::EvaluateLamaInterior(Port* result) {
  const Id color = OwnerIn("absorptionColor"), radius = OwnerIn("absorptionRadius"), scatter = OwnerIn("scatterColor");
  if (color == kNone || radius == kNone || scatter == kNone) return false;
  const Id zero = e_.Number(0), one = e_.Number(1);
  const Id left = e_.Arithmetic("clamp", {color, e_.Number(1e-4f), one});
  const Id depth = e_.Arithmetic("multiply", {e_.Arithmetic("ln", {left}), e_.Number(-1)});
  const Id extinction = e_.Arithmetic("divide", {depth, e_.Arithmetic("max", {radius, e_.Number(1e-6f)})});
  const Id albedo = e_.Arithmetic("clamp", {scatter, zero, one});
  const Id absorbed = e_.Arithmetic("multiply", {extinction, e_.Arithmetic("subtract", {one, albedo})});
  const Id scattered = e_.Decide(albedo, 0) ? kNone : e_.Arithmetic("multiply", {extinction, albedo});
  return AddVdf(result, {absorbed, scattered, OwnerIn("scatterAnisotropy")});
}

// Autodesk's standard_surface ("Transmission"): with a transmission_depth, transmission_color is what is left of white
// light after that distance inside, and the interface itself tints nothing. transmission_scatter / depth is the
// scattering part of that extinction; where it is more than the whole, as much grey absorption is added as makes all
// coefficients positive. MaterialX's graph leaves all of it out.
bool NodeEvaluator::EvaluateTransmissionDepth(Port* result) {
  const Id depth = OwnerIn("transmission_depth"), isThin = OwnerIn("thin_walled");
  if (depth == kNone || e_.Decide(depth, 0) || (isThin != kNone && e_.Scalar(isThin) != 0)) return false;
  if (!EvaluateBsdf(result)) return false;
  Bsdf& lobe = b_.bsdfs_[result->id];
  const Id left = e_.Arithmetic("clamp", {lobe.tint, e_.Number(1e-4f), e_.Number(1)});
  lobe.tint = e_.Number(1);
  const Id distance = e_.Arithmetic("max", {depth, e_.Number(1e-6f)});
  const auto perUnit = [&](Id x) { return e_.Arithmetic("divide", {x, distance}); };
  Bsdf body;
  body.kind = Bsdf::Kind::Volume;
  body.first = result->id;
  body.inside.absorption = perUnit(e_.Arithmetic("multiply", {e_.Arithmetic("ln", {left}), e_.Number(-1)}));
  const Id scatter = OwnerIn("transmission_scatter");
  if (scatter != kNone && !e_.Decide(scatter, 0)) {
    body.inside.scattering = perUnit(scatter);
    body.inside.anisotropy = OwnerIn("transmission_scatter_anisotropy");
    const Id rest = e_.Arithmetic("subtract", {body.inside.absorption, body.inside.scattering});
    const auto part = [&](const char* component) { return e_.Make("swizzle", Type::Float, {rest}, component); };
    const Id least = e_.Arithmetic("min", {e_.Arithmetic("min", {part("x"), part("y")}), part("z")});
    body.inside.absorption = e_.Arithmetic("subtract", {rest, e_.Arithmetic("min", {least, e_.Number(0)})});
  }
  b_.bsdfs_.push_back(body);
  *result = {Type::Bsdf, Id(b_.bsdfs_.size() - 1)};
  return true;
}

}  // namespace materialgen
