// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// What the refracting modes of generalized_schlick share: the index that its colour at normal incidence implies, the
// Fresnel term across the interface, and its energy. As in MaterialX, refraction bends by the mean of color0.
#ifndef WAVEFRONT_BSDF_SCHLICK_INTERFACE_GLSL
#define WAVEFRONT_BSDF_SCHLICK_INTERFACE_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "interface_table.glsl"
#include "microfacet.glsl"
#include "thin_film.glsl"

float schlickIndex(SchlickFresnel s)
{
    float r = sqrt(clamp(bsdfMean(s.f0), 0.0, 0.66)); // 0.66: index 9.7, the limit of ggxRefractiveIndex
    return ggxRefractiveIndex((1.0 + r) / (1.0 - r));
}

// Schlick's cosine is the one in the thinner medium; beyond the critical angle everything reflects.
vec3 fresnelSchlickInterface(float cosI, float eta, SchlickFresnel s, vec2 film)
{
    float cosT2 = 1.0 - (1.0 - cosI * cosI) / (eta * eta);
    vec3 f = fresnelSchlick(eta < 1.0 ? sqrt(max(cosT2, 0.0)) : cosI, s, film);
    return cosT2 > 0.0 ? f : vec3(1.0);
}

// Albedo of the compensated reflection; `reflected` is that of the dielectric of the same index. Refraction is scaled
// as that dielectric's: R + T = 1 within 0.5 % where Schlick's curve is like a dielectric's (the default), within 3.5
// % where it is not.
vec3 schlickReflected(vec3 wo, vec2 alpha, float loss, float eta, float reflected, SchlickFresnel s,
                      vec2 film)
{
    GgxMean mean = ggxMean(wo, alpha);
    vec3 outer = ggxCompensatedAlbedo(mean, loss, fresnelSchlick(mean.cosine.x, s, film),
                                      fresnelSchlick(mean.cosine.y, s, film));
    // From the inside two cosines do not catch the critical angle: the dielectric's, by the colour at normal incidence.
    vec3 normal = vec3(1.0) - fresnelSchlick(1.0, s, film);
    vec3 passing = (1.0 - reflected) * normal / max(1.0 - bsdfMean(s.f0), 0.1);
    return eta > 1.0 ? min(outer, vec3(1.0)) : vec3(1.0) - min(passing, vec3(1.0));
}

#endif
