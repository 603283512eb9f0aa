// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The frame that a host shows, as it tells renderers since OpenUSD 24.08: in the scene globals of the terminal scene
// index, in scene-index mode and without (Hydra emulates one).
#pragma once

#include <optional>

#include <pxr/imaging/hd/renderIndex.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

struct HostTime {
  double frame = 0;
  double seconds = 0;
  bool operator==(const HostTime&) const = default;
};

// Nothing: the host tells none, or shows the default time.
std::optional<HostTime> ReadHostTime(const HdRenderIndex& index);

}  // namespace hydra
