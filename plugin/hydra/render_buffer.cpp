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
  if (complete_ && fetchedVersion_ == param_->snapshot().version()) return;
  const Snapshot::Picture picture = param_->snapshot().Newer(*aov_, moment_);
  moment_ = picture.moment;
  if (!picture.image) return;  // nothing was rendered yet
  CopyImage(*picture.image, x_, y_, width_, height_, format_, pixels_);
  fetchedVersion_ = picture.version;
  complete_ = picture.complete;
}

void RenderBuffer::Resolve() {
  std::lock_guard lock(mutex_);
  if (mappers_ != 0) return;
  Fetch();
  resolved_ = true;
}

// Hosts that resolve first want what they resolved; others just map.
void* RenderBuffer::Map() {
  std::lock_guard lock(mutex_);
  if (mappers_ == 0 && !resolved_) Fetch();
  ++mappers_;
  return pixels_.data();
}

void RenderBuffer::Unmap() {
  std::lock_guard lock(mutex_);
  if (mappers_ > 0) --mappers_;
  if (mappers_ == 0) resolved_ = false;
}

bool RenderBuffer::IsConverged() const { return param_->IsConverged(); }

}  // namespace hydra
