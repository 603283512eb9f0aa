// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "wavefront/base/diagnostics.h"

namespace delegate {

// Collects diagnostics, each distinct one once. Thread-safe.
class DiagnosticLog {
 public:
  void Add(const wavefront::Diagnostic& diagnostic);
  // In order of arrival, from index `since` on.
  std::vector<wavefront::Diagnostic> Read(size_t since = 0) const;
  // A sink that writes here; valid as long as the log lives.
  wavefront::DiagnosticSink Sink();

 private:
  mutable std::mutex mutex_;
  std::vector<wavefront::Diagnostic> all_;
  std::set<std::string> seen_;
};

}  // namespace delegate
