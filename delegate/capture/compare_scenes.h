// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What two hosts told the core differently of one stage.
#pragma once

#include <string>
#include <vector>

#include "delegate/capture/captured_scene.h"

namespace delegate {

// A line for each field that differs in a bit, with the first place where it does; empty: the same scene. Prims are told
// apart by path, textures and primvars by name, since ids follow the order of arrival. Kernels are compared by key: equal keys, equal
// GLSL. Ids of textures that stand in parameter blocks cannot be told from other values: where they alone differ, the
// textures were asked for in another order.
std::vector<std::string> CompareScenes(const CapturedScene& a, const CapturedScene& b);

}  // namespace delegate
