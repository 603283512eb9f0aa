// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/prims/material.h"

namespace delegate {
namespace {

std::string ContextName(const std::string& context) { return context.empty() ? "universal" : "\"" + context + "\""; }

}  // namespace

const materialgen::MaterialNetwork* ChooseNetwork(const std::string& path, const MaterialUpdate& material,
                                                  const materialgen::Generator& generator,
                                                  const wavefront::DiagnosticSink& sink) {
  struct Candidate {
    std::string context;
    const materialgen::MaterialNetwork* network;
  };
  std::vector<Candidate> candidates;
  for (const char* context : kMaterialContexts)
    for (const auto& [name, network] : material.contexts)
      if (name == context && !network.surfaceNode.empty()) candidates.push_back({name, &network});
  if (candidates.empty()) {
    sink({wavefront::Severity::Warning, "material-no-surface", path,
          "The material has no surface that this renderer reads; the default material is shown."});
    return nullptr;
  }
  if (candidates.size() == 1) return candidates[0].network;

  for (size_t i = 0; i < candidates.size(); ++i) {
    std::string unsupported;
    if (generator.Supports(*candidates[i].network, &unsupported)) return candidates[i].network;
    if (i + 1 < candidates.size())
      sink({wavefront::Severity::Warning, "material-context-passed-over", unsupported.empty() ? path : unsupported,
            "The " + ContextName(candidates[i].context) + " network of " + path +
                " holds a node that is not supported; the " + ContextName(candidates[i + 1].context) +
                " network is looked at instead."});
  }
  return candidates[0].network;
}

const materialgen::MaterialNetwork* ChooseDisplacement(const MaterialUpdate& material) {
  for (const char* context : kMaterialContexts)
    for (const auto& [name, network] : material.contexts)
      if (name == context && !network.displacementNode.empty()) return &network;
  return nullptr;
}

}  // namespace delegate
