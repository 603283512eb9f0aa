// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Hydra's render delegate: makes the prims, and answers for settings, AOVs, statistics and the render in the
// background.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/imaging/hd/resourceRegistry.h>

#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/hd_compat.h"
#include "plugin/hydra/products.h"
#include "plugin/hydra/render_param.h"

namespace hydra {

class RenderSettings;

class RenderDelegate final : public HdRenderDelegate {
 public:
  RenderDelegate(std::unique_ptr<delegate::RenderDelegate> core, const HdRenderSettingsMap& settingsMap);
  ~RenderDelegate() override;

  RenderParam& param() const { return *param_; }

  const TfTokenVector& GetSupportedRprimTypes() const override;
  const TfTokenVector& GetSupportedSprimTypes() const override;
  const TfTokenVector& GetSupportedBprimTypes() const override;
  HdRenderParam* GetRenderParam() const override { return param_.get(); }
  HdResourceRegistrySharedPtr GetResourceRegistry() const override { return registry_; }

  void SetRenderSetting(const TfToken& key, const VtValue& value) override;
  VtValue GetRenderSetting(const TfToken& key) const override;
  HdRenderSettingDescriptorList GetRenderSettingDescriptors() const override;
  VtDictionary GetRenderStats() const override;

  bool IsPauseSupported() const override { return true; }
  bool IsPaused() const override { return param_->IsPaused(); }
  bool Pause() override { return param_->Pause(); }
  bool Resume() override { return param_->Resume(); }
  bool IsStopSupported() const override { return true; }
  bool IsStopped() const override { return param_->IsStopped(); }
  bool Stop(bool blocking = true) override;
  bool Restart() override { return param_->Restart(); }

  HdRenderPassSharedPtr CreateRenderPass(HdRenderIndex* index, const HdRprimCollection& collection) override;
  HdInstancer* CreateInstancer(HdSceneDelegate* sceneDelegate, const SdfPath& id) override;
  void DestroyInstancer(HdInstancer* instancer) override;
  HdRprim* CreateRprim(const TfToken& typeId, const SdfPath& id) override;
  void DestroyRprim(HdRprim* rprim) override;
  HdSprim* CreateSprim(const TfToken& typeId, const SdfPath& id) override;
  HdSprim* CreateFallbackSprim(const TfToken& typeId) override;
  void DestroySprim(HdSprim* sprim) override;
  HdBprim* CreateBprim(const TfToken& typeId, const SdfPath& id) override;
  HdBprim* CreateFallbackBprim(const TfToken& typeId) override;
  void DestroyBprim(HdBprim* bprim) override;
  void CommitResources(HdChangeTracker* tracker) override;

  // Set by the active RenderSettings prim, which Hydra syncs by itself and before all Rprims.
  TfToken GetMaterialBindingPurpose() const override { return bindingPurpose_; }
  void SetMaterialBindingPurpose(const TfToken& purpose) { bindingPurpose_ = purpose; }
  TfTokenVector GetMaterialRenderContexts() const override;
  TfTokenVector GetShaderSourceTypes() const override;
  TfTokenVector GetRenderSettingsNamespaces() const override;
  // Kernels of materials pick what they read; AOVs may ask for any primvar.
  bool IsPrimvarFilteringNeeded() const override { return false; }
  HdAovDescriptor GetDefaultAovDescriptor(const TfToken& name) const override;

  // --- Products of the active RenderSettings prim. Rendered and written in batch only (enableInteractive is false, as
  // usdrecord and husk set it): shot after shot, each picture's files once it has converged. Hosts execute until the
  // pass has converged; the next execution renders the next shot.
  void SetProducts(const std::vector<Product>& products);
  std::optional<Shot> CurrentShot() const;  // none: the host's own picture
  bool IsLastShot() const;                  // the one that the host's buffers show
  void FirstShot();                         // the scene changed: all are to be rendered again
  void ShotStarted();
  // What the active RenderSettings prim includes, in batch; elsewhere the host's word counts.
  void SetIncludedPurposes(const SdfPath& settings, IncludedPurposes included);
  std::pair<SdfPath, IncludedPurposes> CurrentPurposes() const;
  bool WriteProducts();                     // false: another shot is to be rendered

 private:
  bool IsBatch() const;

  std::unique_ptr<RenderParam> param_;
  HdResourceRegistrySharedPtr registry_;
  TfToken bindingPurpose_ = HdTokens->full;
  mutable std::mutex productsMutex_;
  std::vector<Shot> shots_;
  std::pair<SdfPath, IncludedPurposes> included_;
  size_t written_ = 0;    // shots; the next one is rendered, or was
  bool toWrite_ = false;  // the shot is being rendered
};

}  // namespace hydra
