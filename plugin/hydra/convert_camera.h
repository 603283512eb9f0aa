// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Cameras, and what a render pass looks at. Pure.
#pragma once

#include <functional>

#include <pxr/imaging/cameraUtil/conformWindow.h>
#include <pxr/imaging/cameraUtil/framing.h>
#include <pxr/imaging/hd/camera.h>

#include "delegate/prims/camera.h"
#include "delegate/render_delegate.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// What HdCamera holds after its Sync; `extra` answers for attributes that HdCamera does not keep ("exposure:time" ...).
// UsdImaging multiplies apertures and focal length by 0.1 (GfCamera::APERTURE_UNIT) and rounds to float. That is
// undone, so that the numbers are those that were authored, which the Python host reads.
delegate::CameraParams ToCameraParams(const HdCamera& camera, const std::function<VtValue(const TfToken&)>& extra);

// A camera of a pass that has none, or of hosts that only have matrices. The projection holds window and clipping
// range.
delegate::CameraParams ToCameraParams(const GfMatrix4d& projection);

delegate::ConformPolicy ToConformPolicy(CameraUtilConformWindowPolicy policy);

// Framing without display and data window is empty: the viewport counts.
struct PassFraming {
  uint32_t width = 0, height = 0;  // of the data window
  double pixelAspectRatio = 1;
  delegate::DataWindow part;       // where the data window lies in the display window
  int x = 0, y = 0;                // the data window's left column and upper row
  bool operator==(const PassFraming&) const = default;
};
PassFraming ToPassFraming(const CameraUtilFraming& framing, const GfVec4f& viewport);

}  // namespace hydra
