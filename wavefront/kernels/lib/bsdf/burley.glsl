// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Disney diffuse (Burley 2012, "Physically-based shading at Disney", section 5.3), as MaterialX's burley_diffuse_bsdf.
// Not energy conserving: the published model reflects up to 1.034 at normal incidence and 1.56 at grazing incidence,
// at roughness 1. Kept as published.
#ifndef WAVEFRONT_BSDF_BURLEY_GLSL
#define WAVEFRONT_BSDF_BURLEY_GLSL
#include "bsdf_common.glsl"

struct BurleyLobe {
    vec3 color;
    float roughness;
};

BurleyLobe burleyMake(vec3 wo, vec3 color, float roughness)
{
    return BurleyLobe(bsdfClamp(color, 0.0, 1.0), bsdfClamp(roughness, 0.0, 1.0));
}

vec4 burleyEval(BurleyLobe l, vec3 wo, vec3 wi)
{
    float cosO = abs(wo.z);
    float cosI = wi.z * bsdfSide(wo);
    // F90 - 1 = 2 r cos^2(theta_d) - 0.5, and cos^2(theta_d) = (1 + wo.wi) / 2.
    float k = l.roughness * (1.0 + dot(wo, wi)) - 0.5;
    float shape = (1.0 + k * bsdfPow5(1.0 - min(cosO, 1.0))) * (1.0 + k * bsdfPow5(1.0 - min(cosI, 1.0)));
    float pdf = cosI * kBsdfInvPi;
    return cosI > 0.0 ? vec4(l.color * (shape * pdf), pdf) : vec4(0.0);
}

vec3 burleySample(BurleyLobe l, vec3 wo, vec3 u)
{
    vec3 wi = bsdfSampleCosine(u.xy);
    return vec3(wi.xy, wi.z * bsdfSide(wo));
}

// Exact: eval is a polynomial in cos wi once the azimuth is integrated out; the constants are Beta(n + 1, 6).
vec3 burleyAlbedo(BurleyLobe l, vec3 wo)
{
    const float b1 = 1.0 / 42.0, b2 = 1.0 / 168.0, b3 = 1.0 / 504.0;
    float c = min(abs(wo.z), 1.0);
    float w = bsdfPow5(1.0 - c);
    float p = l.roughness - 0.5;
    float q = l.roughness * c;
    float r2s2 = l.roughness * l.roughness * (1.0 - c * c);
    float linear = w * (p + q * (2.0 / 3.0)) + 2.0 * (p * b1 + q * b2);
    float quadratic = 2.0 * w * (p * p * b1 + 2.0 * p * q * b2 + q * q * b3 + 0.5 * r2s2 * (b1 - b3));
    return l.color * (1.0 + linear + quadratic);
}

vec3 burleyThroughput(BurleyLobe l, vec3 wo) { return vec3(0.0); }

#endif
