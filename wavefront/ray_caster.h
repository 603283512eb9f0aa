// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Rays through a mesh by the renderer's trees and traversal, apart from any render: what the benchmark compares with
// other ray casters on the same rays.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/types.h"

namespace wavefront {

constexpr uint32_t kNoTriangle = ~0u;

struct CasterRay {
  Float3 origin;
  float tMin = 0;
  Float3 direction;
  float tMax = 0;
};

struct CasterHit {
  float t = 0;                      // tMax where nothing is hit; NaN where the ray took more steps than it may
  uint32_t triangle = kNoTriangle;  // in the mesh's order
};

// What a ray fetches, on average, in bytes: all of it, whatever a cache answers.
struct RayBytes {
  double nodes = 0, triangles = 0;
};

// One thread at a time.
class RayCaster {
 public:
  // `device` as in RendererOptions.
  static Result<std::unique_ptr<RayCaster>> Create(const std::string& device, std::span<const Float3> positions,
                                                   std::span<const UInt3> triangles);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  // The rays of the next casts; also runs them once, which compiles the kernel.
  Status SetRays(std::span<const CasterRay> rays);
  // Nearest hits of all rays; waits for the device.
  Status Cast();
  // As Cast, several times in one submission, with no host between; the device's seconds for all of them.
  Result<double> CastTimed(uint32_t casts);
  // By a kernel that counts; leaves the hits of a cast.
  Result<RayBytes> CountBytes();
  // Of the last cast.
  Result<std::vector<CasterHit>> Hits();

 private:
  struct Parts;
  explicit RayCaster(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace wavefront
