// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <string>
#include <vector>

#include "materialgen/network.h"

namespace delegate {

// One material as it was understood, for people.
struct MaterialExplanation {
  std::string context;  // of the terminal that is rendered: "wavefront", "mtlx", "" (universal)
  materialgen::MaterialNetwork network;
  std::string kernelKey, closureTree;
  struct Parameter {
    std::string node, input;
    std::vector<float> values;
  };
  std::vector<Parameter> parameters;  // of the block, those that come from one input
};

}  // namespace delegate
