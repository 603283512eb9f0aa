// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/prims/camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "delegate/prims/matrix.h"

namespace delegate {
namespace {

struct Window {
  double left, right, bottom, top;
};

// CameraUtilConformedWindow: grows or shrinks one side about the window's centre until its aspect is the image's.
Window Conform(Window w, ConformPolicy policy, double imageAspect) {
  const double width = w.right - w.left, height = w.top - w.bottom;
  if (policy == ConformPolicy::Fit)
    policy = width / height > imageAspect ? ConformPolicy::MatchHorizontally : ConformPolicy::MatchVertically;
  else if (policy == ConformPolicy::Crop)
    policy = width / height > imageAspect ? ConformPolicy::MatchVertically : ConformPolicy::MatchHorizontally;
  const double x = (w.left + w.right) / 2, y = (w.bottom + w.top) / 2;
  if (policy == ConformPolicy::MatchVertically) {
    const double half = height * imageAspect / 2;
    w.left = x - half;
    w.right = x + half;
  } else if (policy == ConformPolicy::MatchHorizontally) {
    const double half = width / imageAspect / 2;
    w.bottom = y - half;
    w.top = y + half;
  }
  return w;
}

// Replaces what no camera can have, and says so.
CameraParams Sanitized(const std::string& path, CameraParams p, const wavefront::DiagnosticSink& sink) {
  CameraParams fallback;
  const auto toUnit = static_cast<float>(fallback.apertureUnit / p.apertureUnit);
  for (float* const length : {&fallback.horizontalAperture, &fallback.verticalAperture, &fallback.focalLength})
    *length *= toUnit;
  const auto mend = [&](bool good, const char* what, auto& value, auto instead) {
    if (good) return;
    value = instead;
    sink({wavefront::Severity::Warning, "camera-bad-value", path,
          std::string(what) + " makes no sense; " + std::to_string(instead) + " is taken."});
  };
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  mend(positive(p.horizontalAperture), "horizontalAperture", p.horizontalAperture, fallback.horizontalAperture);
  mend(positive(p.verticalAperture), "verticalAperture", p.verticalAperture, fallback.verticalAperture);
  mend(positive(p.focalLength), "focalLength", p.focalLength, fallback.focalLength);
  mend(std::isfinite(p.horizontalApertureOffset), "horizontalApertureOffset", p.horizontalApertureOffset, 0.0f);
  mend(std::isfinite(p.verticalApertureOffset), "verticalApertureOffset", p.verticalApertureOffset, 0.0f);
  mend(std::isfinite(p.clippingNear), "clippingRange", p.clippingNear, fallback.clippingNear);
  mend(!std::isnan(p.clippingFar) && p.clippingFar > p.clippingNear, "clippingRange", p.clippingFar,
       std::max(fallback.clippingFar, p.clippingNear * 2));
  mend(std::isfinite(p.fStop) && p.fStop >= 0, "fStop", p.fStop, 0.0f);
  mend(std::isfinite(p.focusDistance) && p.focusDistance >= 0, "focusDistance", p.focusDistance, 0.0f);
  mend(std::isfinite(p.exposure), "exposure", p.exposure, 0.0f);
  mend(std::isfinite(p.exposureTime) && p.exposureTime >= 0, "exposure:time", p.exposureTime, 1.0f);
  mend(std::isfinite(p.exposureIso) && p.exposureIso >= 0, "exposure:iso", p.exposureIso, 100.0f);
  mend(positive(p.exposureFStop), "exposure:fStop", p.exposureFStop, 1.0f);
  mend(std::isfinite(p.exposureResponsivity) && p.exposureResponsivity >= 0, "exposure:responsivity",
       p.exposureResponsivity, 1.0f);
  if (p.projection != "perspective" && p.projection != "orthographic") {
    sink({wavefront::Severity::Warning, "camera-bad-value", path,
          "projection \"" + p.projection + "\" is not known; perspective is taken."});
    p.projection = "perspective";
  }
  return p;
}

// In single precision, as UsdImaging does it before Hydra's cameras arrive (usdImaging/cameraAdapter.cpp and
// dataSourceCamera.cpp): the same camera through any host is the same window to the bit.
CameraParams InSceneUnits(CameraParams p) {
  const auto unit = static_cast<float>(p.apertureUnit);
  for (float* const length : {&p.horizontalAperture, &p.verticalAperture, &p.horizontalApertureOffset,
                              &p.verticalApertureOffset, &p.focalLength})
    *length *= unit;
  p.apertureUnit = 1;
  return p;
}

}  // namespace

std::optional<ConformPolicy> ParseConformPolicy(const std::string& token) {
  if (token == "fit" || token == "expandAperture") return ConformPolicy::Fit;
  if (token == "crop" || token == "cropAperture") return ConformPolicy::Crop;
  if (token == "matchVertically" || token == "adjustApertureWidth") return ConformPolicy::MatchVertically;
  if (token == "matchHorizontally" || token == "adjustApertureHeight") return ConformPolicy::MatchHorizontally;
  if (token == "dontConform" || token == "adjustPixelAspectRatio") return ConformPolicy::DontConform;
  return std::nullopt;
}

wavefront::CameraData ConvertCamera(const std::string& path, const CameraParams& authored,
                                    const TimeSamples<Matrix4d>& transforms, double imageAspect, ConformPolicy policy,
                                    const wavefront::DiagnosticSink& sink) {
  const CameraParams p = InSceneUnits(Sanitized(path, authored, sink));
  wavefront::CameraData camera;
  camera.orthographic = p.projection == "orthographic";
  camera.transforms = transforms;
  for (auto& sample : camera.transforms)
    if (!IsFinite(sample.value) || IsSingular3(sample.value)) {
      sink({wavefront::Severity::Warning, "camera-singular-transform", path,
            "The camera's transform cannot be inverted; the identity is taken."});
      sample.value = {};
    }

  // GfCamera::GetFrustum: the window lies on the plane at distance 1 (perspective), or is the aperture in scene units.
  const double unit = camera.orthographic ? 1 : 1 / double{p.focalLength};
  const double halfWidth = p.horizontalAperture * unit / 2, halfHeight = p.verticalAperture * unit / 2;
  const double x = p.horizontalApertureOffset * unit, y = p.verticalApertureOffset * unit;
  const Window window = Conform({x - halfWidth, x + halfWidth, y - halfHeight, y + halfHeight}, policy, imageAspect);
  camera.left = static_cast<float>(window.left);
  camera.right = static_cast<float>(window.right);
  camera.bottom = static_cast<float>(window.bottom);
  camera.top = static_cast<float>(window.top);

  // Perspective rays start in the eye: nothing lies behind it. Orthographic ones may begin behind the camera.
  camera.nearClip = camera.orthographic ? p.clippingNear : std::max(p.clippingNear, 0.0f);
  camera.farClip = std::min(p.clippingFar, 3.4e38f);
  for (const wavefront::Float4& plane : p.clippingPlanes) {
    const bool finite = std::isfinite(plane.x) && std::isfinite(plane.y) && std::isfinite(plane.z) && std::isfinite(plane.w);
    if (!finite || (plane.x == 0 && plane.y == 0 && plane.z == 0)) {
      sink({wavefront::Severity::Warning, "camera-bad-value", path, "A clipping plane has no direction; it is ignored."});
    } else if (camera.clipPlanes.size() == wavefront::CameraData::kMaxClipPlanes) {
      sink({wavefront::Severity::Warning, "camera-clipping-planes", path,
            "More than " + std::to_string(wavefront::CameraData::kMaxClipPlanes) +
                " clipping planes are not supported; the others are ignored."});
      break;
    } else {
      camera.clipPlanes.push_back(plane);
    }
  }
  if (p.fStop > 0 && !camera.orthographic) {
    if (p.focusDistance > 0) {
      // The aperture's diameter is focal length / f-number.
      camera.lensRadius = static_cast<float>(p.focalLength / (2 * double{p.fStop}));
      camera.focusDistance = p.focusDistance;
    } else {
      sink({wavefront::Severity::Warning, "camera-bad-value", path,
            "fStop is set but focusDistance is not; everything is in focus."});
    }
  }
  // UsdGeomCamera::ComputeLinearExposureScale.
  const double fStop = p.exposureFStop;
  camera.exposureScale = static_cast<float>(double{p.exposureTime} * p.exposureIso / 100 *
                                            std::exp2(double{p.exposure}) * p.exposureResponsivity / (fStop * fStop));
  if (!std::isfinite(camera.exposureScale)) {
    sink({wavefront::Severity::Warning, "camera-bad-value", path, "The exposure is beyond any number; 1 is taken."});
    camera.exposureScale = 1;
  }
  camera.shutterOpen = static_cast<float>(p.shutterOpen);
  camera.shutterClose = static_cast<float>(p.shutterClose);
  return camera;
}

void CropWindow(const DataWindow& part, wavefront::CameraData& camera) {
  if (part == DataWindow()) return;
  const double l = camera.left, r = camera.right, b = camera.bottom, t = camera.top;
  camera.left = static_cast<float>(l + (r - l) * part.left);
  camera.right = static_cast<float>(l + (r - l) * part.right);
  camera.bottom = static_cast<float>(b + (t - b) * part.bottom);
  camera.top = static_cast<float>(b + (t - b) * part.top);
}

CameraMatrices MatricesOf(const wavefront::CameraData& camera) {
  CameraMatrices result;
  if (!camera.transforms.empty()) result.worldToCamera = Inverse(camera.transforms.front().value);
  const double l = camera.left, r = camera.right, b = camera.bottom, t = camera.top;
  const double n = camera.nearClip, f = camera.farClip;
  // Row vectors; OpenGL's clip space, x, y and z in [-1, 1] after division.
  Matrix4d projection;
  if (camera.orthographic) {
    projection.m = {{{2 / (r - l), 0, 0, 0},
                     {0, 2 / (t - b), 0, 0},
                     {0, 0, -2 / (f - n), 0},
                     {-(r + l) / (r - l), -(t + b) / (t - b), -(f + n) / (f - n), 1}}};
  } else {
    const double zNear = std::max(n, f * 1e-12);  // a near plane in the eye has no projection
    projection.m = {{{2 / (r - l), 0, 0, 0},
                     {0, 2 / (t - b), 0, 0},
                     {(r + l) / (r - l), (t + b) / (t - b), -(f + zNear) / (f - zNear), -1},
                     {0, 0, -2 * f * zNear / (f - zNear), 0}}};
  }
  result.worldToNdc = Multiply(result.worldToCamera, projection);
  return result;
}

}  // namespace delegate
