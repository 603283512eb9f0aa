// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_camera.h"

#include <pxr/base/gf/range1f.h>

#include <algorithm>

#include "plugin/hydra/convert_value.h"

namespace hydra {
delegate::CameraParams ToCameraParams(const HdCamera& camera, const std::function<VtValue(const TfToken&)>& extra) {
  delegate::CameraParams params;
  params.projection = camera.GetProjection() == HdCamera::Orthographic ? "orthographic" : "perspective";
  params.horizontalAperture = camera.GetHorizontalAperture();
  params.verticalAperture = camera.GetVerticalAperture();
  params.horizontalApertureOffset = camera.GetHorizontalApertureOffset();
  params.verticalApertureOffset = camera.GetVerticalApertureOffset();
  params.focalLength = camera.GetFocalLength();
  params.apertureUnit = 1;  // Hydra has them in scene units
  params.clippingNear = camera.GetClippingRange().GetMin();
  params.clippingFar = camera.GetClippingRange().GetMax();
  for (const GfVec4d& plane : camera.GetClipPlanes()) {
    const GfVec4f p(plane);
    params.clippingPlanes.push_back({p[0], p[1], p[2], p[3]});
  }
  params.fStop = camera.GetFStop();
  params.focusDistance = camera.GetFocusDistance();
  params.shutterOpen = camera.GetShutterOpen();
  params.shutterClose = camera.GetShutterClose();
  params.exposure = camera.GetExposure();
  const std::pair<const char*, float delegate::CameraParams::*> physical[] = {
      {"exposure:time", &delegate::CameraParams::exposureTime},
      {"exposure:iso", &delegate::CameraParams::exposureIso},
      {"exposure:fStop", &delegate::CameraParams::exposureFStop},
      {"exposure:responsivity", &delegate::CameraParams::exposureResponsivity}};
  for (const auto& [name, member] : physical)
    if (const auto number = ToNumber(extra(TfToken(name)))) params.*member = static_cast<float>(*number);
  return params;
}

delegate::CameraParams ToCameraParams(const GfMatrix4d& projection) {
  delegate::CameraParams params;
  params.apertureUnit = 1;
  const GfMatrix4d& p = projection;
  const bool orthographic = p[2][3] == 0;
  params.projection = orthographic ? "orthographic" : "perspective";
  // The window is [l, r] x [b, t] at distance 1: p00 = 2 / (r - l), and the third row (perspective) or the fourth
  // (orthographic) holds its centre.
  const double width = 2 / p[0][0], height = 2 / p[1][1];
  const double x = orthographic ? -p[3][0] * width / 2 : p[2][0] * width / 2;
  const double y = orthographic ? -p[3][1] * height / 2 : p[2][1] * height / 2;
  params.focalLength = 1;
  params.horizontalAperture = static_cast<float>(width);
  params.verticalAperture = static_cast<float>(height);
  params.horizontalApertureOffset = static_cast<float>(x);
  params.verticalApertureOffset = static_cast<float>(y);
  const double a = p[2][2], b = p[3][2];
  const double zNear = orthographic ? (b + 1) / a : b / (a - 1), zFar = orthographic ? (b - 1) / a : b / (a + 1);
  params.clippingNear = static_cast<float>(std::min(zNear, zFar));
  params.clippingFar = static_cast<float>(std::max(zNear, zFar));
  return params;
}

delegate::ConformPolicy ToConformPolicy(CameraUtilConformWindowPolicy policy) {
  switch (policy) {
    case CameraUtilMatchVertically: return delegate::ConformPolicy::MatchVertically;
    case CameraUtilMatchHorizontally: return delegate::ConformPolicy::MatchHorizontally;
    case CameraUtilFit: return delegate::ConformPolicy::Fit;
    case CameraUtilCrop: return delegate::ConformPolicy::Crop;
    case CameraUtilDontConform: return delegate::ConformPolicy::DontConform;
  }
  return delegate::ConformPolicy::Fit;
}

PassFraming ToPassFraming(const CameraUtilFraming& framing, const GfVec4f& viewport) {
  PassFraming result;
  if (!framing.IsValid()) {
    result.width = static_cast<uint32_t>(std::max(viewport[2], 0.0f));
    result.height = static_cast<uint32_t>(std::max(viewport[3], 0.0f));
    return result;
  }
  const GfRect2i& data = framing.dataWindow;
  const GfRange2f& display = framing.displayWindow;
  result.width = static_cast<uint32_t>(std::max(data.GetWidth(), 0));
  result.height = static_cast<uint32_t>(std::max(data.GetHeight(), 0));
  result.pixelAspectRatio = framing.pixelAspectRatio > 0 ? framing.pixelAspectRatio : 1;
  result.x = data.GetMinX();
  result.y = data.GetMinY();
  const double left = display.GetMin()[0], upper = display.GetMin()[1];
  const double width = display.GetMax()[0] - left, height = display.GetMax()[1] - upper;
  if (!(width > 0) || !(height > 0)) return result;
  // Framing counts rows from the top.
  result.part.left = (data.GetMinX() - left) / width;
  result.part.right = (data.GetMinX() + data.GetWidth() - left) / width;
  result.part.top = 1 - (data.GetMinY() - upper) / height;
  result.part.bottom = 1 - (data.GetMinY() + data.GetHeight() - upper) / height;
  return result;
}

}  // namespace hydra
