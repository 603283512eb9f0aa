// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// What the refracting modes of generalized_schlick share: the index that its colour at normal incidence implies, and
// the Fresnel term across the interface. As in MaterialX, refraction bends by the mean of color0.
#ifndef WAVEFRONT_BSDF_SCHLICK_INTERFACE_GLSL
#define WAVEFRONT_BSDF_SCHLICK_INTERFACE_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "microfacet.glsl"

float schlickIndex(SchlickFresnel s)
{
    float r = sqrt(clamp(bsdfMean(s.f0), 0.0, 0.66)); // 0.66: index 9.7, the limit of ggxRefractiveIndex
    return ggxRefractiveIndex((1.0 + r) / (1.0 - r));
}

// Schlick's cosine is the one in the thinner medium; beyond the critical angle everything reflects.
vec3 fresnelSchlickInterface(float cosI, float eta, SchlickFresnel s)
{
    float cosT2 = 1.0 - (1.0 - cosI * cosI) / (eta * eta);
    vec3 f = fresnelSchlick(eta < 1.0 ? sqrt(max(cosT2, 0.0)) : cosI, s);
    return cosT2 > 0.0 ? f : vec3(1.0);
}

// (reflection, refraction), uncompensated; as rough as ggxDielectricAlbedo.
mat2x3 schlickAlbedo(vec3 wo, vec2 alpha, float eta, SchlickFresnel s)
{
    float cosO = abs(wo.z);
    float a = ggxViewAlpha(wo, alpha);
    GgxMean mean = ggxMean(cosO, a);
    vec2 inner = ggxInnerTransmission(cosO, a, eta);
    vec3 f = mean.share.x * fresnelSchlick(mean.cosine.x, s) + mean.share.y * fresnelSchlick(mean.cosine.y, s);
    // From the inside: the dielectric's share, by the colour at normal incidence.
    vec3 pass = eta > 1.0 ? vec3(1.0) - f : inner.x * (vec3(1.0) - s.f0) / max(1.0 - bsdfMean(s.f0), 0.1);
    pass = min(pass, vec3(1.0));
    return mat2x3((vec3(1.0) - pass) * mean.albedo, pass * (eta > 1.0 ? ggxRefractedShare(cosO, a, eta) : inner.y));
}

#endif
