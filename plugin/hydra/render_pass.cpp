// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_pass.h"

#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/renderPassState.h>

#include <algorithm>
#include <map>
#include <set>

#include "plugin/hydra/camera.h"
#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/render_buffer.h"
#include "plugin/hydra/render_delegate.h"
#include "plugin/hydra/render_param.h"

namespace hydra {
namespace {

const SdfPath& PassCamera() {
  static const SdfPath path("/__hdwavefront_pass_camera");
  return path;
}

}  // namespace

RenderPass::RenderPass(HdRenderIndex* index, const HdRprimCollection& collection, RenderDelegate* owner)
    : HdRenderPass(index, collection), owner_(owner) {}

RenderPass::~RenderPass() = default;

bool RenderPass::IsConverged() const {
  if (!owner_->param().IsConverged()) return false;
  owner_->param().PostFailure();
  return owner_->WriteProducts();  // hosts look for the files as soon as this is true
}

RenderPass::Wish RenderPass::ReadState(const HdRenderPassState& state, const TfTokenVector& renderTags) const {
  Wish wish;
  if (const HdCamera* camera = state.GetCamera()) {
    wish.camera = camera->GetId().GetString();
  } else {
    wish.view = state.GetWorldToViewMatrix();
    wish.projection = state.GetProjectionMatrix();
  }
  wish.framing = ToPassFraming(state.GetFraming(), state.GetViewport());
  wish.policy = ToConformPolicy(state.GetWindowPolicy());
  const std::vector<std::string> ofHost(renderTags.begin(), renderTags.end());
  wish.renderTags = DrawnTags(ofHost, owner_->CurrentPurposes().second);
  return wish;
}

// A batch render of a RenderSettings prim with products is framed by them, whatever the host's own frame.
void RenderPass::Look(const ProductView& view, const SdfPath& product, Wish& wish) const {
  if (view.framing.width > 0 && view.framing.height > 0) wish.framing = view.framing;
  wish.policy = view.policy;
  wish.depthOfField = view.depthOfField;
  if (view.camera.empty()) return;
  if (GetRenderIndex()->GetSprim(HdPrimTypeTokens->camera, SdfPath(view.camera)))
    wish.camera = view.camera;
  else
    owner_->param().Report(wavefront::Severity::Warning, "camera-missing", product,
                           "the camera " + view.camera + " does not exist; the host's is used");
}

RenderBuffer* RenderPass::BufferOf(const HdRenderPassAovBinding& binding) const {
  HdBprim* buffer = binding.renderBuffer;
  if (!buffer) buffer = GetRenderIndex()->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId);
  return static_cast<RenderBuffer*>(buffer);
}

std::vector<std::string> RenderPass::AovTokens(const HdRenderPassAovBindingVector& bindings,
                                               const std::optional<Shot>& shot) const {
  std::set<std::string> wanted, primvars;
  const auto want = [&](const std::string& token, const SdfPath& asker) {
    const bool isPrimvar = token.starts_with(wavefront::kPrimvarPrefix);
    if (isPrimvar ? primvars.size() == wavefront::kMaxPrimvarAovs && !primvars.count(token)
                  : !wavefront::FindAov(token)) {
      owner_->param().Report(wavefront::Severity::Warning, "aov-unsupported", asker,
                             isPrimvar ? "more than " + std::to_string(wavefront::kMaxPrimvarAovs) +
                                             " primvar AOVs; \"" + token + "\" stays clear"
                                       : "there is no AOV \"" + token + "\"; it stays clear");
      return;
    }
    if (isPrimvar) primvars.insert(token);
    wanted.insert(token);
  };
  for (const HdRenderPassAovBinding& binding : bindings) want(binding.aovName.GetString(), binding.renderBufferId);
  if (shot)
    for (const Product& product : shot->products)
      for (const std::string& token : product.aovs) want(token, product.path);
  return {wanted.begin(), wanted.end()};
}

void RenderPass::ReportTags(const TfTokenVector& ofHost) const {
  const auto [settings, included] = owner_->CurrentPurposes();
  if (settings.IsEmpty() || ofHost.empty()) return;
  std::map<std::string, size_t> missing;
  for (const SdfPath& id : GetRenderIndex()->GetRprimIds()) {
    const TfToken tag = GetRenderIndex()->GetRenderTag(id);
    if (std::ranges::count(included.renderTags, tag.GetString()) && !std::ranges::count(ofHost, tag))
      ++missing[tag.GetString()];
  }
  // The schema's fallback is no wish of the stage's author.
  const auto severity = included.areFallback ? wavefront::Severity::Info : wavefront::Severity::Warning;
  for (const auto& [tag, count] : missing)
    owner_->param().Report(severity, "render-purposes", settings,
                           "includedPurposes has '" + tag + "', which this host does not hand over (usdrecord --purposes " +
                               tag + "): prims of that purpose (" + std::to_string(count) + ") are not drawn");
}

std::string RenderPass::SyncCamera(const Wish& wish) const {
  if (!wish.camera.empty() && wish.depthOfField) return wish.camera;
  delegate::CameraUpdate update;
  if (wish.camera.empty()) {
    update.params = ToCameraParams(wish.projection);
    update.transforms = {{0, ToMatrix(wish.view.GetInverse())}};
  } else {
    const auto* camera =
        static_cast<const Camera*>(GetRenderIndex()->GetSprim(HdPrimTypeTokens->camera, SdfPath(wish.camera)));
    if (!camera) return wish.camera;  // the core tells
    update.params = camera->params();
    update.transforms = {{0, ToMatrix(camera->GetTransform())}};
  }
  if (!wish.depthOfField) update.params->fStop = 0;
  owner_->param().core().Sync(PassCamera().GetString(), std::move(update));
  return PassCamera().GetString();
}

// What a user sets counts until the host shows another frame.
void RenderPass::FollowHost() {
  const std::optional<HostTime> time = ReadHostTime(*GetRenderIndex());
  if (!time || time == time_) return;
  time_ = time;
  owner_->SetRenderSetting(TfToken("wavefront:frame"), VtValue(time->frame));
  owner_->SetRenderSetting(TfToken("wavefront:time"), VtValue(time->seconds));
}

void RenderPass::_Execute(const HdRenderPassStateSharedPtr& renderPassState, const TfTokenVector& renderTags) {
  RenderParam& param = owner_->param();
  FollowHost();
  const bool edited = param.TakeEdited();
  if (edited) owner_->FirstShot();
  const std::optional<Shot> shot = owner_->CurrentShot();
  const HdRenderPassAovBindingVector& bindings = renderPassState->GetAovBindings();
  Wish wish = ReadState(*renderPassState, renderTags);
  if (shot) Look(shot->view, shot->products.front().path, wish);
  wish.aovs = AovTokens(bindings, shot);
  const auto selection = wavefront::SelectAovs(wish.aovs);
  const bool shown = selection && (!shot || owner_->IsLastShot());
  for (const HdRenderPassAovBinding& binding : bindings)
    if (RenderBuffer* buffer = BufferOf(binding))
      buffer->Show(shown ? wavefront::FindAov(binding.aovName.GetString(), selection.value().primvars) : std::nullopt,
                   binding.clearValue, wish.framing.x, wish.framing.y);
  param.PostDiagnostics();
  if (!edited && last_ == wish) return;

  delegate::RenderPassUpdate update;
  update.camera = SyncCamera(wish);
  update.width = wish.framing.width;
  update.height = wish.framing.height;
  update.pixelAspectRatio = wish.framing.pixelAspectRatio;
  update.dataWindow = wish.framing.part;
  update.windowPolicy = wish.policy;
  update.renderTags = wish.renderTags;
  if (selection) {
    update.aovs = selection.value().aovs;
    update.primvarAovs = selection.value().primvars;
  }
  ReportTags(renderTags);
  last_ = std::move(wish);
  if (param.CommitAndStart(update) && shot) owner_->ShotStarted();
}

}  // namespace hydra
