// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Primvars as the delegate takes them. Pure.
#pragma once

#include <optional>
#include <string>

#include <pxr/base/tf/token.h>
#include <pxr/base/vt/array.h>
#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/enums.h>

#include "delegate/mesh/mesh_input.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

const char* ToInterpolation(HdInterpolation interpolation);

// False for points, skinning, and other renderers' settings: nothing that a material reads.
bool IsShadingPrimvar(const TfToken& name);

// Nothing for values that hold no numbers, and for matrices.
std::optional<delegate::PrimvarInput> ToPrimvar(const TfToken& name, const char* interpolation, const VtValue& value,
                                                const VtIntArray& indices);

}  // namespace hydra
