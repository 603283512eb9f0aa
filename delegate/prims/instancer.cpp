// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/prims/instancer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <unordered_set>

#include "delegate/prims/matrix.h"
#include "wavefront/base/parallel.h"

namespace delegate {
namespace {

using wavefront::Diagnostic;
using wavefront::Float3;
using wavefront::Float4;
using wavefront::PrimvarData;
using wavefront::Severity;

constexpr size_t kBlock = 16384;  // instances that one step of a parallel loop composes

void ForBlocks(size_t count, unsigned threads, const std::function<void(size_t, size_t)>& fn) {
  const size_t blocks = (count + kBlock - 1) / kBlock;
  wavefront::ParallelFor(blocks, blocks < 2 ? 1 : threads,
                         [&](size_t b) { fn(b * kBlock, std::min(count, (b + 1) * kBlock)); });
}

// Times at which any of the arrays has a value, in order.
void AddTimes(std::set<float>& times, const auto& samples) {
  for (const auto& sample : samples) times.insert(sample.time);
}

// The samples around a time, and how far in between. Both are the same outside and at a sample.
struct Bracket {
  size_t before = 0, after = 0;
  double fraction = 0;
};

template <typename T>
Bracket FindBracket(const TimeSamples<T>& samples, float time) {
  size_t after = 0;
  while (after < samples.size() && samples[after].time < time) ++after;
  if (after == samples.size()) return {samples.size() - 1, samples.size() - 1, 0};
  if (after == 0 || samples[after].time == time) return {after, after, 0};
  const double span = double{samples[after].time} - samples[after - 1].time;
  return {after - 1, after, (double{time} - samples[after - 1].time) / span};
}

// Element i of an array of arrays at a time; the arrays are at least i + 1 long (see Count).
Float3 At(const TimeSamples<std::vector<Float3>>& samples, const Bracket& at, size_t i) {
  const Float3 a = samples[at.before].value[i];
  if (at.fraction == 0) return a;
  const Float3 b = samples[at.after].value[i];
  const auto t = static_cast<float>(at.fraction);
  return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}

struct Quaternion {
  double x, y, z, w;
};

// Zero and not finite quaternions turn nothing.
Quaternion Normalized(const Float4& q) {
  const double x = q.x, y = q.y, z = q.z, w = q.w, length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 0, 1};
  return {x / length, y / length, z / length, w / length};
}

// Spherical interpolation along the shorter arc.
Quaternion At(const TimeSamples<std::vector<Float4>>& samples, const Bracket& at, size_t i) {
  const Quaternion a = Normalized(samples[at.before].value[i]);
  if (at.fraction == 0) return a;
  Quaternion b = Normalized(samples[at.after].value[i]);
  double cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
  if (cosine < 0) {
    b = {-b.x, -b.y, -b.z, -b.w};
    cosine = -cosine;
  }
  double wa = 1 - at.fraction, wb = at.fraction;
  if (cosine < 0.9999999) {
    const double angle = std::acos(cosine), sine = std::sin(angle);
    wa = std::sin(wa * angle) / sine;
    wb = std::sin(wb * angle) / sine;
  }
  const Quaternion q{wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z, wa * a.w + wb * b.w};
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {q.x / length, q.y / length, q.z / length, q.w / length};
}

// scale, then rotate, then translate (UsdGeomPointInstancer::ComputeInstanceTransformsAtTime), row vectors.
Matrix4d ScaleRotateTranslate(const Float3& s, const Quaternion& q, const Float3& p) {
  Matrix4d m;
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  m.m[0] = {s.x * (1 - 2 * (yy + zz)), s.x * 2 * (xy + wz), s.x * 2 * (xz - wy), 0};
  m.m[1] = {s.y * 2 * (xy - wz), s.y * (1 - 2 * (xx + zz)), s.y * 2 * (yz + wx), 0};
  m.m[2] = {s.z * 2 * (xz + wy), s.z * 2 * (yz - wx), s.z * (1 - 2 * (xx + yy)), 0};
  m.m[3] = {p.x, p.y, p.z, 1};
  return m;
}

bool Has(const auto& samples) { return !samples.empty() && !samples.front().value.empty(); }

// How many instances an instancer has: the shortest of its arrays. Disagreement is reported.
size_t Count(const InstancerState& s, const wavefront::DiagnosticSink& sink) {
  size_t shortest = std::numeric_limits<size_t>::max(), longest = 0;
  const auto see = [&](size_t n) {
    shortest = std::min(shortest, n);
    longest = std::max(longest, n);
  };
  const auto seeAll = [&](const auto& samples) {
    for (const auto& sample : samples)
      if (!sample.value.empty() || samples.size() > 1) see(sample.value.size());
  };
  seeAll(s.transforms);
  seeAll(s.positions);
  seeAll(s.orientations);
  seeAll(s.scales);
  if (!s.protoIndices.empty()) see(s.protoIndices.size());
  if (longest == 0) return 0;
  if (!Has(s.transforms) && !Has(s.positions)) {
    sink({Severity::Warning, "instancer-no-positions", s.path, "The instancer has no positions; nothing is drawn."});
    return 0;
  }
  if (shortest != longest)
    sink({Severity::Warning, "instancer-array-lengths", s.path,
          "The instancer's arrays have between " + std::to_string(shortest) + " and " + std::to_string(longest) +
              " elements; the first " + std::to_string(shortest) + " instances are drawn."});
  if (!s.ids.empty() && s.ids.size() < shortest)
    sink({Severity::Warning, "instancer-array-lengths", s.path,
          "The instancer has fewer ids than instances; the rest go by their index."});
  return shortest;
}

// Indices of the instances that draw this prototype, in rising order.
std::vector<int32_t> Selected(const InstancerState& s, int32_t prototype, size_t count,
                              const wavefront::DiagnosticSink& sink) {
  if (!s.prototypeInstances.empty()) {
    const auto found = s.prototypeInstances.find(prototype);
    if (found == s.prototypeInstances.end()) return {};
    std::vector<int32_t> drawn = found->second;
    std::sort(drawn.begin(), drawn.end());
    if (std::erase_if(drawn, [&](int32_t i) { return i < 0 || static_cast<size_t>(i) >= count; }))
      sink({Severity::Warning, "instancer-bad-index", s.path,
            "The instancer names instances outside of its " + std::to_string(count) + "; they are not drawn."});
    return drawn;
  }
  const std::unordered_set<int64_t> hidden(s.invisibleIds.begin(), s.invisibleIds.end());
  std::vector<int32_t> selected;
  for (size_t i = 0; i < count; ++i) {
    if (!s.protoIndices.empty() && s.protoIndices[i] != prototype) continue;
    const int64_t id = i < s.ids.size() ? s.ids[i] : static_cast<int64_t>(i);
    if (!hidden.empty() && hidden.count(id)) continue;
    selected.push_back(static_cast<int32_t>(i));
  }
  return selected;
}

// Matrices of the selected instances at a time, in the instancer's parent space.
std::vector<Matrix4d> MatricesAt(const InstancerState& s, const std::vector<int32_t>& selected, float time,
                                 unsigned threads) {
  const Bracket ownAt = FindBracket(s.transform, time);
  const Matrix4d own = Lerp(s.transform[ownAt.before].value, s.transform[ownAt.after].value, ownAt.fraction);
  std::vector<Matrix4d> matrices(selected.size());
  if (Has(s.transforms)) {
    const Bracket at = FindBracket(s.transforms, time);
    ForBlocks(selected.size(), threads, [&](size_t begin, size_t end) {
      for (size_t k = begin; k < end; ++k) {
        const auto i = static_cast<size_t>(selected[k]);
        const Matrix4d& before = s.transforms[at.before].value[i];
        matrices[k] = Multiply(
            at.fraction == 0 ? before : Lerp(before, s.transforms[at.after].value[i], at.fraction), own);
      }
    });
    return matrices;
  }
  const bool hasPositions = Has(s.positions), hasOrientations = Has(s.orientations), hasScales = Has(s.scales);
  const Bracket positionsAt = hasPositions ? FindBracket(s.positions, time) : Bracket();
  const Bracket orientationsAt = hasOrientations ? FindBracket(s.orientations, time) : Bracket();
  const Bracket scalesAt = hasScales ? FindBracket(s.scales, time) : Bracket();
  ForBlocks(selected.size(), threads, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const auto i = static_cast<size_t>(selected[k]);
      const Float3 p = hasPositions ? At(s.positions, positionsAt, i) : Float3{0, 0, 0};
      const Quaternion q = hasOrientations ? At(s.orientations, orientationsAt, i) : Quaternion{0, 0, 0, 1};
      const Float3 scale = hasScales ? At(s.scales, scalesAt, i) : Float3{1, 1, 1};
      matrices[k] = Multiply(ScaleRotateTranslate(scale, q, p), own);
    }
  });
  return matrices;
}

// Elements of a primvar for the flattened instances: element(k) is the instance's index in this instancer.
std::optional<PrimvarData> Flatten(const InstancerState& s, const PrimvarInput& primvar, size_t count, size_t flatCount,
                                   const std::function<size_t(size_t)>& element,
                                   const wavefront::DiagnosticSink& sink) {
  const auto drop = [&](const std::string& why) {
    sink({Severity::Warning, "primvar-bad-size", s.path,
          "Primvar \"" + primvar.name + "\" of the instancer " + why + " and is left out."});
    return std::nullopt;
  };
  const uint32_t components = primvar.components;
  if (components == 0 || primvar.values.size() % components != 0) return drop("has a broken element size");
  const size_t elements = primvar.values.size() / components;
  const bool constant = primvar.interpolation == "constant";
  const size_t needed = constant ? 1 : count;
  const size_t entries = primvar.indices.empty() ? elements : primvar.indices.size();
  if (entries < needed || elements == 0) return drop("has too few elements");
  for (size_t i = 0; i < needed && !primvar.indices.empty(); ++i)
    if (primvar.indices[i] < 0 || static_cast<size_t>(primvar.indices[i]) >= elements)
      return drop("has an index out of range");
  for (float v : primvar.values)
    if (!std::isfinite(v)) return drop("holds a value that is not finite");
  PrimvarData data;
  data.name = primvar.name;
  data.interpolation = constant ? wavefront::Interpolation::Constant : wavefront::Interpolation::Instance;
  data.components = components;
  const size_t outputs = constant ? 1 : flatCount;
  data.values.resize(outputs * components);
  for (size_t k = 0; k < outputs; ++k) {
    size_t i = constant ? 0 : element(k);
    if (!primvar.indices.empty()) i = static_cast<size_t>(primvar.indices[i]);
    std::copy_n(&primvar.values[i * components], components, &data.values[k * components]);
  }
  return data;
}

// What the instanceId AOV calls the selected instances of one level: indices in the instancer, or places in the host's
// list of the prototype's instances.
struct Names {
  std::vector<int32_t> of;
  size_t length = 0;  // of what is counted in
};
Names NamesOf(const InstancerState& s, int32_t prototype, size_t count, const std::vector<int32_t>& selected) {
  if (s.prototypeInstances.empty()) return {selected, count};
  const std::vector<int32_t>& told = s.prototypeInstances.at(prototype);
  Names names{{}, told.size()};
  if (told == selected) {  // in order, as hosts have it
    names.of.resize(told.size());
    std::iota(names.of.begin(), names.of.end(), 0);
    return names;
  }
  std::map<int32_t, int32_t> places;
  for (size_t i = 0; i < told.size(); ++i) places.try_emplace(told[i], static_cast<int32_t>(i));
  for (const int32_t index : selected) names.of.push_back(places.at(index));
  return names;
}

// Leaves out the instances whose matrix is not finite at some time.
void DropBroken(FlatInstances& flat, const std::string& path, const wavefront::DiagnosticSink& sink) {
  const size_t count = flat.indices.size();
  std::vector<uint8_t> broken(count, 0);
  size_t brokenCount = 0, first = 0;
  for (size_t k = count; k-- > 0;)
    for (const auto& sample : flat.transforms)
      if (!broken[k] && !IsFinite(sample.value[k])) {
        broken[k] = 1;
        ++brokenCount;
        first = k;
      }
  if (brokenCount == 0) return;
  sink({Severity::Warning, "instancer-bad-transform", path,
        std::to_string(brokenCount) + " instances have a transform that is not finite (the first is instance " +
            std::to_string(flat.indices[first]) + ") and are not drawn."});
  const auto compact = [&](auto& values, size_t stride) {
    size_t to = 0;
    for (size_t k = 0; k < count; ++k)
      if (!broken[k]) {
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(k * stride), stride,
                    values.begin() + static_cast<std::ptrdiff_t>(to * stride));
        ++to;
      }
    values.resize(to * stride);
  };
  compact(flat.indices, 1);
  for (auto& sample : flat.transforms) compact(sample.value, 1);
  for (PrimvarData& primvar : flat.primvars)
    if (primvar.interpolation == wavefront::Interpolation::Instance) compact(primvar.values, primvar.components);
}

}  // namespace

FlatInstances ComposeInstances(const std::vector<const InstancerState*>& chain, const std::vector<int32_t>& prototypes,
                               unsigned threads, const wavefront::DiagnosticSink& sink) {
  FlatInstances flat;
  const size_t levels = chain.size();
  std::vector<std::vector<int32_t>> selected(levels);
  std::vector<size_t> counts(levels), strides(levels);
  std::set<float> times;
  uint64_t total = 1;
  for (size_t level = 0; level < levels; ++level) {
    const InstancerState& s = *chain[level];
    if (!s.visible) return flat;
    counts[level] = Count(s, sink);
    selected[level] = Selected(s, prototypes[level], counts[level], sink);
    total *= selected[level].size();
    if (total == 0) return flat;
    if (total > 0x7fffffffu) {
      sink({Severity::Error, "instancer-too-many", chain[0]->path, "More than 2^31 instances; none is drawn."});
      return flat;
    }
    AddTimes(times, s.transforms);
    AddTimes(times, s.positions);
    AddTimes(times, s.orientations);
    AddTimes(times, s.scales);
    AddTimes(times, s.transform);
  }
  // A still array has an arbitrary time of its own: times count only where something moves.
  bool moves = false;
  for (const InstancerState* s : chain)
    moves |= s->transforms.size() > 1 || s->positions.size() > 1 || s->orientations.size() > 1 ||
             s->scales.size() > 1 || s->transform.size() > 1;
  if (!moves) times = {0.0f};

  const auto count = static_cast<size_t>(total);
  // Flat index k = outer * inner count + inner: the index in level n is (k / stride) % selected count.
  size_t stride = 1;
  for (size_t level = 0; level < levels; ++level) {
    strides[level] = stride;
    stride *= selected[level].size();
  }
  std::vector<Names> names;
  for (size_t level = 0; level < levels; ++level)
    names.push_back(NamesOf(*chain[level], prototypes[level], counts[level], selected[level]));
  const auto indexIn = [&](size_t level, size_t k) {
    return static_cast<size_t>(selected[level][k / strides[level] % selected[level].size()]);
  };
  flat.indices.resize(count);
  for (size_t k = 0; k < count; ++k) {
    int64_t index = 0, place = 1;
    for (size_t level = 0; level < levels; ++level) {
      index += place * names[level].of[k / strides[level] % selected[level].size()];
      place *= static_cast<int64_t>(names[level].length);
    }
    flat.indices[k] = static_cast<int32_t>(index & 0x7fffffff);
  }

  for (float time : times) {
    std::vector<Matrix4d> matrices = MatricesAt(*chain[0], selected[0], time, threads);
    for (size_t level = 1; level < levels; ++level) {
      const std::vector<Matrix4d> outer = MatricesAt(*chain[level], selected[level], time, threads);
      const size_t inner = matrices.size();
      std::vector<Matrix4d> product(inner * outer.size());
      ForBlocks(product.size(), threads, [&](size_t begin, size_t end) {
        for (size_t k = begin; k < end; ++k) product[k] = Multiply(matrices[k % inner], outer[k / inner]);
      });
      matrices = std::move(product);
    }
    flat.transforms.push_back({time, std::move(matrices)});
  }

  std::set<std::string> taken;  // the innermost instancer's primvars win
  for (size_t level = 0; level < levels; ++level)
    for (const PrimvarInput& primvar : chain[level]->primvars)
      if (taken.insert(primvar.name).second)
        if (auto data = Flatten(*chain[level], primvar, counts[level], count,
                                [&](size_t k) { return indexIn(level, k); }, sink))
          flat.primvars.push_back(std::move(*data));
  DropBroken(flat, chain[0]->path, sink);
  return flat;
}

}  // namespace delegate
