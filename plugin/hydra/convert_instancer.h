// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// An instancer's primvars as the delegate takes them. Pure.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <pxr/imaging/hd/sceneDelegate.h>

#include "delegate/prims/instancer.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// `primvars` are those of interpolation "instance"; `value` reads one, with its indices where it is indexed. Sets
// transforms, or positions, orientations and scales, and the primvars; the rest of the update is untouched. An
// instancer that says nothing of where its instances are leaves them where the prototype is: identity matrices, as many
// as `instanceCount`.
void ToInstances(const HdPrimvarDescriptorVector& primvars,
                 const std::function<VtValue(const HdPrimvarDescriptor&, VtIntArray*)>& value, size_t instanceCount,
                 delegate::InstancerUpdate& update);

}  // namespace hydra
