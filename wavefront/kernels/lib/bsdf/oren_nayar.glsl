// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Oren-Nayar diffuse reflection, energy_compensation = false: the qualitative model of Oren and Nayar 1994
// ("Generalization of Lambert's reflectance model", section 4.4), as MaterialX 1.39 has it. Roughness 0 is Lambert.
#ifndef WAVEFRONT_BSDF_OREN_NAYAR_GLSL
#define WAVEFRONT_BSDF_OREN_NAYAR_GLSL
#include "bsdf_common.glsl"

struct OrenNayarLobe {
    vec3 color;
    float a; // the model's A and B
    float b;
};

OrenNayarLobe orenNayarMake(vec3 wo, vec3 color, float roughness)
{
    float sigma2 = bsdfSquare(bsdfClamp(roughness, 0.0, 1.0));
    float a = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
    float b = 0.45 * sigma2 / (sigma2 + 0.09);
    return OrenNayarLobe(bsdfClamp(color, 0.0, 1.0), a, b);
}

vec4 orenNayarEval(OrenNayarLobe l, vec3 wo, vec3 wi)
{
    float cosO = abs(wo.z);
    float cosI = wi.z * bsdfSide(wo);
    // sin sin cos(phi) of the two directions, which are on the same side wherever this is used.
    float s = dot(wo.xy, wi.xy);
    float t = s > 0.0 ? s / max(max(cosO, cosI), 1e-6) : 0.0;
    float pdf = cosI * kBsdfInvPi;
    return cosI > 0.0 ? vec4(l.color * ((l.a + l.b * t) * pdf), pdf) : vec4(0.0);
}

vec3 orenNayarSample(OrenNayarLobe l, vec3 wo, vec3 u)
{
    vec3 wi = bsdfSampleCosine(u.xy);
    return vec3(wi.xy, wi.z * bsdfSide(wo));
}

// Exact: the integral of sin sin cos(phi) / max(cos, cos) over the half with cos(phi) > 0, in closed form.
vec3 orenNayarAlbedo(OrenNayarLobe l, vec3 wo)
{
    float c = min(abs(wo.z), 1.0);
    float s = sqrt(max(1.0 - c * c, 0.0));
    float g = s * kBsdfInvPi * (acos(c) - s * c + (2.0 / 3.0) * c * (1.0 + s + s * s) / (1.0 + s));
    return l.color * (l.a + l.b * g);
}

vec3 orenNayarThroughput(OrenNayarLobe l, vec3 wo) { return vec3(0.0); }

#endif
