// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plugin/bench/random.h"

namespace bench {
namespace {

using namespace wavefront;

constexpr std::size_t kFewest = 512;      // rays of a kind worth measuring
constexpr uint32_t kMostCasts = 1000;     // in one submission

struct Vector {
  double x = 0, y = 0, z = 0;
};
Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator*(Vector a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double Dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector Cross(Vector a, Vector b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Vector Unit(Vector a) { return a * (1 / std::max(std::sqrt(Dot(a, a)), 1e-300)); }
Vector Wide(Float3 v) { return {v.x, v.y, v.z}; }
Float3 Narrow(Vector v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

// A row times the matrix; w 1: a place, 0: a direction.
Vector Transformed(const Matrix4d& m, Vector v, double w) {
  const auto column = [&](int c) { return v.x * m.m[0][c] + v.y * m.m[1][c] + v.z * m.m[2][c] + w * m.m[3][c]; };
  return {column(0), column(1), column(2)};
}

Vector OnSphere(Random& random) {
  const double z = 1 - 2.0 * random.Uniform(), phi = 6.283185307179586 * random.Uniform(), r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

Result<double> CastFor(RayCaster& caster, uint32_t casts) {
  auto seconds = caster.CastTimed(casts);
  if (!seconds) return seconds;
  return seconds.value() / casts;
}

Status Measure(RayCaster& caster, const RayOptions& options, RayMeasurement& m) {
  auto bytes = caster.CountBytes();
  if (!bytes) return bytes.error();
  m.bytes = bytes.value();
  auto first = CastFor(caster, 1);
  if (!first) return first.error();
  const auto casts = static_cast<uint32_t>(std::clamp(options.seconds / std::max(first.value(), 1e-6), 1.0, double{kMostCasts}));
  for (uint32_t run = 0; run < options.runs; ++run) {
    auto seconds = CastFor(caster, casts);
    if (!seconds) return seconds.error();
    m.seconds.push_back(seconds.value());
  }
  return {};
}

}  // namespace

double RayMeasurement::median() const {
  std::vector<double> sorted = seconds;
  std::sort(sorted.begin(), sorted.end());
  return sorted.empty() ? 0 : sorted[sorted.size() / 2];
}

Result<FlatScene> Flatten(const delegate::CapturedScene& scene) {
  uint64_t triangles = 0;
  for (const auto& [id, group] : scene.instances) triangles += group.transforms.size() * scene.meshes.at(group.mesh).triangles.size();
  if (triangles == 0) return Error{"There is nothing to cast rays at."};
  if (triangles > kMostFlatTriangles) return Error{"Rays are cast through one mesh: " + std::to_string(triangles) + " triangles of all instances are too many."};
  FlatScene flat;
  flat.triangles.reserve(triangles);
  for (const auto& [id, group] : scene.instances) {
    const MeshData& mesh = scene.meshes.at(group.mesh);
    for (const auto& times : group.transforms) {
      const auto base = static_cast<uint32_t>(flat.positions.size());
      for (const Float3& p : mesh.positions) flat.positions.push_back(Narrow(Transformed(times.front().value, Wide(p), 1)));
      for (const UInt3& t : mesh.triangles) flat.triangles.push_back({t.x + base, t.y + base, t.z + base});
    }
  }
  return flat;
}

std::vector<CasterRay> CameraRays(const CameraData& camera, uint32_t width, uint32_t height, uint32_t count) {
  const Matrix4d toWorld = camera.transforms.empty() ? Matrix4d() : camera.transforms.front().value;
  for (; uint64_t{width} * height > std::max(count, 1u); width = (width + 1) / 2) height = (height + 1) / 2;
  const auto passes = std::max<uint64_t>(1, count / std::max<uint64_t>(uint64_t{width} * height, 1));
  std::vector<CasterRay> rays;
  rays.reserve(passes * width * height);
  Random random(1);
  for (uint64_t pass = 0; pass < passes; ++pass)
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const double u = (x + random.Uniform()) / width, v = (y + random.Uniform()) / height;
        const Vector s{camera.left + u * (camera.right - camera.left), camera.top + v * (camera.bottom - camera.top), 0};
        const Vector o = camera.orthographic ? s : Vector{}, d = camera.orthographic ? Vector{0, 0, -1} : Vector{s.x, s.y, -1};
        rays.push_back({Narrow(Transformed(toWorld, o, 1)), 0, Narrow(Unit(Transformed(toWorld, d, 0))), std::numeric_limits<float>::infinity()});
      }
  return rays;
}

std::vector<CasterRay> Bounced(const FlatScene& scene, const std::vector<CasterRay>& rays, const std::vector<CasterHit>& hits, uint64_t seed) {
  double largest = 0;
  for (const Float3& p : scene.positions) largest = std::max({largest, std::abs(double{p.x}), std::abs(double{p.y}), std::abs(double{p.z})});
  Random random(seed);
  std::vector<CasterRay> bounced;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].triangle == kNoTriangle || std::isnan(hits[i].t)) continue;
    const UInt3& t = scene.triangles[hits[i].triangle];
    const Vector a = Wide(scene.positions[t.x]), b = Wide(scene.positions[t.y]), c = Wide(scene.positions[t.z]), d = Wide(rays[i].direction);
    Vector n = Unit(Cross(b - a, c - a));
    if (Dot(n, d) > 0) n = n * -1;
    // A point of the unit sphere that touches the surface: directions to it are distributed by the cosine.
    const Vector origin = Wide(rays[i].origin) + d * hits[i].t + n * (1e-5 * largest);
    bounced.push_back({Narrow(origin), 0, Narrow(Unit(n + OnSphere(random))), std::numeric_limits<float>::infinity()});
  }
  return bounced;
}

Result<std::vector<RayMeasurement>> MeasureRays(const delegate::CapturedScene& scene, const RayOptions& options) {
  auto flat = Flatten(scene);
  if (!flat) return flat.error();
  auto caster = RayCaster::Create(options.device, flat->positions, flat->triangles);
  if (!caster) return caster.error();
  std::vector<CasterRay> rays = CameraRays(scene.camera, scene.settings.width, scene.settings.height, options.rays);
  std::vector<RayMeasurement> measurements;
  for (const char* kind : {"camera", "bounce 1", "bounce 2"}) {
    if (rays.size() < kFewest && !measurements.empty()) break;
    RayMeasurement m;
    m.kind = kind;
    m.rays = rays.size();
    m.triangles = flat->triangles.size();
    if (Status s = (*caster)->SetRays(rays); !s) return s.error();
    if (Status s = Measure(**caster, options, m); !s) return s.error();
    auto hits = (*caster)->Hits();
    if (!hits) return hits.error();
    for (const CasterHit& hit : *hits) {
      m.hits += hit.triangle != kNoTriangle;
      m.overflows += std::isnan(hit.t);
    }
    measurements.push_back(std::move(m));
    rays = Bounced(*flat, rays, *hits, measurements.size() + 1);
  }
  return measurements;
}

}  // namespace bench
