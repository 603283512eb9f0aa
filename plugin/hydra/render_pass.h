// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <optional>

#include <pxr/imaging/hd/renderPass.h>

#include "plugin/hydra/convert_camera.h"
#include "plugin/hydra/hd_compat.h"
#include "plugin/hydra/host_time.h"
#include "plugin/hydra/products.h"

namespace hydra {

class RenderBuffer;
class RenderDelegate;

// Tells the core what is looked at and which AOVs are wanted, commits what was edited, and starts the render in the
// background. Hosts execute it again and again: where nothing changed, it does nothing.
class RenderPass final : public HdRenderPass {
 public:
  RenderPass(HdRenderIndex* index, const HdRprimCollection& collection, RenderDelegate* owner);
  ~RenderPass() override;
  bool IsConverged() const override;

 protected:
  void _Execute(const HdRenderPassStateSharedPtr& renderPassState, const TfTokenVector& renderTags) override;

 private:
  // What an execution asks for; compared with the last one.
  struct Wish {
    std::string camera;                 // path; empty: the matrices
    GfMatrix4d view{1}, projection{1};  // where there is no camera
    bool depthOfField = true;
    PassFraming framing;
    delegate::ConformPolicy policy = delegate::ConformPolicy::Fit;
    std::vector<std::string> renderTags;
    std::vector<std::string> aovs;  // tokens
    bool operator==(const Wish&) const = default;
  };
  void FollowHost();  // its frame becomes the settings of that name
  Wish ReadState(const HdRenderPassState& state, const TfTokenVector& renderTags) const;
  void Look(const ProductView& view, const SdfPath& product, Wish& wish) const;
  // What the bindings and the shot's products ask for by token, each once, sorted; what is not rendered is told of.
  std::vector<std::string> AovTokens(const HdRenderPassAovBindingVector& bindings,
                                     const std::optional<Shot>& shot) const;
  // Purposes that the RenderSettings prim includes and the host's tags leave out, where prims have them.
  void ReportTags(const TfTokenVector& ofHost) const;
  // The core's camera for the wish: the prim itself, or one that is made of it.
  std::string SyncCamera(const Wish& wish) const;
  RenderBuffer* BufferOf(const HdRenderPassAovBinding& binding) const;

  RenderDelegate* owner_;
  std::optional<Wish> last_;
  std::optional<HostTime> time_;
};

}  // namespace hydra
