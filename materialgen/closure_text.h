// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The closure tree of one material in words, for `hdwavefront explain`.
#pragma once

#include <string>
#include <vector>

#include "materialgen/closure.h"

namespace materialgen {

// One line per node, children indented by two spaces; at most kClosureTextLines. Weights are this material's: a number
// that an edit may change, "varies" for what each point decides. What a weight of zero leaves out says so.
constexpr int kClosureTextLines = 300;
std::string ClosureText(const Expressions& expressions, const std::vector<Bsdf>& nodes, BsdfId root);

}  // namespace materialgen
