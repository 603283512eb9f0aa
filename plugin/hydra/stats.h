// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render statistics by the names that hosts read (usdview, husk, Blender), and the core's own.
#pragma once

#include <pxr/base/vt/dictionary.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

class RenderParam;

VtDictionary ToStats(const RenderParam& param);

}  // namespace hydra
