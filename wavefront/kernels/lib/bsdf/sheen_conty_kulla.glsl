// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's sheen_bsdf, mode conty_kulla: the sheen of Estevez and Kulla 2017, "Production friendly microfacet
// sheen BRDF" (equation 2), with the smooth denominator of Neubelt and Pettineo 2013 and no masking, as MaterialX 1.39.
// Sampled uniformly over the hemisphere (Estevez and Kulla, section 4). At low roughness and grazing wo the published
// model reflects more than it receives.
#ifndef WAVEFRONT_BSDF_SHEEN_CONTY_KULLA_GLSL
#define WAVEFRONT_BSDF_SHEEN_CONTY_KULLA_GLSL
#include "bsdf_common.glsl"
#include "sheen_albedo.glsl"

struct SheenContyKullaLobe {
    vec3 color;
    float roughness;
};

SheenContyKullaLobe sheenContyKullaMake(vec3 wo, vec3 color, float roughness)
{
    return SheenContyKullaLobe(bsdfClamp(color, 0.0, 1.0), bsdfClamp(roughness, 0.005, 1.0));
}

vec4 sheenContyKullaEval(SheenContyKullaLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    float cosO = min(abs(wo.z), 1.0);
    float cosI = wi.z * side;
    vec3 h = wo + wi;
    float sin2 = clamp(dot(h.xy, h.xy) / max(dot(h, h), 1e-20), 0.0, 1.0);
    float invR = 1.0 / l.roughness;
    float d = (2.0 + invR) * pow(max(sin2, 1e-30), 0.5 * invR) * (0.5 * kBsdfInvPi);
    float f = 0.25 * d * cosI / max(cosI + cosO - cosI * cosO, 1e-6);
    return cosI > 0.0 ? vec4(l.color * f, 0.5 * kBsdfInvPi) : vec4(0.0);
}

vec3 sheenContyKullaSample(SheenContyKullaLobe l, vec3 wo, vec3 u)
{
    float z = 1.0 - u.x;
    float r = sqrt(max(1.0 - z * z, 0.0));
    float phi = 2.0 * kBsdfPi * u.y;
    return vec3(r * cos(phi), r * sin(phi), z * bsdfSide(wo));
}

vec3 sheenContyKullaAlbedo(SheenContyKullaLobe l, vec3 wo)
{
    return l.color * sheenContyKullaReflectance(min(abs(wo.z), 1.0), l.roughness);
}

// The fit's error (0.005) is taken off, so that sheen over a white base never gains energy by it, and a little more
// towards roughness 1: MaterialX layers with a fit that takes off 0.014 there, and pictures should agree within 1 %.
vec3 sheenContyKullaThroughput(SheenContyKullaLobe l, vec3 wo)
{
    float taken = 0.005 + 0.004 * l.roughness + sheenContyKullaReflectance(min(abs(wo.z), 1.0), l.roughness);
    return vec3(max(1.0 - taken, 0.0));
}

#endif
