// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// For tests: a surface material of a .mtlx file as a MaterialNetwork, as a host would hand it over.
#pragma once

#include <string>
#include <vector>

#include "materialgen/materialgen.h"

namespace materialgen_test {

// Networks of all materials in the file; empty where it cannot be read.
std::vector<materialgen::MaterialNetwork> NetworksOf(const std::string& mtlxFile, const std::string& libraryPath);

}  // namespace materialgen_test
