// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/diagnostics.h"

namespace delegate {

void DiagnosticLog::Add(const wavefront::Diagnostic& diagnostic) {
  std::string key = diagnostic.code + '\n' + diagnostic.location + '\n' + diagnostic.message;
  std::lock_guard lock(mutex_);
  if (seen_.insert(std::move(key)).second) all_.push_back(diagnostic);
}

std::vector<wavefront::Diagnostic> DiagnosticLog::Read(size_t since) const {
  std::lock_guard lock(mutex_);
  if (since >= all_.size()) return {};
  return {all_.begin() + static_cast<std::ptrdiff_t>(since), all_.end()};
}

wavefront::DiagnosticSink DiagnosticLog::Sink() {
  return [this](const wavefront::Diagnostic& diagnostic) { Add(diagnostic); };
}

}  // namespace delegate
