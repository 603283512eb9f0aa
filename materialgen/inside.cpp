// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What lies behind a surface that transmits: one medium, one index, a wall or a body, whatever was mixed.
#include <algorithm>
#include <cmath>
#include <optional>

#include "materialgen/closure.h"

namespace materialgen {
namespace {

// Shares as numbers, to choose by: a factor that varies over the surface counts as one half.
class Numbers {
 public:
  using Value = double;
  explicit Numbers(Expressions* expressions) : e_(*expressions) {}
  Value One() { return 1; }
  Value OneMinus(Value a) { return 1 - a; }
  Value Multiply(Value a, Value b) { return a * b; }
  Value Add(Value a, Value b) { return a + b; }
  Value Of(Id id) {
    const Expression& expression = e_[id];
    if (expression.rate == Class::Varying) return 0.5;
    double sum = 0;
    const int count = Components(expression.type);
    for (int i = 0; i < count; ++i) sum += double(expression.value[size_t(i)]) / count;
    return std::isfinite(sum) ? std::clamp(sum, 0.0, 1.0) : 0;
  }

 private:
  Expressions& e_;
};

// Shares as expressions, to blend by.
class Terms {
 public:
  using Value = Id;
  explicit Terms(Expressions* expressions) : e_(*expressions) {}
  Value One() { return e_.Number(1); }
  Value OneMinus(Value a) { return e_.Arithmetic("subtract", {One(), a}); }
  Value Multiply(Value a, Value b) { return e_.Arithmetic("multiply", {a, b}); }
  Value Add(Value a, Value b) { return e_.Arithmetic("add", {a, b}); }
  Value Of(Id id) {
    if (Components(e_[id].type) == 1) return id;
    const Id third = e_.Color(1.0f / 3, 1.0f / 3, 1.0f / 3);
    return e_.Make("dotproduct", Type::Float, {e_.Convert(id, Type::Vec3), third});
  }

 private:
  Expressions& e_;
};

// How much of what arrives reaches each node, and how much of what reaches a node refracts below it into no volume of
// its own. Layers count in full: what the top takes away depends on the view, and is not a share of the body.
template <typename Algebra>
class Shares {
 public:
  using Value = typename Algebra::Value;
  Shares(Expressions* expressions, const std::vector<Bsdf>& nodes, BsdfId root, const std::vector<bool>& live)
      : a_(expressions), nodes_(nodes), share_(root + 1), walled_(root + 1), clear_(root + 1) {
    share_[root] = a_.One();
    for (BsdfId id = root + 1; id-- > 0;) {
      if (share_[id]) Distribute(id);
    }
    for (BsdfId id = 0; id <= root; ++id) {
      if (share_[id]) clear_[id] = Clear(id, live[id]);
    }
  }
  // None: nothing at all.
  std::optional<Value> Of(BsdfId id) const { return share_[id]; }
  std::optional<Value> Walled(BsdfId id) const { return walled_[id]; }  // of Of(id): through a thin wall
  std::optional<Value> Clear(BsdfId id) const { return id == kNone ? std::nullopt : clear_[id]; }
  std::optional<Value> Filled(BsdfId volume) { return Times(share_[volume], Clear(nodes_[volume].first)); }
  Value LobeWeight(BsdfId id) { return a_.Of(nodes_[id].weight); }

 private:
  using Maybe = std::optional<Value>;
  Maybe Times(Maybe a, Maybe b) { return a && b ? Maybe(a_.Multiply(*a, *b)) : std::nullopt; }
  Maybe Plus(Maybe a, Maybe b) { return a && b ? Maybe(a_.Add(*a, *b)) : a ? a : b; }

  void Give(BsdfId child, BsdfId parent, Maybe factor, bool isWall = false) {
    if (child == kNone) return;
    share_[child] = Plus(share_[child], Times(share_[parent], factor));
    walled_[child] = Plus(walled_[child], Times(isWall ? share_[parent] : walled_[parent], factor));
  }

  void Distribute(BsdfId id) {
    const Bsdf& node = nodes_[id];
    switch (node.kind) {
      case Bsdf::Kind::Mix: {
        const Value factor = a_.Of(node.factor);
        Give(node.first, id, factor);
        return Give(node.second, id, a_.OneMinus(factor));
      }
      case Bsdf::Kind::Scale: return Give(node.first, id, a_.Of(node.factor));
      case Bsdf::Kind::ThinWall: return Give(node.first, id, a_.One(), true);
      default:
        Give(node.first, id, a_.One());
        return Give(node.second, id, a_.One());
    }
  }

  Maybe Clear(BsdfId id, bool isLive) {
    const Bsdf& node = nodes_[id];
    switch (node.kind) {
      case Bsdf::Kind::Lobe:
        return isLive && node.lobe->transmits && !node.lobe->thin ? Maybe(LobeWeight(id)) : std::nullopt;
      case Bsdf::Kind::PassThrough:
      case Bsdf::Kind::Volume: return std::nullopt;
      case Bsdf::Kind::Mix: {
        const Value factor = a_.Of(node.factor);
        return Plus(Times(Clear(node.first), factor), Times(Clear(node.second), a_.OneMinus(factor)));
      }
      case Bsdf::Kind::Scale: return Times(Clear(node.first), a_.Of(node.factor));
      default: return Plus(Clear(node.first), Clear(node.second));
    }
  }

  Algebra a_;
  const std::vector<Bsdf>& nodes_;
  std::vector<Maybe> share_, walled_, clear_;
};

bool IsSame(const Vdf& a, const Vdf& b) {
  return a.absorption == b.absorption && a.scattering == b.scattering && a.anisotropy == b.anisotropy;
}

bool IsSameValue(const Expressions& e, Id a, Id b) {
  return a == b || (e.IsUniform(a) && e.IsUniform(b) && e.Scalar(a) == e.Scalar(b));
}

}  // namespace

void FindInside(Expressions* expressions, const std::vector<Bsdf>& nodes, BsdfId root, const std::vector<bool>& live,
                LinearClosure* result) {
  Expressions& e = *expressions;
  Shares<Numbers> numbers(expressions, nodes, root, live);
  double thin = 0, solid = 0, greatest = 0;
  for (BsdfId id = 0; id <= root; ++id) {
    if (!live[id] || !nodes[id].lobe || !nodes[id].lobe->transmits) continue;
    const double weight = numbers.LobeWeight(id), walled = numbers.Walled(id).value_or(0);
    const double share = numbers.Of(id).value_or(0);
    thin += weight * walled;
    solid += weight * std::max(share - walled, 0.0);
    const Id ior = nodes[id].bodyIor;
    if (ior == kNone) continue;
    if (result->bodyIor != kNone && !IsSameValue(e, result->bodyIor, ior)) result->mixesIndices = true;
    if (result->bodyIor == kNone || weight * share >= greatest) {
      result->bodyIor = ior;
      greatest = weight * share;
    }
  }
  result->isThinWalled = thin > 0 && thin >= solid;
  result->mixesWalls = thin > 0 && solid > 0;
  result->mixesIndices = result->mixesIndices && !result->isThinWalled;
  if (result->isThinWalled) return;

  std::vector<BsdfId> volumes;
  for (BsdfId id = 0; id <= root; ++id) {
    if (nodes[id].kind == Bsdf::Kind::Volume && numbers.Filled(id).value_or(0) > 0) volumes.push_back(id);
  }
  if (volumes.empty()) return;
  const Vdf first = nodes[volumes[0]].inside;
  const bool isOne = std::all_of(volumes.begin(), volumes.end(), [&](BsdfId v) { return IsSame(nodes[v].inside, first); });
  if (isOne && numbers.Clear(root).value_or(0) <= 0) {
    result->inside = first;
    return;
  }
  Shares<Terms> terms(expressions, nodes, root, live);
  Id all = terms.Clear(root).value_or(e.Number(0));
  for (BsdfId id : volumes) all = e.Arithmetic("add", {all, *terms.Filled(id)});
  all = e.Arithmetic("max", {all, e.Number(1e-20f)});
  for (BsdfId id : volumes) {
    const Id part = e.Arithmetic("divide", {*terms.Filled(id), all});
    result->inside = Sum(e, result->inside, Scaled(e, nodes[id].inside, part));
  }
}

}  // namespace materialgen
