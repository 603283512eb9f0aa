// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Oren-Nayar diffuse reflection, energy_compensation = true: Fujii's improved Oren-Nayar with the multiple-scattering
// lobe of EON (Portsmouth, Kutz, Hill 2024, "EON: A practical energy-preserving rough diffuse BRDF", equations 10-22),
// which MaterialX 1.39 and OpenPBR use. A white surface reflects everything.
// One difference: MaterialX's GLSL clamps L.V at zero before it takes s, which costs energy between directions
// more than 90 degrees apart; here s is exact, so that the closed-form albedo is the lobe's albedo.
#ifndef WAVEFRONT_BSDF_OREN_NAYAR_COMPENSATED_GLSL
#define WAVEFRONT_BSDF_OREN_NAYAR_COMPENSATED_GLSL
#include "bsdf_common.glsl"

struct OrenNayarCompensatedLobe {
    vec3 color;
    vec3 multiColor; // albedo of the light that scattered more than once
    float a;         // the model's A, and B = A * roughness
    float b;
    float invMissing; // 1 / (1 - average single-scattering albedo)
};

OrenNayarCompensatedLobe orenNayarCompensatedMake(vec3 wo, vec3 color, float roughness)
{
    const float c1 = 0.5 - 2.0 / (3.0 * kBsdfPi);
    const float c2 = 2.0 / 3.0 - 28.0 / (15.0 * kBsdfPi);
    vec3 rho = bsdfClamp(color, 0.0, 1.0);
    float r = bsdfClamp(roughness, 0.0, 1.0);
    float a = 1.0 / (1.0 + c1 * r);
    float average = a * (1.0 + c2 * r);
    float missing = max(1.0 - average, 1e-6);
    return OrenNayarCompensatedLobe(rho, rho * rho * average / (vec3(1.0) - rho * missing), a, a * r, 1.0 / missing);
}

// Directional albedo of the single-scattering lobe for white (EON equation 11). Exact.
float orenNayarCompensatedSingle(OrenNayarCompensatedLobe l, float cosTheta)
{
    float c = clamp(cosTheta, 0.0, 1.0);
    float s = sqrt(max(1.0 - c * c, 0.0));
    float g = s * (acos(c) - s * c) + (2.0 / 3.0) * (s * c * (1.0 + s + s * s) / (1.0 + s) - s);
    return l.a + l.b * g * kBsdfInvPi;
}

vec4 orenNayarCompensatedEval(OrenNayarCompensatedLobe l, vec3 wo, vec3 wi)
{
    float cosO = abs(wo.z);
    float cosI = wi.z * bsdfSide(wo);
    float s = dot(wo.xy, wi.xy);
    float t = s > 0.0 ? s / max(max(cosO, cosI), 1e-6) : s;
    float missO = max(1.0 - orenNayarCompensatedSingle(l, cosO), 0.0);
    float missI = max(1.0 - orenNayarCompensatedSingle(l, cosI), 0.0);
    vec3 f = l.color * (l.a + l.b * t) + l.multiColor * (missO * missI * l.invMissing);
    float pdf = cosI * kBsdfInvPi;
    return cosI > 0.0 ? vec4(f * pdf, pdf) : vec4(0.0);
}

vec3 orenNayarCompensatedSample(OrenNayarCompensatedLobe l, vec3 wo, vec3 u)
{
    vec3 wi = bsdfSampleCosine(u.xy);
    return vec3(wi.xy, wi.z * bsdfSide(wo));
}

vec3 orenNayarCompensatedAlbedo(OrenNayarCompensatedLobe l, vec3 wo)
{
    return mix(l.multiColor, l.color, clamp(orenNayarCompensatedSingle(l, abs(wo.z)), 0.0, 1.0));
}

vec3 orenNayarCompensatedThroughput(OrenNayarCompensatedLobe l, vec3 wo) { return vec3(0.0); }

#endif
