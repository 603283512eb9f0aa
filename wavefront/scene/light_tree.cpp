// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kBins = 12;
constexpr std::size_t kDeepest = 32;        // bits of a trail
constexpr std::size_t kOrientedBelow = 4096; // nodes of more lights are split by place alone: cones cost trigonometry
// How many nodes are worth a search for their best split. Of the lights of a finely cut mesh, those of a node beyond are
// neighbours of one size and one direction: halving them is as good, and the tree of a million lights takes 1.1 s
// instead of 2.6.
constexpr std::size_t kSearched = 8192;

using Vector = std::array<double, 3>;
double Dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double Angle(const Vector& a, const Vector& b) {
  const Vector c = Cross(a, b);
  return std::atan2(std::sqrt(Dot(c, c)), Dot(a, b));
}

// What a set of lights looks like from outside. Empty: power 0.
struct Cluster {
  Vector min{1e300, 1e300, 1e300}, max{-1e300, -1e300, -1e300};
  Vector axis{0, 0, 1};
  double normals = 0, emission = 0, power = 0;
  double cosNormals = 1;  // of `normals`
  bool twoSided = false;
};

Cluster Of(const LightBounds& l) {
  Cluster c;
  for (std::size_t i = 0; i < 3; ++i) { c.min[i] = l.min[i]; c.max[i] = l.max[i]; c.axis[i] = l.axis[i]; }
  c.normals = l.normals;
  c.cosNormals = l.normals > 0 ? std::cos(c.normals) : 1;
  c.emission = l.emission;
  c.power = l.power;
  c.twoSided = l.twoSided;
  return c;
}

// The narrowest cone around two (the union of direction cones in Physically Based Rendering, 3.8.4).
void JoinCones(Cluster* a, const Cluster& b) {
  Vector axis = b.axis;
  const bool flips = b.twoSided && Dot(a->axis, axis) < 0;  // a two-sided light has no preferred side
  if (flips) axis = {-axis[0], -axis[1], -axis[2]};
  if (a->twoSided && !b.twoSided && Dot(a->axis, axis) < 0) a->axis = {-a->axis[0], -a->axis[1], -a->axis[2]};
  if (b.normals == 0 && Dot(a->axis, axis) >= a->cosNormals) return;  // most triangles; saves the angle
  const double between = Angle(a->axis, axis);
  if (std::min(between + b.normals, kPi) <= a->normals) return;
  if (std::min(between + a->normals, kPi) <= b.normals) {
    a->axis = axis;
    a->normals = b.normals;
    a->cosNormals = b.cosNormals;
    return;
  }
  const double half = 0.5 * (a->normals + between + b.normals);
  const Vector turn = Cross(a->axis, axis);
  const double length = std::sqrt(Dot(turn, turn));
  if (half >= kPi || !(length > 0)) {
    a->normals = kPi;
    a->cosNormals = -1;
    return;
  }
  const Vector k{turn[0] / length, turn[1] / length, turn[2] / length};
  const double by = half - a->normals, c = std::cos(by), s = std::sin(by);
  const Vector side = Cross(k, a->axis);  // the axis is perpendicular to k
  for (std::size_t i = 0; i < 3; ++i) a->axis[i] = c * a->axis[i] + s * side[i];
  a->normals = half;
  a->cosNormals = std::cos(half);
}

void Join(Cluster* a, const Cluster& b) {
  if (b.power == 0) return;
  if (a->power == 0) { *a = b; return; }
  for (std::size_t i = 0; i < 3; ++i) { a->min[i] = std::min(a->min[i], b.min[i]); a->max[i] = std::max(a->max[i], b.max[i]); }
  JoinCones(a, b);
  a->emission = std::max(a->emission, b.emission);
  a->power += b.power;
  a->twoSided = a->twoSided || b.twoSided;
}

// The measure of directions that a cluster may send light to (Conty Estevez and Kulla 2018, section 4.4).
double OrientationMeasure(const Cluster& c) {
  const double o = c.normals, w = std::min(o + c.emission, kPi), cosine = c.cosNormals, sine = std::sin(o);
  return 2 * kPi * (1 - cosine) + 0.5 * kPi * (2 * (w - o) * sine - std::cos(o - 2 * w) + cosine);
}
double Area(const Cluster& c) {
  const double x = c.max[0] - c.min[0], y = c.max[1] - c.min[1], z = c.max[2] - c.min[2];
  return 2 * (x * y + y * z + z * x);
}
double Cost(const Cluster& c, double flat, bool oriented) {
  return c.power == 0 ? 0 : c.power * std::max(Area(c), flat) * (oriented ? OrientationMeasure(c) : 1);
}

uint32_t Fixed16(double unit) { return static_cast<uint32_t>(std::clamp(unit, 0.0, 1.0) * 65535.0); }
// Octahedral map, as two signed 16-bit fractions (GLSL: unpackSnorm2x16).
uint32_t PackAxis(const Vector& v) {
  const double sum = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
  double x = v[0] / sum, y = v[1] / sum;
  if (v[2] < 0) {
    const double ox = (1 - std::abs(y)) * (x < 0 ? -1 : 1), oy = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
    x = ox;
    y = oy;
  }
  const auto fraction = [](double f) { return static_cast<uint32_t>(static_cast<uint16_t>(static_cast<int16_t>(std::lround(f * 32767)))); };
  return fraction(x) | fraction(y) << 16;
}

class Builder {
 public:
  explicit Builder(std::span<const LightBounds> lights) : lights_(lights), order_(lights.size()) {
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<uint32_t>(i);
    tree_.trails.assign(lights.size(), 0u);
    tree_.nodes.reserve((2 * lights.size() - 1) * 4 * layout::kLightNodeTexels);
  }

  LightTree Build() {
    tree_.nodes.resize(4 * layout::kLightNodeTexels);
    Node(0, 0, order_.size(), 0, 0);
    return std::move(tree_);
  }

 private:
  double Centre(uint32_t light, std::size_t axis) const { return 0.5 * (double(lights_[light].min[axis]) + lights_[light].max[axis]); }

  void Write(uint32_t node, const Cluster& c, uint32_t reference) {
    Vector d;
    for (std::size_t i = 0; i < 3; ++i) d[i] = c.max[i] - c.min[i];
    uint32_t* w = &tree_.nodes[std::size_t{node} * 4 * layout::kLightNodeTexels];
    for (std::size_t i = 0; i < 3; ++i) w[i] = std::bit_cast<uint32_t>(static_cast<float>(0.5 * (c.min[i] + c.max[i])));
    w[3] = std::bit_cast<uint32_t>(static_cast<float>(0.5 * std::sqrt(Dot(d, d)) * (1 + 1e-6)));
    w[4] = PackAxis(c.axis);
    // Rounded towards wider cones.
    w[5] = Fixed16(0.5 + 0.5 * c.cosNormals) | Fixed16(0.5 + 0.5 * std::cos(c.emission)) << 16;
    w[6] = std::bit_cast<uint32_t>(static_cast<float>(c.power));
    w[7] = reference | (c.twoSided ? layout::kLightNodeTwoSided : 0u);
  }

  Cluster Node(uint32_t node, std::size_t first, std::size_t last, std::size_t depth, uint32_t trail) {
    if (last - first == 1) {
      const uint32_t light = order_[first];
      tree_.trails[light] = trail;
      const Cluster c = Of(lights_[light]);
      Write(node, c, layout::kLightNodeLeaf | lights_[light].item);
      return c;
    }
    const std::size_t middle = Split(first, last, depth);
    const uint32_t child = static_cast<uint32_t>(tree_.nodes.size() / (4 * layout::kLightNodeTexels));
    tree_.nodes.resize(tree_.nodes.size() + 8 * layout::kLightNodeTexels);
    Cluster c = Node(child, first, middle, depth + 1, trail);
    Join(&c, Node(child + 1, middle, last, depth + 1, trail | 1u << depth));
    Write(node, c, child);
    return c;
  }

  // Reorders [first, last) and says where the second child starts.
  std::size_t Split(std::size_t first, std::size_t last, std::size_t depth) {
    const std::size_t count = last - first;
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first), end = order_.begin() + static_cast<std::ptrdiff_t>(last);
    Vector low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (auto i = begin; i != end; ++i) {
      for (std::size_t a = 0; a < 3; ++a) { low[a] = std::min(low[a], Centre(*i, a)); high[a] = std::max(high[a], Centre(*i, a)); }
    }
    std::size_t longest = 0;
    for (std::size_t a = 1; a < 3; ++a) if (high[a] - low[a] > high[longest] - low[longest]) longest = a;
    // From here on only halving keeps every trail within its bits.
    const std::size_t levels = static_cast<std::size_t>(std::bit_width(count - 1));
    const bool halve = depth + levels >= kDeepest || !(high[longest] > low[longest]) || count == 2 || count * kSearched <= order_.size();

    double best = std::numeric_limits<double>::infinity();
    std::size_t bestAxis = longest;
    int bestBin = -1;
    const double extent = high[longest] - low[longest];
    for (std::size_t a = 0; a < 3 && !halve; ++a) {
      if (!(high[a] > low[a]) || (count > kOrientedBelow && a != longest)) continue;
      const bool oriented = count <= kOrientedBelow;
      std::array<Cluster, kBins> bins;
      for (auto i = begin; i != end; ++i) Join(&bins[Bin(*i, a, low[a], high[a])], Light(*i, oriented));
      // Thin clusters are not free: their lights still have to be told apart.
      const double flat = 1e-6 * extent * extent;
      std::array<double, kBins> above{};
      Cluster sum;
      double right = 0;
      for (std::size_t b = kBins - 1; b > 0; --b) {
        if (bins[b].power > 0) { Join(&sum, bins[b]); right = Cost(sum, flat, oriented); }
        above[b] = right;
      }
      sum = {};
      for (int b = 0; b + 1 < kBins; ++b) {
        const Cluster& bin = bins[static_cast<std::size_t>(b)];
        if (bin.power == 0) continue;  // the same two sides as one bin before
        Join(&sum, bin);
        right = above[static_cast<std::size_t>(b) + 1];
        if (right == 0) continue;
        // Long boxes are not to be cut into longer ones.
        const double cost = extent / (high[a] - low[a]) * (Cost(sum, flat, oriented) + right);
        if (cost < best) { best = cost; bestAxis = a; bestBin = b; }
      }
    }
    if (bestBin >= 0) {
      const auto cut = std::stable_partition(begin, end, [&](uint32_t l) { return static_cast<int>(Bin(l, bestAxis, low[bestAxis], high[bestAxis])) <= bestBin; });
      if (cut != begin && cut != end) return first + static_cast<std::size_t>(cut - begin);
    }
    const auto half = begin + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(begin, half, end, [&](uint32_t x, uint32_t y) {
      const double cx = Centre(x, longest), cy = Centre(y, longest);
      return cx != cy ? cx < cy : x < y;
    });
    return first + count / 2;
  }

  Cluster Light(uint32_t light, bool oriented) const {
    Cluster c = Of(lights_[light]);
    if (!oriented) { c.axis = {0, 0, 1}; c.normals = kPi; c.cosNormals = -1; }  // then joining cones costs nothing
    return c;
  }
  std::size_t Bin(uint32_t light, std::size_t axis, double low, double high) const {
    const double at = (Centre(light, axis) - low) / (high - low) * kBins;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(at), 0, kBins - 1));
  }

  std::span<const LightBounds> lights_;
  std::vector<uint32_t> order_;
  LightTree tree_;
};

}  // namespace

LightTree BuildLightTree(std::span<const LightBounds> lights) { return Builder(lights).Build(); }

}  // namespace wavefront
