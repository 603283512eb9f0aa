// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_param.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/pathUtils.h>

#include "plugin/hydra/texture_loader.h"

namespace hydra {

RenderParam::RenderParam(std::unique_ptr<delegate::RenderDelegate> core)
    : core_(std::move(core)), decodeTexture_(DecodeTexture), snapshot_(*core_) {
  core_->SetUnconvertedColorSpaces(UnconvertedSpaces());
}

int32_t RenderParam::PrototypeId(const SdfPath& prototype) {
  std::lock_guard lock(instancesMutex_);
  return prototypeIds_.try_emplace(prototype, static_cast<int32_t>(prototypeIds_.size())).first->second;
}

void RenderParam::SetInstances(const SdfPath& instancer, const SdfPath& prototype, std::vector<int32_t> indices) {
  const int32_t id = PrototypeId(prototype);
  std::lock_guard lock(instancesMutex_);
  Instances& instances = instances_[instancer];
  std::vector<int32_t>& known = instances.byPrototype[id];
  if (known == indices && !known.empty()) return;
  known = std::move(indices);
  instances.dirty = true;
  edited_ = true;
}

void RenderParam::ForgetInstancer(const SdfPath& instancer) {
  std::lock_guard lock(instancesMutex_);
  instances_.erase(instancer);
}

void RenderParam::FlushInstances() {
  std::lock_guard lock(instancesMutex_);
  for (auto& [path, instances] : instances_) {
    if (!instances.dirty) continue;
    delegate::InstancerUpdate update;
    update.prototypeInstances = instances.byPrototype;
    core_->Sync(path.GetString(), std::move(update));
    instances.dirty = false;
  }
}

bool RenderParam::Fail(const std::string& message) {
  failed_ = true;
  PostDiagnostics();
  TF_RUNTIME_ERROR("hdWavefront: %s", message.c_str());
  return false;
}

bool RenderParam::CommitAndStart(const delegate::RenderPassUpdate& pass) {
  if (const wavefront::Status status = core_->SetRenderPass(pass); !status) return Fail(status.error().message);
  failed_ = false;
  snapshot_.Reset();
  FlushInstances();
  LoadTextures(*core_, decodeTexture_,
               [this](wavefront::Severity severity, const char* code, const std::string& location,
                      const std::string& message) { Report(severity, code, SdfPath(location), message); });
  const wavefront::Status committed = core_->CommitResources();
  PostDiagnostics();
  if (!committed) return Fail(committed.error().message);
  if (!captureFile_.empty()) return Capture();
  if (stopped_) return true;
  if (const wavefront::Status started = core_->Start(); !started) return Fail(started.error().message);
  if (paused_) core_->Pause();
  return true;
}

bool RenderParam::Capture() {
  const auto written = core_->WriteCapture(captureFile_, TfGetBaseName(captureFile_), HDWAVEFRONT_VERSION);
  if (!written) return Fail(written.error().message);
  TF_STATUS("hdWavefront: wrote %s and renders nothing, since HDWAVEFRONT_CAPTURE names it.", captureFile_.c_str());
  return true;
}

bool RenderParam::IsConverged() const {
  if (failed_ || stopped_ || !captureFile_.empty()) return true;
  if (core_->IsConverged()) return true;
  return !core_->status().ok();
}

void RenderParam::PostFailure() {
  const wavefront::Status status = core_->status();
  if (!status && !failed_) Fail(status.error().message);
}

bool RenderParam::Pause() {
  paused_ = true;
  core_->Pause();
  return true;
}

bool RenderParam::Resume() {
  paused_ = false;
  core_->Resume();
  return true;
}

bool RenderParam::Stop() {
  stopped_ = true;
  core_->Stop();
  return true;
}

bool RenderParam::Restart() {
  stopped_ = false;
  edited_ = true;  // the next Execute starts
  return true;
}

void RenderParam::Report(wavefront::Severity severity, const char* code, const SdfPath& path,
                         const std::string& message) {
  ownLog_.Add({severity, code, path.GetString(), message});
}

void RenderParam::PostDiagnostics() {
  std::lock_guard lock(postMutex_);
  const auto post = [](const std::vector<wavefront::Diagnostic>& all) {
    for (const wavefront::Diagnostic& d : all) {
      if (d.severity == wavefront::Severity::Info)
        TF_STATUS("[%s] %s: %s", d.code.c_str(), d.location.c_str(), d.message.c_str());
      else
        TF_WARN("[%s] %s: %s", d.code.c_str(), d.location.c_str(), d.message.c_str());
    }
    return all.size();
  };
  postedOwn_ += post(ownLog_.Read(postedOwn_));
  postedCore_ += post(core_->diagnostics(postedCore_));
}

}  // namespace hydra
