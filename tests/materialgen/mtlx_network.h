// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// For tests: a surface material of a .mtlx file as a MaterialNetwork, as a host would hand it over.
#pragma once

#include <string>
#include <vector>

#include "materialgen/materialgen.h"

namespace materialgen_test {

// Networks of all materials in the file, or of the surfaces that its graphs give out where it has no material; empty
// where it cannot be read. Nodes that the file defines by graphs are replaced by those.
std::vector<materialgen::MaterialNetwork> NetworksOf(const std::string& mtlxFile, const std::string& libraryPath);

// Every node definition of the library whose outputs are numbers, with a network that adds `batch` of them at a time up
// into the colour of a surface, all numeric inputs read from primvars, so that nothing folds away.
std::vector<materialgen::MaterialNetwork> NetworksOfAllNodes(const std::string& libraryPath, size_t batch);

}  // namespace materialgen_test
