// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Plain value types of the public facade. Layouts equal GLSL's vec2/vec3/vec4 with scalar block layout.
#pragma once

#include <array>
#include <cstdint>

namespace wavefront {

struct Float2 { float x = 0, y = 0; };
struct Float3 { float x = 0, y = 0, z = 0; };
struct Float4 { float x = 0, y = 0, z = 0, w = 0; bool operator==(const Float4&) const = default; };
struct UInt3 { uint32_t x = 0, y = 0, z = 0; };

// Affine or projective transform in double precision, row-vector convention as in USD's GfMatrix4d:
// p' = p * M, translation in m[3][0..2]. Stays double until the commit makes it relative to the scene's origin.
struct Matrix4d {
  std::array<std::array<double, 4>, 4> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
};

struct Bounds3 {
  Float3 min{3.402823466e+38f, 3.402823466e+38f, 3.402823466e+38f};
  Float3 max{-3.402823466e+38f, -3.402823466e+38f, -3.402823466e+38f};
};

}  // namespace wavefront
