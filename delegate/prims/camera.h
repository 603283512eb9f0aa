// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// UsdGeomCamera's physical parameters to the window, lens and exposure that the core renders.
#pragma once

#include <optional>
#include <string>

#include "delegate/prims/gprim.h"
#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"

namespace delegate {

// Fallbacks are UsdGeomCamera's.
struct CameraParams {
  std::string projection = "perspective";  // perspective, orthographic
  float horizontalAperture = 20.955f, verticalAperture = 15.2908f;  // in apertureUnit
  float horizontalApertureOffset = 0, verticalApertureOffset = 0;
  float focalLength = 50;
  double apertureUnit = 0.1;               // scene units per aperture and focal length unit; 1 from Hydra, which has scaled
  float clippingNear = 1, clippingFar = 1000000;  // scene units
  // Camera space, scene units: (a, b, c, d) clips off points with a x + b y + c z + d < 0.
  std::vector<wavefront::Float4> clippingPlanes;
  float fStop = 0, focusDistance = 0;      // fStop 0: everything is sharp
  float exposure = 0, exposureTime = 1, exposureIso = 100, exposureFStop = 1, exposureResponsivity = 1;
  double shutterOpen = 0, shutterClose = 0;
};

struct CameraUpdate {
  std::optional<CameraParams> params;                          // the whole set
  std::optional<TimeSamples<wavefront::Matrix4d>> transforms;  // camera to world
};

// CameraUtilConformWindowPolicy.
enum class ConformPolicy { MatchVertically, MatchHorizontally, Fit, Crop, DontConform };
// UsdRender's and Hydra's names: expandAperture = fit, cropAperture = crop, adjustApertureWidth = matchVertically,
// adjustApertureHeight = matchHorizontally, adjustPixelAspectRatio = dontConform. Nothing for others.
std::optional<ConformPolicy> ParseConformPolicy(const std::string& token);

// imageAspect = width / height * pixel aspect ratio. Values that make no sense (no aperture, not finite ...) are
// replaced by the fallbacks; the sink is told.
wavefront::CameraData ConvertCamera(const std::string& path, const CameraParams& params,
                                    const TimeSamples<wavefront::Matrix4d>& transforms, double imageAspect,
                                    ConformPolicy policy, const wavefront::DiagnosticSink& sink);

// A part of the picture in fractions of its width and height, y up; it may reach beyond (overscan).
struct DataWindow {
  double left = 0, right = 1, bottom = 0, top = 1;
  bool operator==(const DataWindow&) const = default;
};
// The camera that sees that part alone.
void CropWindow(const DataWindow& part, wavefront::CameraData& camera);

// World to camera, and world to clip space (x, y, z in [-1, 1] after division by w); row vectors.
struct CameraMatrices {
  wavefront::Matrix4d worldToCamera, worldToNdc;
};
CameraMatrices MatricesOf(const wavefront::CameraData& camera);

}  // namespace delegate
