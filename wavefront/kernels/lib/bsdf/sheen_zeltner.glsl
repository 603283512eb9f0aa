// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's sheen_bsdf, mode zeltner: Zeltner, Burley, Chiang 2022, "Practical multiple-scattering sheen using
// linearly transformed cosines". The fits of its tables are those published with MaterialX 1.39
// (x = cosine of wo, y = roughness). The lobe is albedo(wo) times a linearly transformed cosine in wo's azimuth.
// That cosine depends on wo alone, so the lobe is not reciprocal.
#ifndef WAVEFRONT_BSDF_SHEEN_ZELTNER_GLSL
#define WAVEFRONT_BSDF_SHEEN_ZELTNER_GLSL
#include "bsdf_common.glsl"

struct SheenZeltnerLobe {
    vec3 color;
    float roughness;
};

SheenZeltnerLobe sheenZeltnerMake(vec3 wo, vec3 color, float roughness)
{
    return SheenZeltnerLobe(bsdfClamp(color, 0.0, 1.0), bsdfClamp(roughness, 0.01, 1.0));
}

float sheenZeltnerReflectance(SheenZeltnerLobe l, vec3 wo)
{
    float x = min(abs(wo.z), 1.0);
    float y = l.roughness;
    float s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
    float m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
    float o = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y));
    float t = (x - m) / s;
    return clamp(exp(-0.5 * t * t) / (s * sqrt(2.0 * kBsdfPi)) + o, 0.0, 1.0);
}

// (a, b) of the inverse transform (x, y, z) -> (a x + b z, a y, z) in the frame where wo has azimuth 0.
vec2 sheenZeltnerTransform(SheenZeltnerLobe l, vec3 wo)
{
    float x = min(abs(wo.z), 1.0);
    float y = l.roughness;
    float a = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y);
    float b = sqrt(max(1.0 - x, 0.0)) * (y - 1.0) * y * y * y /
              (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
    return vec2(a, b);
}

// Unit azimuth of wo; any azimuth will do where wo is the normal.
vec2 sheenZeltnerAzimuth(vec3 wo)
{
    float s2 = dot(wo.xy, wo.xy);
    return s2 > 1e-12 ? wo.xy * inversesqrt(s2) : vec2(1.0, 0.0);
}

vec4 sheenZeltnerEval(SheenZeltnerLobe l, vec3 wo, vec3 wi)
{
    float cosI = wi.z * bsdfSide(wo);
    vec2 t = sheenZeltnerAzimuth(wo);
    vec2 ab = sheenZeltnerTransform(l, wo);
    vec3 w = vec3(ab.x * dot(t, wi.xy) + ab.y * cosI, ab.x * (t.x * wi.y - t.y * wi.x), cosI);
    float pdf = cosI * kBsdfInvPi * bsdfSquare(ab.x / max(dot(w, w), 1e-20));
    return cosI > 0.0 ? vec4(l.color * (sheenZeltnerReflectance(l, wo) * pdf), pdf) : vec4(0.0);
}

vec3 sheenZeltnerSample(SheenZeltnerLobe l, vec3 wo, vec3 u)
{
    vec3 w = bsdfSampleCosine(u.xy);
    vec2 t = sheenZeltnerAzimuth(wo);
    vec2 ab = sheenZeltnerTransform(l, wo);
    // The inverse of eval's transform, scaled by a: a is never negative and may be small.
    vec3 v = normalize(vec3(w.x - ab.y * w.z, w.y, max(ab.x * w.z, 1e-12)));
    return vec3(v.x * t.x - v.y * t.y, v.x * t.y + v.y * t.x, v.z * bsdfSide(wo));
}

vec3 sheenZeltnerAlbedo(SheenZeltnerLobe l, vec3 wo) { return l.color * sheenZeltnerReflectance(l, wo); }

vec3 sheenZeltnerThroughput(SheenZeltnerLobe l, vec3 wo) { return vec3(1.0 - sheenZeltnerReflectance(l, wo)); }

#endif
