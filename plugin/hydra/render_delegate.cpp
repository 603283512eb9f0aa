// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_delegate.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/extComputation.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>

#include "plugin/hydra/camera.h"
#include "plugin/hydra/convert_image.h"
#include "plugin/hydra/convert_light.h"
#include "plugin/hydra/convert_mesh.h"
#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/implicit.h"
#include "plugin/hydra/instancer.h"
#include "plugin/hydra/light.h"
#include "plugin/hydra/material.h"
#include "plugin/hydra/mesh.h"
#include "plugin/hydra/render_buffer.h"
#include "plugin/hydra/render_pass.h"
#include "plugin/hydra/render_settings.h"
#include "plugin/hydra/stats.h"

namespace hydra {
namespace {

// What the core does not draw is claimed as well, so that each such prim is told of.
const TfTokenVector& UnsupportedRprimTypes() {
  static const TfTokenVector types{HdPrimTypeTokens->basisCurves, HdPrimTypeTokens->points, HdPrimTypeTokens->volume};
  return types;
}

const TfTokenVector& UnsupportedSprimTypes() {
  static const TfTokenVector types{HdPrimTypeTokens->lightFilter, HdPrimTypeTokens->meshLight,
                                   HdPrimTypeTokens->pluginLight};
  return types;
}

TfTokenVector ToTokens(const std::vector<std::string>& names, const TfTokenVector& more) {
  TfTokenVector tokens(names.begin(), names.end());
  tokens.insert(tokens.end(), more.begin(), more.end());
  return tokens;
}

bool Contains(const TfTokenVector& tokens, const TfToken& token) {
  return std::find(tokens.begin(), tokens.end(), token) != tokens.end();
}

}  // namespace

RenderDelegate::RenderDelegate(std::unique_ptr<delegate::RenderDelegate> core, const HdRenderSettingsMap& settingsMap)
    : HdRenderDelegate(settingsMap),
      param_(std::make_unique<RenderParam>(std::move(core))),
      registry_(std::make_shared<HdResourceRegistry>()) {
  _PopulateDefaultSettings(GetRenderSettingDescriptors());
  // A host that says nothing is a viewport; those that render in batch say so.
  SetRenderSetting(HdRenderSettingsTokens->enableInteractive, VtValue(true));
  for (const auto& [key, value] : settingsMap) SetRenderSetting(key, value);
}

RenderDelegate::~RenderDelegate() { param_->core().Stop(); }

const TfTokenVector& RenderDelegate::GetSupportedRprimTypes() const {
  static const TfTokenVector types =
      ToTokens(delegate::RenderDelegate::SupportedRprimTypes(), UnsupportedRprimTypes());
  return types;
}

const TfTokenVector& RenderDelegate::GetSupportedSprimTypes() const {
  static const TfTokenVector types = [] {
    TfTokenVector all = ToTokens(delegate::RenderDelegate::SupportedSprimTypes(), UnsupportedSprimTypes());
    all.push_back(HdPrimTypeTokens->extComputation);
    return all;
  }();
  return types;
}

const TfTokenVector& RenderDelegate::GetSupportedBprimTypes() const {
  static const TfTokenVector types{HdPrimTypeTokens->renderBuffer, HdPrimTypeTokens->renderSettings};
  return types;
}

void RenderDelegate::SetRenderSetting(const TfToken& key, const VtValue& value) {
  if (const std::string token = ToCoreSetting(key); !token.empty()) {
    const auto setting = ToSetting(value);
    const auto changed = setting ? param_->core().SetRenderSetting(token, *setting)
                                 : wavefront::Result<bool>(wavefront::Error{"Render setting " + token +
                                                                            " cannot be a " + value.GetTypeName() +
                                                                            "."});
    if (!changed) {
      TF_WARN("hdWavefront: %s", changed.error().message.c_str());
      return;
    }
    _settingsMap[key] = value;
    if (!changed.value()) return;
    ++_settingsVersion;
    param_->MarkEdited();
    return;
  }
  if (const auto color = WithColorSetting(key, value, param_->snapshot().colorSettings())) {
    _settingsMap[key] = value;
    if (param_->snapshot().SetColor(*color)) ++_settingsVersion;  // the next paint shows it: nothing restarts
    return;
  }
  const auto known = _settingsMap.find(key);
  if (known != _settingsMap.end() && known->second == value) return;
  _settingsMap[key] = value;
  ++_settingsVersion;
}

VtValue RenderDelegate::GetRenderSetting(const TfToken& key) const {
  if (const std::string token = ToCoreSetting(key); !token.empty())
    if (const auto value = param_->core().GetRenderSetting(token)) return FromSetting(value.value());
  return HdRenderDelegate::GetRenderSetting(key);
}

HdRenderSettingDescriptorList RenderDelegate::GetRenderSettingDescriptors() const { return SettingDescriptors(); }

VtDictionary RenderDelegate::GetRenderStats() const { return ToStats(*param_); }

bool RenderDelegate::Stop(bool) { return param_->Stop(); }

HdRenderPassSharedPtr RenderDelegate::CreateRenderPass(HdRenderIndex* index, const HdRprimCollection& collection) {
  return std::make_shared<RenderPass>(index, collection, this);
}

HdInstancer* RenderDelegate::CreateInstancer(HdSceneDelegate* sceneDelegate, const SdfPath& id) {
  return new Instancer(sceneDelegate, id);
}

void RenderDelegate::DestroyInstancer(HdInstancer* instancer) { delete instancer; }

HdRprim* RenderDelegate::CreateRprim(const TfToken& typeId, const SdfPath& id) {
  if (typeId == HdPrimTypeTokens->mesh) return new Mesh(id);
  if (ToImplicitShape(typeId)) return new Implicit(typeId, id);
  if (Contains(UnsupportedRprimTypes(), typeId)) return new UnsupportedRprim(typeId, id);
  TF_CODING_ERROR("hdWavefront has no Rprim of type %s (%s)", typeId.GetText(), id.GetText());
  return nullptr;
}

void RenderDelegate::DestroyRprim(HdRprim* rprim) { delete rprim; }

HdSprim* RenderDelegate::CreateSprim(const TfToken& typeId, const SdfPath& id) {
  if (typeId == HdPrimTypeTokens->camera) return new Camera(id);
  if (typeId == HdPrimTypeTokens->material) return new Material(id);
  if (typeId == HdPrimTypeTokens->extComputation) return new HdExtComputation(id);
  if (!ToLightType(typeId).empty()) return new Light(typeId, id);
  if (Contains(UnsupportedSprimTypes(), typeId)) return new UnsupportedSprim(typeId, id);
  TF_CODING_ERROR("hdWavefront has no Sprim of type %s (%s)", typeId.GetText(), id.GetText());
  return nullptr;
}

HdSprim* RenderDelegate::CreateFallbackSprim(const TfToken& typeId) { return CreateSprim(typeId, SdfPath()); }

void RenderDelegate::DestroySprim(HdSprim* sprim) { delete sprim; }

HdBprim* RenderDelegate::CreateBprim(const TfToken& typeId, const SdfPath& id) {
  if (typeId == HdPrimTypeTokens->renderBuffer) return new RenderBuffer(id, param_.get());
  if (typeId == HdPrimTypeTokens->renderSettings) return new RenderSettings(id, this);
  TF_CODING_ERROR("hdWavefront has no Bprim of type %s (%s)", typeId.GetText(), id.GetText());
  return nullptr;
}

HdBprim* RenderDelegate::CreateFallbackBprim(const TfToken& typeId) { return CreateBprim(typeId, SdfPath()); }

void RenderDelegate::DestroyBprim(HdBprim* bprim) { delete bprim; }

// Size, camera and AOVs are known in the render pass, which commits.
void RenderDelegate::CommitResources(HdChangeTracker*) {}

TfTokenVector RenderDelegate::GetMaterialRenderContexts() const {
  TfTokenVector contexts;
  for (const char* context : delegate::kMaterialContexts) contexts.emplace_back(context);
  return contexts;
}

// "glslfx" is not rendered either: but without it UsdImaging empties materials of such files, with scene-index mode off, and
// nobody could tell of them.
TfTokenVector RenderDelegate::GetShaderSourceTypes() const {
  TfTokenVector types = GetMaterialRenderContexts();
  types.emplace_back("glslfx");
  return types;
}

TfTokenVector RenderDelegate::GetRenderSettingsNamespaces() const { return {TfToken("wavefront")}; }

HdAovDescriptor RenderDelegate::GetDefaultAovDescriptor(const TfToken& name) const { return ToAovDescriptor(name); }

void RenderDelegate::SetProducts(const std::vector<Product>& products) {
  std::lock_guard lock(productsMutex_);
  shots_ = ToShots(products);
  written_ = 0;
  toWrite_ = false;
  param_->MarkEdited();
}

bool RenderDelegate::IsBatch() const {
  return !ToBool(GetRenderSetting(HdRenderSettingsTokens->enableInteractive)).value_or(true);
}

void RenderDelegate::SetIncludedPurposes(const SdfPath& settings, IncludedPurposes included) {
  std::lock_guard lock(productsMutex_);
  included_ = {settings, std::move(included)};
  param_->MarkEdited();
}

std::pair<SdfPath, IncludedPurposes> RenderDelegate::CurrentPurposes() const {
  if (!IsBatch()) return {};
  std::lock_guard lock(productsMutex_);
  return included_;
}

std::optional<Shot> RenderDelegate::CurrentShot() const {
  if (!IsBatch()) return std::nullopt;
  std::lock_guard lock(productsMutex_);
  return shots_.empty() ? std::nullopt : std::optional(shots_[std::min(written_, shots_.size() - 1)]);
}

bool RenderDelegate::IsLastShot() const {
  std::lock_guard lock(productsMutex_);
  return written_ + 1 >= shots_.size();
}

void RenderDelegate::FirstShot() {
  std::lock_guard lock(productsMutex_);
  written_ = 0;
}

void RenderDelegate::ShotStarted() {
  std::lock_guard lock(productsMutex_);
  toWrite_ = true;
}

bool RenderDelegate::WriteProducts() {
  if (!param_->core().IsConverged()) return true;  // stopped or failed: no half pictures
  const std::optional<Shot> shot = CurrentShot();
  if (!shot) return true;
  {
    std::lock_guard lock(productsMutex_);
    if (!toWrite_) return written_ == shots_.size();
    toWrite_ = false;
  }
  for (const Product& product : shot->products)
    if (const wavefront::Status status = WriteProduct(param_->core(), product); !status)
      TF_RUNTIME_ERROR("hdWavefront: %s: %s", product.path.GetText(), status.error().message.c_str());
  std::lock_guard lock(productsMutex_);
  written_ = std::min(written_ + 1, shots_.size());
  return written_ == shots_.size();
}

}  // namespace hydra
