// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/closure.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

namespace materialgen {
namespace {

constexpr LobeKind kLobes[] = {
    {"oren_nayar", "orenNayar", "OrenNayarLobe", false, true},
    {"oren_nayar_compensated", "orenNayarCompensated", "OrenNayarCompensatedLobe", false, true},
    {"burley", "burley", "BurleyLobe", false, true},
    {"translucent", "translucent", "TranslucentLobe", false, true},
    {"subsurface", "subsurface", "SubsurfaceLobe", false, true},
    {"dielectric_reflection", "dielectricReflection", "DielectricReflectionLobe"},
    {"dielectric_transmission", "dielectricTransmission", "DielectricTransmissionLobe", true},
    {"dielectric", "dielectric", "DielectricLobe", true},
    {"conductor", "conductor", "ConductorLobe", false, true},
    {"generalized_schlick", "generalizedSchlick", "GeneralizedSchlickLobe"},
    {"generalized_schlick_transmission", "generalizedSchlickTransmission", "GeneralizedSchlickTransmissionLobe", true},
    {"generalized_schlick_rt", "generalizedSchlickRt", "GeneralizedSchlickRtLobe", true},
    {"thin_transmission", "thinTransmission", "ThinTransmissionLobe", true, false, true},
    {"chiang_hair", "chiangHair", "ChiangHairLobe", false, true},
    {"sheen_conty_kulla", "sheenContyKulla", "SheenContyKullaLobe"},
    {"sheen_zeltner", "sheenZeltner", "SheenZeltnerLobe"},
};

class Lineariser {
 public:
  Lineariser(Expressions* expressions, const std::vector<Bsdf>& nodes) : e_(*expressions), nodes_(nodes) {}

  LinearClosure Run(BsdfId root) {
    LinearClosure result;
    if (root == kNone) return result;
    Prepare(root);
    weights_.assign(root + 1, {});
    weights_[root] = {e_.Number(1), e_.Number(1)};
    std::vector<BsdfId> live;
    for (BsdfId id = root + 1; id-- > 0;) {
      if (weights_[id].other == kNone) continue;
      if (nodes_[id].kind == Bsdf::Kind::Lobe || nodes_[id].kind == Bsdf::Kind::PassThrough) {
        live.push_back(id);
      } else {
        Distribute(id);
      }
    }
    std::reverse(live.begin(), live.end());
    live_.assign(root + 1, false);
    for (BsdfId id : live) AddLobe(id, &result);
    if (std::count(live_.begin(), live_.end(), true)) FindInside(&e_, nodes_, root, live_, &result);
    FuseInterfaces(&result);
    return result;
  }

 private:
  // A lobe that refracts already leaves out what its own interface reflects; so it is weighted apart from the others.
  struct Weight {
    Id other = kNone, transmitted = kNone;
  };

  Id Multiply(Id a, Id b) { return e_.Arithmetic("multiply", {a, b}); }
  Id OneMinus(Id a) { return e_.Arithmetic("subtract", {e_.Number(1), a}); }

  // What each node lets through to its base, and which interfaces refract in it; children first.
  void Prepare(BsdfId root) {
    throughput_.resize(root + 1, kNone);
    interfaces_.resize(root + 1);
    for (BsdfId id = 0; id <= root; ++id) {
      const Bsdf& node = nodes_[id];
      throughput_[id] = Throughput(node);
      if (node.kind == Bsdf::Kind::Lobe) {
        if (node.lobe->transmits && node.interface != kNone) interfaces_[id].push_back(node.interface);
        continue;
      }
      for (BsdfId child : {node.first, node.second}) {
        if (child == kNone) continue;
        for (Id ior : interfaces_[child]) {
          if (std::find(interfaces_[id].begin(), interfaces_[id].end(), ior) == interfaces_[id].end() &&
              interfaces_[id].size() < 16) {
            interfaces_[id].push_back(ior);
          }
        }
      }
    }
  }

  // Whether all of `top` reflects from one of the interfaces that refract below it. They are the same expression, or one
  // is computed from the other (glTF: reflection by a colour, refraction by the index it comes from).
  bool IsInterfaceOf(BsdfId top, const std::vector<Id>& below) {
    if (top == kNone || below.empty()) return false;
    const Bsdf& node = nodes_[top];
    if (node.kind == Bsdf::Kind::Mix) {
      return (node.first == kNone || IsInterfaceOf(node.first, below)) &&
             (node.second == kNone || IsInterfaceOf(node.second, below));
    }
    if (node.kind == Bsdf::Kind::Scale) return IsInterfaceOf(node.first, below);
    if (node.kind != Bsdf::Kind::Lobe || node.lobe->transmits || node.interface == kNone) return false;
    return std::any_of(below.begin(), below.end(), [&](Id id) { return DependsOn(node.interface, id); });
  }

  // Ids grow from arguments to results, so a walk need not go below what it looks for.
  bool DependsOn(Id expression, Id argument) {
    std::vector<Id> open = {expression};
    std::set<Id> seen;
    while (!open.empty()) {
      const Id id = open.back();
      open.pop_back();
      if (id == argument) return true;
      if (id < argument || !seen.insert(id).second) continue;
      open.insert(open.end(), e_[id].arguments.begin(), e_[id].arguments.end());
    }
    return false;
  }

  Id ThroughputOf(BsdfId id) { return id == kNone ? e_.Number(1) : throughput_[id]; }

  Id Throughput(const Bsdf& node) {
    switch (node.kind) {
      case Bsdf::Kind::Lobe: {
        if (node.lobe->opaque) return e_.Number(0);
        if (e_.Decide(node.weight, 0)) return e_.Number(1);
        Id through = e_.Make("throughput", Type::Vec3, {node.expression}, std::string(node.lobe->name));
        if (e_.IsConstant(node.weight, 1)) return through;
        return OneMinus(Multiply(node.weight, OneMinus(through)));
      }
      case Bsdf::Kind::PassThrough:
        return e_.Number(0);
      case Bsdf::Kind::Layer:
        return Multiply(ThroughputOf(node.first), ThroughputOf(node.second));
      case Bsdf::Kind::Mix:
        if (e_.Decide(node.factor, 0)) return ThroughputOf(node.second);
        if (e_.Decide(node.factor, 1)) return ThroughputOf(node.first);
        return e_.Arithmetic("mix", {ThroughputOf(node.second), ThroughputOf(node.first), node.factor});
      case Bsdf::Kind::Add: {
        const Id sum = e_.Arithmetic("add", {ThroughputOf(node.first), ThroughputOf(node.second)});
        return e_.Arithmetic("max", {e_.Arithmetic("subtract", {sum, e_.Number(1)}), e_.Number(0)});
      }
      case Bsdf::Kind::Scale:
      case Bsdf::Kind::Volume:
      case Bsdf::Kind::ThinWall:
        return ThroughputOf(node.first);
    }
    return e_.Number(1);
  }

  void Give(BsdfId child, Id other, Id transmitted) {
    if (child == kNone) return;
    if (e_.IsConstant(other, 0) && e_.IsConstant(transmitted, 0)) return;
    Weight& weight = weights_[child];
    weight.other = weight.other == kNone ? other : e_.Arithmetic("add", {weight.other, other});
    weight.transmitted =
        weight.transmitted == kNone ? transmitted : e_.Arithmetic("add", {weight.transmitted, transmitted});
  }

  void Distribute(BsdfId id) {
    const Bsdf& node = nodes_[id];
    const Weight w = weights_[id];
    switch (node.kind) {
      case Bsdf::Kind::Layer: {
        Give(node.first, w.other, w.transmitted);
        if (node.second == kNone) return;
        const Id through = ThroughputOf(node.first);
        const Bsdf* top = node.first == kNone ? nullptr : &nodes_[node.first];
        const bool sameInterface = top && IsInterfaceOf(node.first, interfaces_[node.second]);
        Id passed = sameInterface ? e_.Number(1) : through;
        if (sameInterface && top->withoutFilm != kNone) {
          // The lobe below knows the interface without the film, which reflects more or less.
          const Id plain = e_.Make("throughput", Type::Vec3, {top->withoutFilm}, std::string(top->lobe->name));
          passed = e_.Arithmetic("divide", {through, e_.Arithmetic("max", {plain, e_.Number(1e-3f)})});
        }
        Give(node.second, Multiply(w.other, through), Multiply(w.transmitted, passed));
        return;
      }
      case Bsdf::Kind::Mix: {
        if (e_.Decide(node.factor, 0)) return Give(node.second, w.other, w.transmitted);
        if (e_.Decide(node.factor, 1)) return Give(node.first, w.other, w.transmitted);
        const Id rest = OneMinus(node.factor);
        Give(node.first, Multiply(w.other, node.factor), Multiply(w.transmitted, node.factor));
        Give(node.second, Multiply(w.other, rest), Multiply(w.transmitted, rest));
        return;
      }
      case Bsdf::Kind::Add:
        Give(node.first, w.other, w.transmitted);
        Give(node.second, w.other, w.transmitted);
        return;
      case Bsdf::Kind::Scale:
        if (e_.Decide(node.factor, 0)) return;
        return Give(node.first, Multiply(w.other, node.factor), Multiply(w.transmitted, node.factor));
      case Bsdf::Kind::Volume:
      case Bsdf::Kind::ThinWall:
        return Give(node.first, w.other, w.transmitted);
      default:
        return;
    }
  }

  void AddLobe(BsdfId id, LinearClosure* result) {
    const Bsdf& node = nodes_[id];
    if (node.kind == Bsdf::Kind::PassThrough) {
      const Id passed = weights_[id].other;
      if (e_.Decide(passed, 0)) return;
      const Id before = result->passThrough;
      result->passThrough = before == kNone ? passed : e_.Arithmetic("add", {before, passed});
      return;
    }
    Id weight = Multiply(node.lobe->transmits ? weights_[id].transmitted : weights_[id].other, node.weight);
    // A tint may be 0 / 0 where the weight is 0 (glTF's sheen divides its colour by the weight). What is constant over the
    // surface is computed on the CPU, which stores 0 for it.
    const bool varies = e_[node.tint].rate == Class::Varying;
    weight = Multiply(weight, varies ? e_.Arithmetic("positive", {node.tint}) : node.tint);
    if (e_.Decide(weight, 0)) return;
    result->transmits = result->transmits || (node.lobe->transmits && !node.lobe->thin);
    result->hasSubsurface = result->hasSubsurface || node.lobe->name == "subsurface";
    live_[id] = true;
    for (WeightedLobe& lobe : result->lobes) {
      if (lobe.expression != node.expression) continue;
      lobe.weight = e_.Arithmetic("add", {lobe.weight, weight});
      return;
    }
    result->lobes.push_back({node.lobe, node.expression, weight});
  }

  // A dielectric's reflection and refraction by the same facets become one lobe that chooses by the Fresnel term.
  // Arguments: frame, tint, index, roughness, for reflection retroreflective, film.
  void FuseInterfaces(LinearClosure* result) {
    auto& lobes = result->lobes;
    for (size_t t = 0; t < lobes.size(); ++t) {
      if (lobes[t].lobe->name != "dielectric_transmission") continue;
      const std::vector<Id> below = e_[lobes[t].expression].arguments;
      for (size_t r = 0; r < lobes.size(); ++r) {
        if (lobes[r].lobe->name != "dielectric_reflection") continue;
        const std::vector<Id> above = e_[lobes[r].expression].arguments;
        const Expression& faced = e_[above[2]];
        const bool sameIndex = faced.op->name == "faced_ior" && faced.arguments[0] == below[2];
        const bool isSame = sameIndex && above[0] == below[0] && above[3] == below[3] && above[5] == below[4];
        if (!isSame || e_[above[4]].rate != Class::Literal || e_.Scalar(above[4]) != 0) continue;
        const Id reflected = e_.Convert(Multiply(above[1], lobes[r].weight), Type::Vec3);
        const Id refracted = e_.Convert(Multiply(below[1], lobes[t].weight), Type::Vec3);
        lobes[r] = {&FindLobe("dielectric"),
                    e_.Make("lobe", Type::Lobe,
                            {above[0], reflected, refracted, below[2], above[3], above[4], above[5]}, "dielectric"),
                    e_.Number(1)};
        lobes.erase(lobes.begin() + std::ptrdiff_t(t));
        --t;
        break;
      }
    }
  }

  Expressions& e_;
  const std::vector<Bsdf>& nodes_;
  std::vector<Weight> weights_;
  std::vector<Id> throughput_;
  std::vector<bool> live_;  // lobes of some weight
  std::vector<std::vector<Id>> interfaces_;
};

}  // namespace

const LobeKind& FindLobe(std::string_view name) {
  for (const LobeKind& lobe : kLobes) {
    if (lobe.name == name) return lobe;
  }
  std::fprintf(stderr, "materialgen: no lobe '%s'\n", std::string(name).c_str());
  std::abort();
}

LinearClosure Linearise(Expressions* expressions, const std::vector<Bsdf>& nodes, BsdfId root) {
  return Lineariser(expressions, nodes).Run(root);
}

}  // namespace materialgen
