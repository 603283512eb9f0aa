// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The images of one moment, for all render buffers of a host: each paint then waits once for the render thread, not
// once per buffer, and its buffers show the same samples.
// The colour AOV passes the colour output once, when it is taken.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "delegate/render_delegate.h"
#include "plugin/hydra/color_output.h"

namespace hydra {

// Any thread.
class Snapshot {
 public:
  explicit Snapshot(delegate::RenderDelegate& core) : core_(core) {}

  struct Picture {
    std::shared_ptr<const wavefront::AovImage> image;  // null: nothing is rendered yet
    uint64_t moment = 0;   // grows; a buffer that shows it hands it in when it asks again
    uint64_t version = 0;  // as version() below
    bool complete = false; // the whole picture of that version
  };
  // An image of a later moment than `shown` (0: none): what is held, where it is later; else all AOVs that are asked
  // for are taken anew.
  Picture Newer(wavefront::Aov aov, uint64_t shown);
  // The AOVs that are rendered changed.
  void Reset();
  // Grows when the image restarts and when its colours are to look different.
  uint64_t version() const { return core_.version() + colorChanges_; }
  // True: changed. Nothing is rendered anew for it.
  bool SetColor(const ColorSettings& settings);
  ColorSettings colorSettings() const { return color_.settings(); }

 private:
  void Take(wavefront::Aov aov);
  void Keep(wavefront::Aov aov, wavefront::AovImage image);

  delegate::RenderDelegate& core_;
  ColorOutput color_;
  std::atomic<uint64_t> colorChanges_{0};
  std::mutex mutex_;
  std::map<wavefront::Aov, std::shared_ptr<const wavefront::AovImage>> images_;
  std::set<wavefront::Aov> asked_;
  uint64_t moment_ = 0, version_ = 0;
  bool complete_ = false;
};

}  // namespace hydra
