// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scene content that cannot be rendered as authored is reported, never hidden: one Diagnostic per
// distinct problem, naming the prim or file. The render goes on with a visible fallback.
#pragma once

#include <functional>
#include <string>

namespace wavefront {

enum class Severity { Info, Warning, Error };

// A problem with scene content or the environment that a user can act on.
struct Diagnostic {
  Severity severity = Severity::Warning;
  std::string code;      // stable, kebab-case: "texture-missing", "mesh-bad-topology", ...
  std::string location;  // prim path or file name
  std::string message;   // one sentence, plain words
};

// Receives diagnostics; must be callable from any thread. The receiver removes duplicates.
using DiagnosticSink = std::function<void(const Diagnostic&)>;

}  // namespace wavefront
