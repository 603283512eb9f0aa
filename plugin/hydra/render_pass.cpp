// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_pass.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/renderPassState.h>

#include <algorithm>
#include <set>

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
  owner_->WriteProducts();  // hosts look for the files as soon as this is true
  return true;
}

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
  // A batch render of a RenderSettings prim with products is framed by them, whatever the host's own frame.
  if (const std::vector<Product> products = owner_->BatchProducts(); !products.empty()) {
    const Product& product = products.front();
    if (!product.camera.empty()) wish.camera = product.camera;
    if (product.framing.width > 0 && product.framing.height > 0) wish.framing = product.framing;
    wish.policy = product.policy;
  }
  for (const TfToken& tag : renderTags) wish.renderTags.push_back(tag.GetString());
  std::sort(wish.renderTags.begin(), wish.renderTags.end());
  return wish;
}

RenderBuffer* RenderPass::BufferOf(const HdRenderPassAovBinding& binding) const {
  HdBprim* buffer = binding.renderBuffer;
  if (!buffer) buffer = GetRenderIndex()->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId);
  return static_cast<RenderBuffer*>(buffer);
}

std::vector<std::string> RenderPass::AovTokens(const HdRenderPassAovBindingVector& bindings) const {
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
  for (const Product& product : owner_->BatchProducts())
    for (const std::string& token : product.aovs) want(token, product.path);
  return {wanted.begin(), wanted.end()};
}

void RenderPass::_Execute(const HdRenderPassStateSharedPtr& renderPassState, const TfTokenVector& renderTags) {
  RenderParam& param = owner_->param();
  const HdRenderPassAovBindingVector& bindings = renderPassState->GetAovBindings();
  Wish wish = ReadState(*renderPassState, renderTags);
  wish.aovs = AovTokens(bindings);
  const auto selection = wavefront::SelectAovs(wish.aovs);
  for (const HdRenderPassAovBinding& binding : bindings)
    if (RenderBuffer* buffer = BufferOf(binding))
      buffer->Show(selection ? wavefront::FindAov(binding.aovName.GetString(), selection.value().primvars)
                             : std::nullopt,
                   binding.clearValue, wish.framing.x, wish.framing.y);
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
  update.dataWindow = wish.framing.part;
  update.windowPolicy = wish.policy;
  update.renderTags = wish.renderTags;
  if (selection) {
    update.aovs = selection.value().aovs;
    update.primvarAovs = selection.value().primvars;
  }
  last_ = std::move(wish);
  param.CommitAndStart(update);
}

}  // namespace hydra
