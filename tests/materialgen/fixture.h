// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// For tests: one generator for all, networks by a line of code, and whether what comes out compiles.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "materialgen/materialgen.h"

namespace materialgen {

using Color = std::array<float, 3>;
using LobeNames = std::vector<std::string>;

Generator& SharedGenerator();

struct Result {
  CompiledMaterial material;
  std::vector<Message> messages;
  bool Has(const std::string& code) const {
    return std::any_of(messages.begin(), messages.end(), [&](const Message& m) { return m.code == code; });
  }
};
Result RunNetwork(const MaterialNetwork& network);

// Every entry of the kernel compiles; returns the words of SPIR-V of the surface.
size_t ExpectCompiles(const CompiledMaterial& material, const std::string& name);

// A material of one node.
MaterialNetwork Preview(std::map<std::string, Value> parameters = {});
MaterialNetwork Standard(std::map<std::string, Value> parameters = {});

inline LobeNames Lobes(const Result& result) { return result.material.kernel->lobes; }

}  // namespace materialgen
