// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Rays through a scene, apart from any render: how many a second the traversal does, and what it reads for them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "delegate/capture/captured_scene.h"
#include "wavefront/ray_caster.h"

namespace bench {

// All instances of a scene as one mesh in the world, at the first of their times; displacements are left out.
struct FlatScene {
  std::vector<wavefront::Float3> positions;
  std::vector<wavefront::UInt3> triangles;
};
constexpr uint64_t kMostFlatTriangles = 32'000'000;  // rays are cast through no more
wavefront::Result<FlatScene> Flatten(const delegate::CapturedScene& scene);

// No more than asked for, and about as many: whole images, through random points of the pixels, row by row, of a pinhole.
std::vector<wavefront::CasterRay> CameraRays(const wavefront::CameraData& camera, uint32_t width, uint32_t height, uint32_t count);
// From where the rays ended, on the side that they came from, in cosine-distributed directions; rays that hit nothing end.
std::vector<wavefront::CasterRay> Bounced(const FlatScene& scene, const std::vector<wavefront::CasterRay>& rays,
                                          const std::vector<wavefront::CasterHit>& hits, uint64_t seed);

struct RayMeasurement {
  std::string kind;                   // camera, bounce 1, bounce 2
  uint64_t rays = 0, hits = 0, overflows = 0;
  std::vector<double> seconds;        // on the device, of one cast of all rays; a run each
  wavefront::RayBytes bytes;          // a ray reads, caches apart
  double median() const;
  uint64_t triangles = 0;             // of the scene, flattened
  double bytesPerRay() const { return bytes.nodes + bytes.triangles; }
  double mrays() const { return static_cast<double>(rays) / median() * 1e-6; }
};

struct RayOptions {
  std::string device;
  uint32_t runs = 3;
  uint32_t rays = 0;
  double seconds = 0.25;              // of a run: casts one after the other, in one submission
};

// Camera rays, and two bounces of them. Nothing is sorted.
wavefront::Result<std::vector<RayMeasurement>> MeasureRays(const delegate::CapturedScene& scene, const RayOptions& options);

}  // namespace bench
