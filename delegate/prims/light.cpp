// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/prims/light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "delegate/mesh/mesh_math.h"
#include "delegate/prims/matrix.h"

namespace delegate {
namespace {

using wavefront::Float3;
using wavefront::LightType;
constexpr double kPi = std::numbers::pi;

double Radians(double degrees) { return degrees * kPi / 180; }

std::optional<LightType> ParseType(const std::string& type) {
  if (type == "RectLight") return LightType::Rect;
  if (type == "DiskLight") return LightType::Disk;
  if (type == "SphereLight") return LightType::Sphere;
  if (type == "CylinderLight") return LightType::Cylinder;
  if (type == "DistantLight") return LightType::Distant;
  if (type == "DomeLight" || type == "DomeLight_1") return LightType::Dome;
  return std::nullopt;
}

bool HasShape(LightType type) { return type != LightType::Distant && type != LightType::Dome; }

Vec3 Row(const Matrix4d& m, int row) { return {m.m[row][0], m.m[row][1], m.m[row][2]}; }

// How much a surface element with the unit normal n grows under the matrix: |cofactor(M) n|. With row vectors, a plane
// spanned by unit u, v (n = u x v) becomes the one spanned by uM, vM.
double AreaStretch(const Matrix4d& m, const Vec3& n) {
  const Vec3 x = Row(m, 0), y = Row(m, 1), z = Row(m, 2);
  return Length(Cross(y, z) * n.x + Cross(z, x) * n.y + Cross(x, y) * n.z);
}

// Mean of AreaStretch over all directions. The integrand is smooth and periodic around, so the trapezoid rule converges
// geometrically; along the axis the nodes of Gauss-Legendre would save little over a midpoint rule this fine.
double MeanStretchOverSphere(const Matrix4d& m) {
  constexpr int kAlong = 512, kAround = 256;
  double sum = 0;
  for (int i = 0; i < kAlong; ++i) {
    const double z = -1 + (i + 0.5) * 2 / kAlong, r = std::sqrt(1 - z * z);
    for (int j = 0; j < kAround; ++j) {
      const double phi = 2 * kPi * j / kAround;
      sum += AreaStretch(m, {r * std::cos(phi), r * std::sin(phi), z});
    }
  }
  return sum / (double{kAlong} * kAround);
}

// The same over the normals of a cylinder along X.
double MeanStretchAroundX(const Matrix4d& m) {
  constexpr int kAround = 1024;
  double sum = 0;
  for (int j = 0; j < kAround; ++j) {
    const double phi = 2 * kPi * j / kAround;
    sum += AreaStretch(m, {0, std::cos(phi), std::sin(phi)});
  }
  return sum / kAround;
}

// Rotation and even scale only: every area grows by the same factor, exactly.
std::optional<double> EvenStretch(const Matrix4d& m) {
  const Vec3 x = Row(m, 0), y = Row(m, 1), z = Row(m, 2);
  const double xx = Dot(x, x), tolerance = 1e-9 * xx;
  if (std::abs(Dot(y, y) - xx) > tolerance || std::abs(Dot(z, z) - xx) > tolerance || std::abs(Dot(x, y)) > tolerance ||
      std::abs(Dot(y, z)) > tolerance || std::abs(Dot(z, x)) > tolerance)
    return std::nullopt;
  return xx;
}

bool FiniteParams(const LightParams& p) {
  const LightShaping shaping = p.shaping.value_or(LightShaping());
  for (float v : {p.intensity, p.exposure, p.color.x, p.color.y, p.color.z, p.colorTemperature, p.diffuse, p.specular,
                  p.width, p.height, p.radius, p.length, p.angle, shaping.coneAngle, shaping.coneSoftness,
                  shaping.focus, shaping.focusTint.x, shaping.focusTint.y, shaping.focusTint.z})
    if (!std::isfinite(v)) return false;
  return true;
}

// Says what of the light is not rendered as authored.
void ReportUnsupported(const std::string& path, LightType type, const LightParams& p,
                       const wavefront::DiagnosticSink& sink) {
  const auto tell = [&](const std::string& what) {
    sink({wavefront::Severity::Warning, "light-unsupported-input", path, what});
  };
  if (p.diffuse != 1) tell("inputs:diffuse is not supported and is taken as 1.");
  if (p.specular != 1) tell("inputs:specular is not supported and is taken as 1.");
  if (p.shaping) {
    if (!p.shaping->iesFile.empty())
      tell("inputs:shaping:ies:file is not supported; the light shines without its profile.");
    if (!HasShape(type)) tell("Shaping has no meaning for distant and dome lights and is ignored.");
  }
  if (type == LightType::Dome && p.textureFormat != "automatic" && p.textureFormat != "latlong")
    tell("texture:format \"" + p.textureFormat + "\" is not supported; the texture is read as latlong.");
  if (type == LightType::Dome && p.poleAxis != "Y" && p.poleAxis != "Z")
    tell("poleAxis \"" + p.poleAxis + "\" is not known; Y is taken.");
}

// A light without extent that may be treated as a point or line still has power if it is normalised: it is rendered as
// this small a shape. The value is in light space.
constexpr float kPointRadius = 1e-3f;

LightParams GiveExtent(LightType type, LightParams p) {
  if (p.normalize && p.radius == 0 &&
      ((type == LightType::Sphere && p.treatAsPoint) || (type == LightType::Cylinder && p.treatAsLine)))
    p.radius = kPointRadius;
  return p;
}

bool HasExtent(LightType type, const LightParams& p) {
  switch (type) {
    case LightType::Rect: return p.width > 0 && p.height > 0;
    case LightType::Disk:
    case LightType::Sphere: return p.radius > 0;
    case LightType::Cylinder: return p.radius > 0 && p.length > 0;
    case LightType::Distant: return p.angle >= 0;
    case LightType::Dome: return true;
  }
  return false;
}

}  // namespace

Float3 BlackbodyTemperatureAsRgb(float kelvin) {
  // OpenUSD's reference (UsdLuxBlackbodyTemperatureAsRgb): colours of John Walker's specrend for Rec. 709 in steps of
  // 500 K, joined by a Catmull-Rom spline whose end knots stand twice, divided by their luminance, then cut at zero.
  constexpr int kSegments = 18;
  static constexpr double kKnots[kSegments + 1][3] = {
      {1.000000, 0.027490, 0.000000}, {1.000000, 0.149664, 0.000000}, {1.000000, 0.256644, 0.008095},
      {1.000000, 0.372033, 0.067450}, {1.000000, 0.476725, 0.153601}, {1.000000, 0.570376, 0.259196},
      {1.000000, 0.653480, 0.377155}, {1.000000, 0.726878, 0.501606}, {1.000000, 0.791543, 0.628050},
      {1.000000, 0.848462, 0.753228}, {1.000000, 0.898581, 0.874905}, {1.000000, 0.942771, 0.991642},
      {0.906947, 0.890456, 1.000000}, {0.828247, 0.841838, 1.000000}, {0.765791, 0.801896, 1.000000},
      {0.715255, 0.768579, 1.000000}, {0.673683, 0.740423, 1.000000}, {0.638992, 0.716359, 1.000000},
      {0.609681, 0.695588, 1.000000}};
  const double position = std::clamp((double{kelvin} - 1000) / 9000, 0.0, 1.0) * kSegments;
  const int segment = std::min(static_cast<int>(position), kSegments - 1);
  const double t = position - segment;
  double rgb[3];
  for (int c = 0; c < 3; ++c) {
    const auto knot = [&](int i) { return kKnots[std::clamp(i, 0, kSegments)][c]; };
    const double p0 = knot(segment - 1), p1 = knot(segment), p2 = knot(segment + 1), p3 = knot(segment + 2);
    rgb[c] = p1 + 0.5 * t * ((p2 - p0) + t * ((2 * p0 - 5 * p1 + 4 * p2 - p3) + t * (3 * (p1 - p2) + p3 - p0)));
  }
  const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  for (double& c : rgb) c = std::max(c / luminance, 0.0);
  return ToFloat3({rgb[0], rgb[1], rgb[2]});
}

double LightSizeFactor(const LightParams& p, const Matrix4d& lightToWorld) {
  const std::optional<LightType> type = ParseType(p.type);
  if (!type) return 1;
  const std::optional<double> even = EvenStretch(lightToWorld);
  const double radius = p.radius;
  switch (*type) {
    case LightType::Rect: return double{p.width} * p.height * AreaStretch(lightToWorld, {0, 0, 1});
    case LightType::Disk: return kPi * radius * radius * AreaStretch(lightToWorld, {0, 0, 1});
    case LightType::Sphere:
      return 4 * kPi * radius * radius * (even ? *even : MeanStretchOverSphere(lightToWorld));
    case LightType::Cylinder:
      return 2 * kPi * radius * p.length * (even ? *even : MeanStretchAroundX(lightToWorld));
    case LightType::Distant: {
      if (p.angle == 0) return 1;
      const double sine = std::sin(Radians(std::min(p.angle, 180.0f)) / 2);
      return kPi * sine * sine;
    }
    case LightType::Dome: return 1;
  }
  return 1;
}

std::optional<wavefront::LightData> ConvertLight(const std::string& path, const LightParams& authored,
                                                 const TimeSamples<Matrix4d>& transforms,
                                                 const wavefront::DiagnosticSink& sink) {
  const auto skip = [&](const char* code, const std::string& why) {
    sink({wavefront::Severity::Warning, code, path, why + " The light does not shine."});
    return std::nullopt;
  };
  const std::optional<LightType> type = ParseType(authored.type);
  if (!type) return skip("light-unknown-type", "Lights of type \"" + authored.type + "\" are not supported.");
  if (!FiniteParams(authored)) return skip("light-not-finite", "An input is not a finite number.");
  for (const auto& sample : transforms)
    if (!IsFinite(sample.value) || IsSingular3(sample.value))
      return skip("light-singular-transform", "Its transform cannot be inverted.");
  const LightParams p = GiveExtent(*type, authored);
  if (!HasExtent(*type, p)) return skip("light-zero-size", "It has no size.");
  ReportUnsupported(path, *type, p, sink);

  double scale = double{p.intensity} * std::exp2(double{p.exposure});
  if (p.normalize) {
    const double size = LightSizeFactor(p, transforms.front().value);
    if (!(size > 0) || !std::isfinite(size))
      return skip("light-zero-size", "Its area in the world is zero or not finite.");
    scale /= size;
  }
  Vec3 radiance = Vec3(p.color) * scale;
  if (p.enableColorTemperature) {
    const Vec3 blackbody(BlackbodyTemperatureAsRgb(p.colorTemperature));
    radiance = {radiance.x * blackbody.x, radiance.y * blackbody.y, radiance.z * blackbody.z};
  }
  // Beyond float there is no light that a film could hold.
  for (double v : {radiance.x, radiance.y, radiance.z})
    if (!(std::abs(v) <= 1e30)) return skip("light-not-finite", "Its radiance is beyond any sensible number.");
  if (radiance.x < 0 || radiance.y < 0 || radiance.z < 0) {
    sink({wavefront::Severity::Warning, "light-negative", path,
          "Negative light is not supported; it is taken as zero."});
    radiance = {std::max(radiance.x, 0.0), std::max(radiance.y, 0.0), std::max(radiance.z, 0.0)};
  }

  wavefront::LightData light;
  light.path = path;
  light.type = *type;
  light.transforms = transforms;
  light.radiance = ToFloat3(radiance);
  light.width = p.width;
  light.height = p.height;
  light.radius = p.radius;
  light.length = p.length;
  light.angle = static_cast<float>(Radians(std::min(p.angle, 360.0f)));
  if (p.shaping && HasShape(*type)) {
    light.coneAngle = static_cast<float>(Radians(std::max(p.shaping->coneAngle, 0.0f)));
    light.coneSoftness = std::clamp(p.shaping->coneSoftness, 0.0f, 1.0f);
    light.focus = std::max(p.shaping->focus, 0.0f);
    light.focusTint = p.shaping->focusTint;
  }
  light.visibleToCamera = p.visibleToCamera;
  light.castsShadows = p.shadowEnable;
  if (*type == LightType::Dome && p.poleAxis == "Z") {
    // UsdLuxDomeLight_1: the texture's pole (+Y) stands on +Z: a quarter turn about X comes first.
    Matrix4d turn;
    turn.m[1] = {0, 0, 1, 0};
    turn.m[2] = {0, -1, 0, 0};
    for (auto& sample : light.transforms) sample.value = Multiply(turn, sample.value);
  }
  return light;
}

}  // namespace delegate
