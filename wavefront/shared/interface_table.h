// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Shape of the table of refracting GGX interfaces: resources/albedo/interface_table.cpp computes it when the project is
// built, lib/bsdf/interface_table.glsl reads it through a texel buffer.
//
// Entry [side][index][alpha][cosine]: side 0 = wo outside (light goes into the denser medium), 1 = wo inside.
// Coordinates are uniform on their grids; the warps put entries where the albedo changes quickly: grazing angles, the
// critical angle, indices near 1, small roughness. A texel (uvec2) is an entry and its neighbour in cosine; each is
// two unorm16:
//   low half:  R = albedo of the compensated reflection, the integral of F (1 + F (1 - E) / E) (Turquin 2019, eq. 16)
// high half: T / (1 - R), T = albedo of single-scattering refraction: what masking leaves of the light that gets
// through
#ifndef WAVEFRONT_SHARED_INTERFACE_TABLE_H
#define WAVEFRONT_SHARED_INTERFACE_TABLE_H

#ifdef __cplusplus
#include <cmath>
#include <cstdint>
namespace wavefront::layout {
#define WF_UINT constexpr uint32_t
#define WF_FLOAT constexpr float
#define WF_INLINE inline
using std::sqrt;
#else
#define WF_UINT const uint
#define WF_FLOAT const float
#define WF_INLINE
#endif

WF_UINT kInterfaceCosines = 24u;
WF_UINT kInterfaceAlphas = 16u;
WF_UINT kInterfaceIndices = 16u;
WF_UINT kInterfaceEntries = 2u * kInterfaceIndices * kInterfaceAlphas * kInterfaceCosines;
WF_FLOAT kInterfaceMinAlpha = 1e-3f;
WF_FLOAT kInterfaceMinRoot = 0.0705346f;  // root of (n - 1) / (n + 1) at index 1.01
WF_FLOAT kInterfaceMaxRoot = 0.9901f;     // at index 100

// How far from linear the grid of cosines outside is: near grazing the Fresnel term moves on this scale.
WF_INLINE float interfaceScale(float n) { return 0.3f * sqrt(n * n - 1.0f) / n + 0.02f; }

#ifdef __cplusplus
#undef WF_UINT
#undef WF_FLOAT
#undef WF_INLINE
}  // namespace wavefront::layout
#endif
#endif
