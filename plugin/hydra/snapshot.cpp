// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/snapshot.h"

#include <pxr/base/tf/diagnostic.h>

#include <vector>

namespace hydra {

Snapshot::Picture Snapshot::Newer(wavefront::Aov aov, uint64_t shown) {
  std::lock_guard lock(mutex_);
  // In this order: what is there after convergence was seen is the whole picture.
  const uint64_t version = this->version();
  const bool converged = core_.IsConverged();
  asked_.insert(aov);
  if (images_.empty() || version_ != version || complete_ != converged || shown >= moment_) {
    version_ = version;
    complete_ = converged;
    Take(aov);
  } else if (images_.count(aov) == 0) {
    // Asked for the first time: it joins the moment that is held, or it would lag behind the others from now on.
    if (auto image = core_.Map(aov); image) Keep(aov, std::move(image).value());
  }
  const auto found = images_.find(aov);
  return {found == images_.end() ? nullptr : found->second, moment_, version_, complete_};
}

void Snapshot::Take(wavefront::Aov aov) {
  images_.clear();
  ++moment_;
  std::vector<wavefront::Aov> aovs(asked_.begin(), asked_.end());
  auto taken = core_.Map(aovs);
  if (!taken && aovs.size() > 1) {  // one of them is no longer rendered
    asked_ = {aov};
    aovs = {aov};
    taken = core_.Map(aovs);
  }
  if (!taken) return;
  for (size_t i = 0; i < aovs.size(); ++i)
    Keep(aovs[i], std::move(taken.value()[i]));
}

void Snapshot::Keep(wavefront::Aov aov, wavefront::AovImage image) {
  if (aov == wavefront::Aov::Color)
    if (const wavefront::Status status = color_.Apply(core_.renderer(), image); !status)
      TF_WARN("hdWavefront: %s The image stays linear.", status.error().message.c_str());
  images_[aov] = std::make_shared<const wavefront::AovImage>(std::move(image));
}

bool Snapshot::SetColor(const ColorSettings& settings) {
  if (!color_.Set(settings)) return false;
  ++colorChanges_;
  return true;
}

void Snapshot::Reset() {
  std::lock_guard lock(mutex_);
  images_.clear();
  asked_.clear();
}

}  // namespace hydra
