// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What all prims of one Hydra render delegate share: the host-neutral delegate, the edit gate, the state of the
// render in the background, and who draws which instances.
//
// Threads: Edit, SetInstances, PrototypeId and the queries may be called from any thread (Hydra syncs in parallel);
// Commit, Start and what stops belong to the thread that executes render passes. Prims hold a pointer to this: Hydra
// destroys them before the render delegate.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/usd/sdf/path.h>

#include "delegate/render_delegate.h"
#include "plugin/hydra/hd_compat.h"
#include "plugin/hydra/load_textures.h"
#include "plugin/hydra/snapshot.h"

namespace hydra {

class RenderParam final : public HdRenderParam {
 public:
  explicit RenderParam(std::unique_ptr<delegate::RenderDelegate> core);

  delegate::RenderDelegate& core() { return *core_; }
  const delegate::RenderDelegate& core() const { return *core_; }
  Snapshot& snapshot() { return snapshot_; }

  // --- The edit gate. Updates go straight to the core, which only keeps and compares them; the render is stopped in
  // CommitAndStart alone, and only where something differs: usdview dirties dome lights in every frame.
  template <typename Update>
  void Edit(const SdfPath& path, Update update) {
    if (core_->Sync(path.GetString(), std::move(update))) edited_ = true;
  }
  void MarkEdited() { edited_ = true; }
  bool TakeEdited() { return edited_.exchange(false); }

  // --- Instances, as Hydra has them: each prototype (Rprim, light, or instancer) has indices in its instancer.
  int32_t PrototypeId(const SdfPath& prototype);
  void SetInstances(const SdfPath& instancer, const SdfPath& prototype, std::vector<int32_t> indices);
  void ForgetInstancer(const SdfPath& instancer);

  // Who decodes images: Hio, unless a test brings its own. Called from several threads.
  void SetTextureDecoder(TextureDecoder decoder) { decodeTexture_ = std::move(decoder); }

  // --- The render.
  // With a core that was made for it: every commit writes the scene to this file, nothing is rendered, and all counts as
  // converged.
  void CaptureTo(std::string file) { captureFile_ = std::move(file); }
  // Textures, commit, start: everything between Execute and the picture. False, and a runtime error posted, where it
  // cannot be rendered; the picture then counts as converged, so that no host waits for it.
  bool CommitAndStart(const delegate::RenderPassUpdate& pass);
  bool IsConverged() const;
  // Posts the render thread's error, once: a render that failed in the background must not pass for a picture.
  void PostFailure();
  bool Pause();
  bool Resume();
  bool Stop();
  bool Restart();
  bool IsPaused() const { return paused_; }
  bool IsStopped() const { return stopped_; }
  bool HasFailed() const { return failed_; }

  // Posts the core's new diagnostics: TF_WARN, or TF_STATUS for what is only worth knowing.
  void PostDiagnostics();
  void Report(wavefront::Severity severity, const char* code, const SdfPath& path, const std::string& message);

 private:
  void FlushInstances();
  bool Capture();
  bool Fail(const std::string& message);

  std::unique_ptr<delegate::RenderDelegate> core_;
  TextureDecoder decodeTexture_;
  std::string captureFile_;
  Snapshot snapshot_;
  std::atomic<bool> edited_{true}, failed_{false}, paused_{false}, stopped_{false};

  std::mutex instancesMutex_;
  struct Instances {
    std::map<int32_t, std::vector<int32_t>> byPrototype;
    bool dirty = false;
  };
  std::unordered_map<SdfPath, Instances, SdfPath::Hash> instances_;
  std::unordered_map<SdfPath, int32_t, SdfPath::Hash> prototypeIds_;

  delegate::DiagnosticLog ownLog_;
  std::mutex postMutex_;
  size_t postedCore_ = 0, postedOwn_ = 0;
};

inline RenderParam& Param(HdRenderParam* param) { return *static_cast<RenderParam*>(param); }

}  // namespace hydra
