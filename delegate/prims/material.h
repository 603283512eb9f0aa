// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Materials: which context's network is taken, and the bookkeeping from networks to kernels.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "materialgen/materialgen.h"
#include "wavefront/base/diagnostics.h"

namespace delegate {

// The render contexts that this delegate reads, best first: own, MaterialX, universal.
inline constexpr const char* kMaterialContexts[] = {"wavefront", "mtlx", ""};

struct MaterialUpdate {
  std::vector<std::pair<std::string, materialgen::MaterialNetwork>> contexts;  // those that exist
};

// The network to render: the first context in the order above whose nodes are all supported; where none is, the first
// that exists (its unknown parts turn visible). Each context passed over gives a diagnostic that names the node. Null:
// there is no network.
const materialgen::MaterialNetwork* ChooseNetwork(const std::string& path, const MaterialUpdate& material,
                                                  const materialgen::Generator& generator,
                                                  const wavefront::DiagnosticSink& sink);

// The first network, in the order of contexts, that has a displacement terminal; each terminal is looked for by itself, as
// UsdShadeMaterial does. Null: none has.
const materialgen::MaterialNetwork* ChooseDisplacement(const MaterialUpdate& material);

}  // namespace delegate
