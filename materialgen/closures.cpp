// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Nodes that make closures: BSDFs, their combiners, emission and surfaces; and what differs from MaterialX's graphs.
#include <algorithm>
#include <string>
#include <string_view>

#include "materialgen/builder.h"

namespace materialgen {

// Where we depart from the library's graphs, by graph and node. UsdPreviewSurface: MaterialX makes its transparency a
// refracting interface. An opacity that varies over the surface draws leaves, decals and cards: open sheets, which light
// passes straight, shadows included. So it does with an index of 1, where that is what refraction is.
bool NodeEvaluator::EvaluateOverride(Port* result) {
  if (!node_.owner) return false;
  if (node_.owner->category == "standard_surface" && node_.name == "transmission_bsdf") {
    return EvaluateTransmissionDepth(result);
  }
  const bool isLama = node_.owner->category == "LamaDielectric" || node_.owner->category == "LamaGeneralizedSchlick";
  if (isLama && node_.name == "interior_vdf") return EvaluateLamaInterior(result);
  // Without extra roughness refraction is exactly as rough as reflection, so that the two can share their facets. (The
  // clamp that this leaves out is made again where alpha is.)
  if (node_.owner->category == "standard_surface" && node_.name == "transmission_roughness_clamped" &&
      e_.Decide(OwnerIn("transmission_extra_roughness"), 0)) {
    *result = {Type::Float, OwnerIn("specular_roughness")};
    return true;
  }
  if (node_.owner->category != "UsdPreviewSurface") return false;
  const Id opacity = OwnerIn("opacity");
  const bool isDrawn = opacity != kNone && e_[opacity].rate == Class::Varying;
  if (node_.name == "transmission_bsdf" && (isDrawn || e_.Decide(In("ior"), 1))) {
    Bsdf through;
    through.kind = Bsdf::Kind::PassThrough;
    b_.bsdfs_.push_back(through);
    *result = {Type::Bsdf, Id(b_.bsdfs_.size() - 1)};
    return true;
  }
  // No threshold, no cut-out, whatever the opacity's values.
  if (node_.name == "cutout_opacity" && e_.Decide(In("value2"), 0)) {
    *result = {Type::Float, e_.Number(1)};
    return true;
  }
  return false;
}

// A frame per distinct (normal, tangent); isotropic lobes need no tangent. Hair runs along its tangent.
Id NodeEvaluator::FrameOf(bool isAnisotropic) {
  const Id normal = In("normal", Type::Vec3), direction = In("curve_direction", Type::Vec3);
  const Id tangent = direction == kNone ? In("tangent", Type::Vec3) : direction;
  const Id given = normal == kNone ? e_.Make("normal_world", Type::Vec3, {}) : normal;
  if (isAnisotropic && tangent != kNone) return e_.Make("frame", Type::Frame, {given, tangent});
  return e_.Make("frame", Type::Frame, {given});
}

bool NodeEvaluator::AddLobe(Port* result, std::string_view kind, std::vector<Id> arguments, Bsdf lobe, bool hasAlpha) {
  if (std::count(arguments.begin(), arguments.end(), kNone)) return false;
  bool isAnisotropic = kind == "chiang_hair";
  if (hasAlpha) {
    const Expression& alpha = e_[In("roughness", Type::Vec2)];
    isAnisotropic = alpha.op->name != "isotropic_alpha" &&
                    !(alpha.rate == Class::Literal && alpha.value[0] == alpha.value[1]) &&
                    !(alpha.op->name == "construct" && alpha.arguments.size() == 1);
    if (!isAnisotropic) {
      const Id roughness = In("roughness");
      const Id one = e_.Make("swizzle", Type::Float, {roughness}, "x");
      std::replace(arguments.begin(), arguments.end(), roughness, e_.Make("one_alpha", Type::Vec2, {one}));
    }
  }
  arguments.insert(arguments.begin(), FrameOf(isAnisotropic));
  lobe.kind = Bsdf::Kind::Lobe;
  lobe.lobe = &FindLobe(kind);
  lobe.expression = e_.Make("lobe", Type::Lobe, std::move(arguments), std::string(kind));
  const Id weight = In("weight", Type::Float);
  lobe.weight = weight == kNone ? e_.Number(1) : e_.Arithmetic("clamp", {weight, e_.Number(0), e_.Number(1)});
  if (lobe.tint == kNone) lobe.tint = e_.Number(1);
  b_.bsdfs_.push_back(lobe);
  *result = {Type::Bsdf, Id(b_.bsdfs_.size() - 1)};
  return true;
}

bool NodeEvaluator::EvaluateBsdf(Port* result) {
  const std::string_view category = node_.definition->category;
  if (category == "layer" || category == "mix" || category == "add" || category == "multiply") {
    return EvaluateCombiner(result);
  }
  const Id white = e_.Color(1, 1, 1), color = In("color", Type::Vec3), roughness = In("roughness");
  Bsdf lobe;
  if (category == "oren_nayar_diffuse_bsdf") {
    const Id compensate = In("energy_compensation");
    const bool isCompensated = compensate != kNone && e_.Scalar(compensate) != 0 && !e_.IsConstant(roughness, 0);
    return AddLobe(result, isCompensated ? "oren_nayar_compensated" : "oren_nayar", {color, roughness}, lobe, false);
  }
  if (category == "burley_diffuse_bsdf") return AddLobe(result, "burley", {color, roughness}, lobe, false);
  if (category == "translucent_bsdf") return AddLobe(result, "translucent", {color}, lobe, false);
  if (category == "subsurface_bsdf") {
    const Id radius = In("radius", Type::Vec3), anisotropy = In("anisotropy");
    if (b_.diffuseSubsurface_ || radius == kNone || e_.Decide(radius, 0)) {
      return AddLobe(result, "oren_nayar", {color, e_.Number(0)}, lobe, false);
    }
    return AddLobe(result, "subsurface", {color, radius, anisotropy == kNone ? e_.Number(0) : anisotropy}, lobe, false);
  }
  if (category == "sheen_bsdf") {
    std::string mode;
    InText("mode", &mode);
    lobe.tint = color;
    return AddLobe(result, mode == "zeltner" ? "sheen_zeltner" : "sheen_conty_kulla", {white, roughness}, lobe, false);
  }
  if (category == "chiang_hair_bsdf") {
    std::vector<Id> arguments;
    for (const char* input : {"tint_R", "tint_TT", "tint_TRT", "ior", "roughness_R", "roughness_TT", "roughness_TRT",
                              "cuticle_angle", "absorption_coefficient"}) {
      arguments.push_back(In(input));
    }
    return AddLobe(result, "chiang_hair", std::move(arguments), lobe, false);
  }
  return EvaluateMicrofacetBsdf(result);
}

// Dielectric, conductor, generalised Schlick. A graph of the library may still serve other nodes.
bool NodeEvaluator::EvaluateMicrofacetBsdf(Port* result) {
  const std::string_view category = node_.definition->category;
  const bool isDielectric = category == "dielectric_bsdf", isConductor = category == "conductor_bsdf";
  if (!isDielectric && !isConductor && category != "generalized_schlick_bsdf") return false;
  // No film, no turned reflection: constants, and the compiler drops what belongs to them.
  const Id thickness = In("thinfilm_thickness"), retro = In("retroreflective"), roughness = In("roughness");
  const Id none = e_.Make("construct", Type::Vec2, {e_.Number(0), e_.Number(1)});
  const bool hasFilm = thickness != kNone && !e_.Decide(thickness, 0);
  const Id film = hasFilm ? e_.Make("construct", Type::Vec2, {thickness, In("thinfilm_ior")}) : none;
  std::string scatter = "R";
  if (!isConductor) InText("scatter_mode", &scatter);
  Bsdf lobe;
  Id ior = e_.Number(1.5f);
  std::string reflecting = "conductor", kind;
  std::vector<Id> arguments;
  if (isConductor) {
    arguments = {In("ior"), In("extinction")};
  } else if (isDielectric) {
    ior = In("ior");
    lobe.interface = ior;
    lobe.tint = In("tint");
    reflecting = "dielectric_reflection";
    kind = scatter == "T" ? "dielectric_transmission" : scatter == "RT" ? "dielectric" : reflecting;
    if (scatter != "R") lobe.bodyIor = ior;
    // What a body lies in counts for its own interface (nested dielectrics). Seen from inside the body, the interface is
    // that of the outside: total reflection and all.
    Id faced = b_.facts_.transmits ? e_.Make("relative_ior", Type::Float, {ior}) : ior;
    if (scatter == "R" && b_.facts_.transmits) faced = e_.Make("faced_ior", Type::Float, {faced});
    arguments = {e_.Color(1, 1, 1), faced};
  } else {
    reflecting = "generalized_schlick";
    const bool isT = scatter == "T", isRt = scatter == "RT";
    kind = isT ? "generalized_schlick_transmission" : isRt ? "generalized_schlick_rt" : reflecting;
    lobe.interface = In("color0");
    arguments = {In("color0"), In("color82"), In("color90"), In("exponent")};
  }
  if (kind == "dielectric") arguments.insert(arguments.begin(), arguments.front());
  arguments.push_back(roughness);
  if (scatter != "R" && b_.facts_.isThinWalled) {
    arguments.insert(arguments.end(), {retro, film});
    if (reflecting == "generalized_schlick") arguments.push_back(e_.Boolean(false));
    return AddThinTransmission(result, reflecting, std::move(arguments), lobe, ior);
  }
  if (scatter != "T") arguments.push_back(retro);
  arguments.push_back(film);
  // Reflection inside of a body knows total reflection.
  if (scatter == "R" && reflecting == "generalized_schlick") arguments.push_back(e_.Boolean(b_.facts_.transmits));
  if (!AddLobe(result, isConductor ? reflecting : kind, arguments, lobe, true)) return false;
  if (hasFilm && isDielectric && scatter == "R") {
    std::vector<Id> plain = e_[b_.bsdfs_[result->id].expression].arguments;
    plain.back() = none;
    b_.bsdfs_[result->id].withoutFilm = e_.Make("lobe", Type::Lobe, std::move(plain), kind);
  }
  return true;
}

// Modes T and RT of a thin-walled surface. The reflecting lobe is made in any case: what it leaves is what passes.
bool NodeEvaluator::AddThinTransmission(Port* result, std::string_view reflecting, std::vector<Id> arguments, Bsdf lobe,
                                        Id ior) {
  if (!AddLobe(result, reflecting, std::move(arguments), lobe, true)) return false;
  const BsdfId top = result->id;
  const Id expression = b_.bsdfs_[top].expression;
  const Id passed = e_.Make("throughput", Type::Vec3, {expression}, std::string(reflecting));
  if (!AddLobe(result, "thin_transmission", {passed, ior, In("roughness")}, lobe, true)) return false;
  std::string scatter;
  if (!InText("scatter_mode", &scatter) || scatter == "T") return true;
  Bsdf both;
  both.kind = Bsdf::Kind::Layer;
  both.first = top;
  both.second = result->id;
  b_.bsdfs_.push_back(both);
  *result = {Type::Bsdf, Id(b_.bsdfs_.size() - 1)};
  return true;
}

bool NodeEvaluator::EvaluateCombiner(Port* result) {
  const std::string_view category = node_.definition->category;
  Bsdf node;
  if (category == "layer") {
    node.first = In("top");
    const PortDefinition* base = node_.definition->FindInput("base");
    if (base && base->type == Type::Bsdf) {
      node.kind = Bsdf::Kind::Layer;
      node.second = In("base");
    } else {
      node.kind = Bsdf::Kind::Volume;
      const Id inside = In("base");
      if (inside != kNone) node.inside = b_.vdfs_[inside];
    }
  } else if (category == "mix") {
    node.kind = Bsdf::Kind::Mix;
    node.first = In("fg");
    node.second = In("bg");
    node.factor = e_.Arithmetic("clamp", {In("mix", Type::Float), e_.Number(0), e_.Number(1)});
  } else if (category == "add") {
    node.kind = Bsdf::Kind::Add;
    node.first = In("in1");
    node.second = In("in2");
  } else {
    node.kind = Bsdf::Kind::Scale;
    node.first = In("in1");
    node.factor = e_.Arithmetic("clamp", {In("in2"), e_.Number(0), e_.Number(1)});
  }
  if (node.first == kNone && node.second == kNone) {
    *result = {Type::Bsdf, kNone};
    return true;
  }
  b_.bsdfs_.push_back(node);
  *result = {Type::Bsdf, Id(b_.bsdfs_.size() - 1)};
  return true;
}

// EDFs are the radiance towards the viewer: plain colours, so that mix, add and multiply of them are the arithmetic nodes.
bool NodeEvaluator::EvaluateEmission(Port* result) {
  const std::string_view category = node_.definition->category;
  if (category == "uniform_edf") return Number(result, In("color"));
  if (category == "measured_edf") {
    const Id texture = TextureOf("file");
    if (texture == kNone) return Number(result, In("color"));
    const Id tangent = b_.GeometricProperty("Tworld").id;
    const Id profile = e_.Make("light_profile", Type::Float, {In("normal"), tangent, texture});
    return Number(result, e_.Arithmetic("multiply", {In("color"), profile}));
  }
  if (category == "conical_edf") {
    const Id inner = In("inner_angle"), outer = In("outer_angle"), normal = In("normal");
    const Id cone = e_.Make("cone", Type::Float, {normal, inner, outer});
    return Number(result, e_.Arithmetic("multiply", {In("color"), cone}));
  }
  if (category == "generalized_schlick_edf") {
    const Id base = In("base");
    if (base == kNone || e_.Decide(base, 0)) return Number(result, e_.Color(0, 0, 0));
    const Id normal = e_.Make("normal_world", Type::Vec3, {});
    const Id exponent = In("exponent");
    const Id from = In("color0"), to = In("color90");
    const Id fresnel = e_.Make("schlick", Type::Float, {normal, exponent, e_.Number(0)});
    return Number(result, e_.Arithmetic("multiply", {base, e_.Arithmetic("mix", {from, to, fresnel})}));
  }
  return false;
}

// MaterialX's graph of standard_surface does not hand its thin_walled on to the surface.
bool NodeEvaluator::IsThinWalled() {
  const bool isStandard = node_.owner && node_.owner->category == "standard_surface";
  const Id isThin = isStandard ? OwnerIn("thin_walled") : In("thin_walled");
  return isThin != kNone && e_.Scalar(isThin) != 0;
}

Id NodeEvaluator::PresenceOf(const Surface& surface) {
  if (surface.opacity == kNone) return e_.Number(1);
  return e_.Arithmetic("clamp", {surface.opacity, e_.Number(0), e_.Number(1)});
}

// MaterialX mixes surfaces that are multiplied by their opacity already (genglsl/mx_mix_surfaceshader.glsl), so what is
// not there does not show. Ours are multiplied by the opacity of the whole: of what is there, this is the front's part.
Id NodeEvaluator::ShareOfPresent(Id factor, Id front, Id back, Id whole) {
  if (front == back) return factor;
  const Id part = e_.Arithmetic("multiply", {factor, front});
  const Id share = e_.Arithmetic("divide", {part, e_.Arithmetic("max", {whole, e_.Number(1e-20f)})});
  return e_.Arithmetic("min", {share, e_.Number(1)});
}

bool NodeEvaluator::EvaluateSurface(Port* result) {
  const std::string_view category = node_.definition->category;
  Surface surface;
  if (category == "surface") {
    surface.bsdf = In("bsdf");
    if (surface.bsdf != kNone && IsThinWalled()) {
      Bsdf wall;
      wall.kind = Bsdf::Kind::ThinWall;
      wall.first = surface.bsdf;
      b_.bsdfs_.push_back(wall);
      surface.bsdf = BsdfId(b_.bsdfs_.size() - 1);
    }
    surface.emission = In("edf");
    surface.opacity = In("opacity");
  } else if (category == "surface_unlit") {
    surface.emission = e_.Arithmetic("multiply", {In("emission_color"), In("emission")});
    surface.opacity = In("opacity");
    const Id transmission = In("transmission");
    if (transmission != kNone && !e_.Decide(transmission, 0)) {
      Bsdf through;
      through.kind = Bsdf::Kind::PassThrough;
      b_.bsdfs_.push_back(through);
      Bsdf scale;
      scale.kind = Bsdf::Kind::Scale;
      scale.first = BsdfId(b_.bsdfs_.size() - 1);
      scale.factor = e_.Arithmetic(
          "clamp", {e_.Arithmetic("multiply", {In("transmission_color"), transmission}), e_.Number(0), e_.Number(1)});
      b_.bsdfs_.push_back(scale);
      surface.bsdf = BsdfId(b_.bsdfs_.size() - 1);
    }
  } else if (category == "mix") {
    const Id fg = In("fg"), bg = In("bg");
    const Id factor = e_.Arithmetic("clamp", {In("mix", Type::Float), e_.Number(0), e_.Number(1)});
    const Surface front = fg == kNone ? Surface() : b_.surfaces_[fg], back = bg == kNone ? Surface() : b_.surfaces_[bg];
    const auto blend = [&](Id b, Id f, Id amount) {
      if (b == kNone && f == kNone) return kNone;
      const Id zero = e_.Number(0);
      return e_.Arithmetic("mix", {b == kNone ? zero : b, f == kNone ? zero : f, amount});
    };
    Id share = factor;
    if (front.opacity != kNone || back.opacity != kNone) {
      const Id foreground = PresenceOf(front), background = PresenceOf(back);
      surface.opacity = blend(background, foreground, factor);
      share = ShareOfPresent(factor, foreground, background, surface.opacity);
    }
    surface.emission = blend(back.emission, front.emission, share);
    if (front.bsdf != kNone || back.bsdf != kNone) {
      Bsdf mix;
      mix.kind = Bsdf::Kind::Mix;
      mix.first = front.bsdf;
      mix.second = back.bsdf;
      mix.factor = share;
      b_.bsdfs_.push_back(mix);
      surface.bsdf = BsdfId(b_.bsdfs_.size() - 1);
    }
  } else {
    return false;
  }
  b_.surfaces_.push_back(surface);
  *result = {Type::Surface, Id(b_.surfaces_.size() - 1)};
  return true;
}

}  // namespace materialgen
