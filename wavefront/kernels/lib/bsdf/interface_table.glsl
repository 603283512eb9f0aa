// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// A refracting interface of isotropic GGX, from the table that resources/albedo/interface_table.cpp computes (see
// shared/interface_table.h). Needs `lobeTable`, the binding of lib/bindings.glsl. Indices 1.01 to 100.
//
// Energy compensation of refraction: the reflection gets Turquin's factor, and refraction is scaled up so that it
// passes on everything that is not reflected: R + T = 1 for every wo. MaterialX leaves refraction uncompensated. Off
// the entries R errs by up to 0.03 at grazing wo and beside a critical angle (RMS 0.003), R + T by 0.01 (RMS 0.001
// outside, 0.005 inside; more at angles beyond 89 degrees inside of very rough bodies).
#ifndef WAVEFRONT_BSDF_INTERFACE_TABLE_GLSL
#define WAVEFRONT_BSDF_INTERFACE_TABLE_GLSL
#include "shared/interface_table.h"

struct GgxInterface {
    float reflected; // albedo of the compensated reflection
    float gain;      // by which single-scattering refraction is scaled
};

// eta = index beyond / index on wo's side.
GgxInterface ggxInterface(float cosO, float a, float eta)
{
    bool inside = eta < 1.0;
    float n = clamp(inside ? 1.0 / eta : eta, 1.01, 100.0);
    float k = interfaceScale(n);
    float critical = sqrt(1.0 - 1.0 / (n * n));
    float far = abs(cosO - critical) / (cosO < critical ? critical : 1.0 - critical);
    far = pow(far, 2.0 / 3.0);
    float p = inside ? 0.5 + 0.5 * (cosO < critical ? -far : far) : cosO * (1.0 + k) / (cosO + k);
    float low = sqrt(kInterfaceMinAlpha);
    vec3 at = vec3((sqrt((n - 1.0) / (n + 1.0)) - kInterfaceMinRoot) / (kInterfaceMaxRoot - kInterfaceMinRoot),
                   (sqrt(a) - low) / (1.0 - low), p);
    vec3 last = vec3(kInterfaceIndices, kInterfaceAlphas, kInterfaceCosines) - 1.0;
    at = clamp(at, 0.0, 1.0) * last;
    vec3 cell = min(floor(at), last - 1.0);
    at -= cell;
    uvec3 c = uvec3(cell);
    uint first = (((inside ? kInterfaceIndices : 0u) + c.x) * kInterfaceAlphas + c.y) * kInterfaceCosines + c.z;
    const uint nextAlpha = kInterfaceCosines, nextIndex = kInterfaceCosines * kInterfaceAlphas;
    uvec2 q00 = texelFetch(lobeTable, int(first)).xy, q01 = texelFetch(lobeTable, int(first + nextAlpha)).xy;
    uvec2 q10 = texelFetch(lobeTable, int(first + nextIndex)).xy;
    uvec2 q11 = texelFetch(lobeTable, int(first + nextIndex + nextAlpha)).xy;
    vec2 v00 = mix(unpackUnorm2x16(q00.x), unpackUnorm2x16(q00.y), at.z);
    vec2 v01 = mix(unpackUnorm2x16(q01.x), unpackUnorm2x16(q01.y), at.z);
    vec2 v10 = mix(unpackUnorm2x16(q10.x), unpackUnorm2x16(q10.y), at.z);
    vec2 v11 = mix(unpackUnorm2x16(q11.x), unpackUnorm2x16(q11.y), at.z);
    vec2 v = mix(mix(v00, v01, at.y), mix(v10, v11, at.y), at.x);
    return GgxInterface(v.x, 1.0 / max(v.y, 0.02));
}

#endif
