// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scenes measured one after the other. What was measured stays: a scene that fails is noted, and the JSON file is written
// anew after each scene.
#pragma once

#include <string>
#include <vector>

#include "plugin/bench/measure.h"
#include "plugin/bench/options.h"

namespace bench {

enum ExitCode : int { kDone = 0, kFailed = 1, kWrongUsage = 2, kDifferent = 3 };

class Session {
 public:
  Session(const Options& options, wavefront::DeviceBandwidth device) : options_(options), device_(std::move(device)) {}

  // Before anything is rendered: an error where the JSON file cannot be written.
  wavefront::Status Begin() const { return KeepJson(); }
  // `origin`: the scene's file; empty: it was made here.
  void Run(delegate::CapturedScene scene, const std::string& origin = {});
  // The table of a sweep, and the picture.
  ExitCode Finish() const;

  const std::vector<SceneResult>& results() const { return results_; }

 private:
  SceneResult Measured(delegate::CapturedScene scene) const;
  wavefront::Status KeepJson() const;

  const Options& options_;
  wavefront::DeviceBandwidth device_;
  std::vector<SceneResult> results_;
  bool failed_ = false;
};

}  // namespace bench
