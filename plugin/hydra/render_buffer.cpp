// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_buffer.h"

#include <pxr/base/tf/diagnostic.h>

#include "plugin/hydra/render_param.h"

namespace hydra {

bool RenderBuffer::Allocate(const GfVec3i& dimensions, HdFormat format, bool) {
  std::lock_guard lock(mutex_);
  if (dimensions[0] < 0 || dimensions[1] < 0 || dimensions[2] != 1 || format == HdFormatInvalid) {
    TF_WARN("hdWavefront: a render buffer of %d x %d x %d is not possible (%s)", dimensions[0], dimensions[1],
            dimensions[2], GetId().GetText());
    return false;
  }
  width_ = static_cast<unsigned>(dimensions[0]);
  height_ = static_cast<unsigned>(dimensions[1]);
  format_ = format;
  complete_ = false;
  pixels_ = ClearedPixels(width_, height_, format_, clearValue_);
  return true;
}

void RenderBuffer::_Deallocate() {
  std::lock_guard lock(mutex_);
  width_ = height_ = 0;
  format_ = HdFormatInvalid;
  pixels_.clear();
  complete_ = false;
}

void RenderBuffer::Show(std::optional<wavefront::Aov> aov, const VtValue& clearValue, int x, int y) {
  std::lock_guard lock(mutex_);
  if (aov_ == aov && x_ == x && y_ == y && clearValue_ == clearValue) return;
  aov_ = aov;
  x_ = x;
  y_ = y;
  clearValue_ = clearValue;
  complete_ = false;
  pixels_ = ClearedPixels(width_, height_, format_, clearValue_);
}

void RenderBuffer::Fetch() {
  if (!aov_ || pixels_.empty()) return;
  delegate::RenderDelegate& core = param_->core();
  // In this order: what is there after convergence was seen is the whole picture.
  const uint64_t version = core.version();
  const bool converged = core.IsConverged();
  if (complete_ && fetchedVersion_ == version) return;
  const auto image = core.Map(*aov_);
  if (!image) return;  // nothing was rendered yet
  CopyImage(image.value(), x_, y_, width_, height_, format_, pixels_);
  fetchedVersion_ = version;
  complete_ = converged;
}

void RenderBuffer::Resolve() {
  std::lock_guard lock(mutex_);
  if (mappers_ == 0) Fetch();
}

void* RenderBuffer::Map() {
  std::lock_guard lock(mutex_);
  if (mappers_ == 0) Fetch();
  ++mappers_;
  return pixels_.data();
}

void RenderBuffer::Unmap() {
  if (mappers_ > 0) --mappers_;
}

bool RenderBuffer::IsConverged() const { return param_->IsConverged(); }

}  // namespace hydra
