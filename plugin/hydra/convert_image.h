// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// AOVs: formats, and the core's images as Hydra's buffers have them. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <pxr/base/tf/token.h>
#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/aov.h>
#include <pxr/imaging/hd/types.h>

#include "plugin/hydra/hd_compat.h"
#include "wavefront/film.h"

namespace hydra {

// Invalid for what is not rendered: nothing is claimed that is not filled. "primvars:<name>" is any primvar.
HdAovDescriptor ToAovDescriptor(const TfToken& name);

// A buffer of the format, every pixel the clear value (numbers of any type; missing channels are 0).
std::vector<uint8_t> ClearedPixels(unsigned width, unsigned height, HdFormat format, const VtValue& clearValue);

// Copies an image (row 0 at the top) into a buffer whose row 0 is the bottom, its upper left corner at (x, y) counted
// from the buffer's upper left; what lies outside is cut off. Channels are converted; missing ones stay.
void CopyImage(const wavefront::AovImage& image, int x, int y, unsigned width, unsigned height, HdFormat format,
               std::vector<uint8_t>& pixels);

}  // namespace hydra
