// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Linearised closures, by hand-made trees: what no network reaches alone.
#include "materialgen/closure.h"

#include <gtest/gtest.h>

namespace materialgen {
namespace {

class ClosureTree : public testing::Test {
 protected:
  BsdfId Push(Bsdf node) {
    nodes_.push_back(node);
    return BsdfId(nodes_.size() - 1);
  }
  // Lets `amount` of the light straight through.
  BsdfId Hole(float amount) {
    Bsdf through, scale;
    through.kind = Bsdf::Kind::PassThrough;
    scale.kind = Bsdf::Kind::Scale;
    scale.first = Push(through);
    scale.factor = e_.Number(amount);
    return Push(scale);
  }
  BsdfId Both(Bsdf::Kind kind, BsdfId first, BsdfId second, float factor = 0) {
    Bsdf node;
    node.kind = kind;
    node.first = first;
    node.second = second;
    node.factor = e_.Number(factor);
    return Push(node);
  }
  float PassedBy(BsdfId root) {
    const Id passed = Linearise(&e_, nodes_, root).passThrough;
    return passed == kNone ? 0 : e_.Scalar(passed);
  }

  std::vector<std::string> frozen_;
  Expressions e_{&frozen_};
  std::vector<Bsdf> nodes_;
};

TEST_F(ClosureTree, WhatPassesThroughAddsUp) {
  EXPECT_FLOAT_EQ(PassedBy(Hole(0.3f)), 0.3f);
  EXPECT_FLOAT_EQ(PassedBy(Both(Bsdf::Kind::Add, Hole(0.3f), Hole(0.4f))), 0.7f);
  EXPECT_FLOAT_EQ(PassedBy(Both(Bsdf::Kind::Mix, Hole(0.8f), Hole(0.4f), 0.25f)), 0.25f * 0.8f + 0.75f * 0.4f);
  const BsdfId sum = Both(Bsdf::Kind::Add, Hole(0.1f), Hole(0.2f));
  EXPECT_FLOAT_EQ(PassedBy(Both(Bsdf::Kind::Mix, sum, Hole(0.6f), 0.5f)), 0.45f);
  const BsdfId hole = Hole(0.2f);
  EXPECT_FLOAT_EQ(PassedBy(Both(Bsdf::Kind::Add, hole, hole)), 0.4f) << "one node, used twice";
}

}  // namespace
}  // namespace materialgen
