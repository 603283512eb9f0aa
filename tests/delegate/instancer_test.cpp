// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Instance composition against plain double arithmetic, point by point.
#include "delegate/prims/instancer.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "delegate/instancer_store.h"
#include "tests/delegate/fakes.h"

namespace {

using delegate::ComposeInstances;
using delegate::FlatInstances;
using delegate::InstancerState;
using wavefront::Float3;
using wavefront::Float4;
using wavefront::Matrix4d;
using Point = std::array<double, 3>;

Point Transform(const Point& p, const Matrix4d& m) {
  Point out{};
  for (int j = 0; j < 3; ++j) out[j] = p[0] * m.m[0][j] + p[1] * m.m[1][j] + p[2] * m.m[2][j] + m.m[3][j];
  return out;
}

// The definition: v' = v + 2 q x (q x v + w v) for a unit quaternion.
Point Rotate(const Point& v, const Float4& f) {
  const double n = std::sqrt(double{f.x} * f.x + double{f.y} * f.y + double{f.z} * f.z + double{f.w} * f.w);
  const Point q{f.x / n, f.y / n, f.z / n};
  const double w = f.w / n;
  const auto cross = [](const Point& a, const Point& b) {
    return Point{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  Point inner = cross(q, v);
  for (int i = 0; i < 3; ++i) inner[i] += w * v[i];
  const Point outer = cross(q, inner);
  return {v[0] + 2 * outer[0], v[1] + 2 * outer[1], v[2] + 2 * outer[2]};
}

struct Random {
  std::mt19937 engine{7};
  float operator()(float low = -2, float high = 2) { return std::uniform_real_distribution<float>(low, high)(engine); }
  Matrix4d Affine() {
    Matrix4d m;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 3; ++j) m.m[i][j] = (*this)();
    return m;
  }
};

InstancerState RandomPoints(const std::string& path, size_t count, Random& random) {
  InstancerState s;
  s.path = path;
  s.positions = {{0, {}}};
  s.orientations = {{0, {}}};
  s.scales = {{0, {}}};
  for (size_t i = 0; i < count; ++i) {
    s.positions[0].value.push_back({random(-1e3f, 1e3f), random(), random()});
    s.orientations[0].value.push_back({random(), random(), random(), random()});
    s.scales[0].value.push_back({random(0.1f, 2), random(0.1f, 2), random(0.1f, 2)});
    s.protoIndices.push_back(static_cast<int32_t>(i % 3));
  }
  s.transform[0].value = random.Affine();
  return s;
}

// What USD says an instance does to a point, without matrices but the instancer's own.
Point Place(const InstancerState& s, size_t i, Point p) {
  const Float3 scale = s.scales[0].value[i], position = s.positions[0].value[i];
  p = Rotate({p[0] * scale.x, p[1] * scale.y, p[2] * scale.z}, s.orientations[0].value[i]);
  return Transform({p[0] + position.x, p[1] + position.y, p[2] + position.z}, s.transform[0].value);
}

wavefront::DiagnosticSink Sink(std::vector<wavefront::Diagnostic>& all) {
  return [&all](const wavefront::Diagnostic& d) { all.push_back(d); };
}

TEST(Instancer, PointInstancesScaleRotateTranslate) {
  Random random;
  const InstancerState s = RandomPoints("/points", 90, random);
  std::vector<wavefront::Diagnostic> told;
  const FlatInstances flat = ComposeInstances({&s}, {1}, 2, Sink(told));
  ASSERT_EQ(flat.indices.size(), 30u);
  ASSERT_EQ(flat.transforms.size(), 1u);
  const Point p{0.3, -0.7, 1.1};
  for (size_t k = 0; k < 30; ++k) {
    EXPECT_EQ(flat.indices[k], static_cast<int32_t>(3 * k + 1));
    const Point expected = Place(s, 3 * k + 1, p), got = Transform(p, flat.transforms[0].value[k]);
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(got[j], expected[j], 1e-11 * 4e3);
  }
  EXPECT_TRUE(told.empty());
}

TEST(Instancer, NestedInstancesGoThroughEveryLevel) {
  Random random;
  const InstancerState inner = RandomPoints("/inner", 6, random), outer = RandomPoints("/outer", 9, random);
  std::vector<wavefront::Diagnostic> told;
  const FlatInstances flat = ComposeInstances({&inner, &outer}, {0, 2}, 2, Sink(told));
  ASSERT_EQ(flat.indices.size(), 2u * 3u);
  const Point p{0.3, -0.7, 1.1};
  for (size_t o = 0; o < 3; ++o)
    for (size_t i = 0; i < 2; ++i) {
      const size_t innerIndex = 3 * i, outerIndex = 3 * o + 2, k = o * 2 + i;
      EXPECT_EQ(flat.indices[k], static_cast<int32_t>(innerIndex + 6 * outerIndex));
      const Point expected = Place(outer, outerIndex, Place(inner, innerIndex, p));
      const Point got = Transform(p, flat.transforms[0].value[k]);
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(got[j], expected[j], 1e-11 * 1e4);
    }
}

TEST(Instancer, NativeInstancesTakeTheirMatrices) {
  Random random;
  InstancerState s;
  s.path = "/native";
  s.transforms = {{0, {random.Affine(), random.Affine(), random.Affine()}}};
  std::vector<wavefront::Diagnostic> told;
  const FlatInstances flat = ComposeInstances({&s}, {0}, 1, Sink(told));
  ASSERT_EQ(flat.transforms[0].value.size(), 3u);  // no protoIndices: every prototype at every instance
  const Matrix4d prim = random.Affine();
  const auto transforms = delegate::InstanceTransforms({{0, prim}}, flat, 1);
  const Point p{1, 2, 3};
  for (size_t k = 0; k < 3; ++k) {
    const Point expected = Transform(Transform(p, prim), s.transforms[0].value[k]);
    const Point got = Transform(p, transforms[k][0].value);
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(got[j], expected[j], 1e-12 * 100);
  }
}

TEST(Instancer, HiddenIdsAreLeftOutAndTheRestKeepTheirIndex) {
  Random random;
  InstancerState s = RandomPoints("/points", 6, random);
  s.protoIndices.clear();
  s.ids = {10, 11, 12, 13, 14, 15};
  s.invisibleIds = {11, 14, 99};
  std::vector<wavefront::Diagnostic> told;
  EXPECT_EQ(ComposeInstances({&s}, {0}, 1, Sink(told)).indices, (std::vector<int32_t>{0, 2, 3, 5}));
  s.visible = false;
  EXPECT_TRUE(ComposeInstances({&s}, {0}, 1, Sink(told)).indices.empty());
}

TEST(Instancer, PrimvarsOfTheInnerInstancerWin) {
  Random random;
  InstancerState inner = RandomPoints("/inner", 2, random), outer = RandomPoints("/outer", 3, random);
  inner.protoIndices.clear();
  outer.protoIndices.clear();
  inner.primvars = {{"a", "instance", 1, {1, 2}, {}}, {"c", "constant", 2, {7, 8}, {}}};
  outer.primvars = {{"a", "instance", 1, {9, 9, 9}, {}}, {"b", "instance", 1, {5, 6}, {1, 0, 1}}};
  std::vector<wavefront::Diagnostic> told;
  const FlatInstances flat = ComposeInstances({&inner, &outer}, {0, 0}, 1, Sink(told));
  ASSERT_EQ(flat.primvars.size(), 3u);
  EXPECT_EQ(flat.primvars[0].values, (std::vector<float>{1, 2, 1, 2, 1, 2}));
  EXPECT_EQ(flat.primvars[1].values, (std::vector<float>{7, 8}));
  EXPECT_EQ(flat.primvars[1].interpolation, wavefront::Interpolation::Constant);
  EXPECT_EQ(flat.primvars[2].values, (std::vector<float>{6, 6, 5, 5, 6, 6}));
  EXPECT_TRUE(told.empty());
}

TEST(Instancer, BrokenInputIsLeftOutAndSaid) {
  Random random;
  InstancerState s = RandomPoints("/points", 6, random);
  s.protoIndices.clear();
  s.positions[0].value[2].y = std::numeric_limits<float>::quiet_NaN();
  s.scales[0].value.resize(5);
  s.primvars = {{"few", "instance", 1, {1, 2}, {}},
                {"index", "instance", 1, {1, 2}, {0, 0, 0, 0, 7}},
                {"good", "instance", 1, {0, 1, 2, 3, 4}, {}}};
  std::vector<wavefront::Diagnostic> told;
  const FlatInstances flat = ComposeInstances({&s}, {0}, 1, Sink(told));
  EXPECT_EQ(flat.indices, (std::vector<int32_t>{0, 1, 3, 4}));
  ASSERT_EQ(flat.primvars.size(), 1u);
  EXPECT_EQ(flat.primvars[0].values, (std::vector<float>{0, 1, 3, 4}));
  std::multiset<std::string> codes;
  for (const auto& d : told) codes.insert(d.code);
  EXPECT_EQ(codes, (std::multiset<std::string>{"instancer-array-lengths", "instancer-bad-transform", "primvar-bad-size",
                                               "primvar-bad-size"}));
  InstancerState nowhere;
  nowhere.path = "/nowhere";
  nowhere.protoIndices = {0, 0};
  told.clear();
  EXPECT_TRUE(ComposeInstances({&nowhere}, {0}, 1, Sink(told)).indices.empty());
  EXPECT_EQ(told.size(), 1u);
}

TEST(Instancer, MovingArraysMeetAtTheUnionOfTheirTimes) {
  InstancerState s;
  s.path = "/moving";
  s.positions = {{0, {{0, 0, 0}}}, {1, {{10, 0, 0}}}};
  s.transform = {{0.5f, delegate_test::Translation(0, 1, 0)}};
  s.orientations = {{0, {{0, 0, 0, 1}}}, {0.5f, {{0, 0, 0.70710678f, 0.70710678f}}}, {1, {{0, 0, 1, 0}}}};
  std::vector<wavefront::Diagnostic> told;
  const FlatInstances flat = ComposeInstances({&s}, {0}, 1, Sink(told));
  ASSERT_EQ(flat.transforms.size(), 3u);
  EXPECT_FLOAT_EQ(flat.transforms[1].time, 0.5f);
  const Point middle = Transform({1, 0, 0}, flat.transforms[1].value[0]);  // a quarter turn about z, half way along x
  EXPECT_NEAR(middle[0], 5, 1e-6);
  EXPECT_NEAR(middle[1], 2, 1e-6);
}

TEST(Instancer, CyclesAndMissingParentsDrawNothing) {
  std::vector<wavefront::Diagnostic> told;
  delegate::InstancerStore store(Sink(told), 1);
  delegate::InstancerUpdate update;
  update.transforms = {{0, {Matrix4d()}}};
  update.parent = "/b";
  store.Sync("/a", update);
  EXPECT_TRUE(store.Flatten("/a", 0)->indices.empty());
  store.Forget();
  update.parent = "/a";
  store.Sync("/b", update);
  store.Signature("/a", 0);  // ends
  EXPECT_TRUE(store.Flatten("/a", 0)->indices.empty());
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0].code, "instancer-missing");
  EXPECT_EQ(told[1].code, "instancer-cycle");
}

TEST(Instancer, AMillionInstances) {
  Random random;
  const InstancerState s = RandomPoints("/points", 1'000'000, random);
  std::vector<wavefront::Diagnostic> told;
  const auto start = std::chrono::steady_clock::now();
  const auto since = [&] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  const FlatInstances flat = ComposeInstances({&s}, {0}, 0, Sink(told));
  const double composed = since();
  const auto transforms = delegate::InstanceTransforms({{0, Matrix4d()}}, flat, 0);
  std::printf("1e6 point instances, one of three prototypes: composed in %.0f ms, the core's transforms in %.0f ms\n",
              composed, since() - composed);
  EXPECT_EQ(transforms.size(), 333'334u);
}

}  // namespace
