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

// By what refraction is scaled, channel by channel: as the dielectric's of the same index, which the table knows, or less.
// Reflection takes F (1 + F loss) of what a facet gets with the chance 1 / (1 + loss), so refraction is due 1 + loss (1 +
// F) for each 1 - F; where a channel reflects less than the dielectric, that is less. Two cosines tell. R + T is 1 within
// 0.5 % where Schlick's curve is like a dielectric's (the default); one that falls where a dielectric's rises has up to 4
// % more, since the facets that light refracts at are not those that it reflects from.
vec3 schlickGain(vec3 wo, vec2 alpha, float loss, float eta, float gain, SchlickFresnel s, vec2 film)
{
    GgxMean mean = ggxMean(wo, alpha);
    vec3 passed = vec3(0.0), due = vec3(0.0);
    float plainPassed = 0.0, plainDue = 0.0;
    [[dont_unroll]] for (int i = 0; i < 2; ++i) {
        float cosine = i == 0 ? mean.cosine.x : mean.cosine.y, share = i == 0 ? mean.share.x : mean.share.y;
        vec3 f = fresnelSchlickInterface(cosine, eta, s, film);
        float plain = fresnelDielectric(cosine, eta);
        passed += share * (vec3(1.0) - f);
        due += share * (vec3(1.0) - f * f);
        plainPassed += share * (1.0 - plain);
        plainDue += share * (1.0 - plain * plain);
    }
    vec3 own = clamp(due / max(passed, vec3(1e-4)), vec3(1.0), vec3(2.0));
    float known = clamp(plainDue / max(plainPassed, 1e-4), 1.0, 2.0);
    return gain * min((1.0 + loss * own) / (1.0 + loss * known), vec3(1.0));
}

// Albedo of the compensated reflection; `reflected` is that of the dielectric of the same index.
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
