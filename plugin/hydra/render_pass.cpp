// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_pass.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/renderPassState.h>

#include <algorithm>

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

bool RenderPass::IsConverged() const { return owner_->param().IsConverged(); }

RenderPass::Wish RenderPass::ReadState(const HdRenderPassState& state, const TfTokenVector& renderTags) const {
  Wish wish;
  if (const HdCamera* camera = state.GetCamera()) {
    wish.camera = camera->GetId().GetString();
  } else {
    wish.camera = PassCamera().GetString();
    wish.view = state.GetWorldToViewMatrix();
    wish.projection = state.GetProjectionMatrix();
  }
  wish.framing = ToPassFraming(state.GetFraming(), state.GetViewport());
  wish.policy = ToConformPolicy(state.GetWindowPolicy());
  for (const TfToken& tag : renderTags) wish.renderTags.push_back(tag.GetString());
  std::sort(wish.renderTags.begin(), wish.renderTags.end());
  return wish;
}

std::vector<wavefront::Aov> RenderPass::Bind(const HdRenderPassAovBindingVector& bindings,
                                             const PassFraming& framing) const {
  std::vector<wavefront::Aov> aovs;
  for (const HdRenderPassAovBinding& binding : bindings) {
    auto* buffer = static_cast<RenderBuffer*>(
        binding.renderBuffer ? binding.renderBuffer
                             : GetRenderIndex()->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId));
    if (!buffer) continue;
    const wavefront::AovInfo* info = wavefront::FindAov(binding.aovName.GetString());
    if (!info) {
      owner_->param().Report(wavefront::Severity::Warning, "aov-unsupported", binding.renderBufferId,
                             "there is no AOV \"" + binding.aovName.GetString() + "\"; its buffer stays clear");
      buffer->ShowNothing(binding.clearValue);
      continue;
    }
    buffer->Show(info->aov, binding.clearValue, framing.x, framing.y);
    aovs.push_back(info->aov);
  }
  std::sort(aovs.begin(), aovs.end());
  aovs.erase(std::unique(aovs.begin(), aovs.end()), aovs.end());
  return aovs;
}

void RenderPass::_Execute(const HdRenderPassStateSharedPtr& renderPassState, const TfTokenVector& renderTags) {
  RenderParam& param = owner_->param();
  Wish wish = ReadState(*renderPassState, renderTags);
  wish.aovs = Bind(renderPassState->GetAovBindings(), wish.framing);
  param.PostDiagnostics();
  if (!param.TakeEdited() && last_ == wish) return;

  delegate::RenderPassUpdate update;
  update.camera = wish.camera;
  if (wish.camera == PassCamera().GetString()) {
    delegate::CameraUpdate camera;
    camera.params = ToCameraParams(wish.projection);
    camera.transforms = {{0, ToMatrix(wish.view.GetInverse())}};
    param.core().Sync(wish.camera, std::move(camera));
  }
  update.width = wish.framing.width;
  update.height = wish.framing.height;
  update.pixelAspectRatio = wish.framing.pixelAspectRatio;
  update.windowPolicy = wish.policy;
  update.renderTags = wish.renderTags;
  update.aovs = wish.aovs;
  last_ = std::move(wish);
  param.CommitAndStart(update);
}

}  // namespace hydra
