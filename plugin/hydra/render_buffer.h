// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include <pxr/imaging/hd/renderBuffer.h>

#include "plugin/hydra/convert_image.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

class RenderParam;

// Pixels that hosts map. The core holds the film; what is there so far is fetched when a host resolves or maps, from
// any thread, also while rendering.
class RenderBuffer final : public HdRenderBuffer {
 public:
  RenderBuffer(const SdfPath& id, RenderParam* param) : HdRenderBuffer(id), param_(param) {}
  ~RenderBuffer() override = default;

  bool Allocate(const GfVec3i& dimensions, HdFormat format, bool multiSampled) override;
  unsigned int GetWidth() const override { return width_; }
  unsigned int GetHeight() const override { return height_; }
  unsigned int GetDepth() const override { return 1; }
  HdFormat GetFormat() const override { return format_; }
  bool IsMultiSampled() const override { return false; }
  void* Map() override;
  void Unmap() override;
  bool IsMapped() const override { return mappers_ > 0; }
  void Resolve() override;
  bool IsConverged() const override;

  // What this buffer shows from now on, and where: the data window's left column and upper row. Nothing: the clear
  // value alone. Called by the render pass; equal calls keep what was fetched.
  void Show(std::optional<wavefront::Aov> aov, const VtValue& clearValue, int x, int y);

 protected:
  void _Deallocate() override;

 private:
  void Fetch();  // with mutex_ held

  RenderParam* param_;
  mutable std::mutex mutex_;
  std::atomic<int> mappers_{0};
  unsigned int width_ = 0, height_ = 0;
  HdFormat format_ = HdFormatInvalid;
  std::vector<uint8_t> pixels_;
  bool complete_ = false;
  bool resolved_ = false;                    // since it was mapped last: mapping then fetches nothing
  uint64_t moment_ = 0, fetchedVersion_ = 0;
  std::optional<wavefront::Aov> aov_;
  VtValue clearValue_;
  int x_ = 0, y_ = 0;
};

}  // namespace hydra
