// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's generalized_schlick_bsdf, scatter_mode T: GGX refraction weighted by 1 - F. See dielectric_transmission.
#ifndef WAVEFRONT_BSDF_GENERALIZED_SCHLICK_TRANSMISSION_GLSL
#define WAVEFRONT_BSDF_GENERALIZED_SCHLICK_TRANSMISSION_GLSL
#include "schlick_interface.glsl"

struct GeneralizedSchlickTransmissionLobe {
    SchlickFresnel fresnel;
    vec2 alpha;
    float eta; // index beyond / index on wo's side
    vec3 gain;
    vec3 transmitted;
    vec2 film;
};

GeneralizedSchlickTransmissionLobe generalizedSchlickTransmissionMake(vec3 wo, vec3 color0, vec3 color82, vec3 color90,
                                                                      float exponent, vec2 roughness, vec2 film)
{
    SchlickFresnel s = schlickFresnelMake(color0, color82, color90, exponent);
    vec2 alpha = ggxAlpha(roughness);
    float n = schlickIndex(s);
    float eta = wo.z < 0.0 ? 1.0 / n : n;
    GgxInterface i = ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), eta);
    film = thinFilmMake(film);
    float loss = ggxLoss(wo, alpha);
    vec3 reflected = schlickReflected(wo, alpha, loss, eta, i.reflected, s, film);
    vec3 gain = schlickGain(wo, alpha, loss, eta, i.gain, s, film);
    return GeneralizedSchlickTransmissionLobe(s, alpha, eta, gain, vec3(1.0) - reflected, film);
}

vec4 generalizedSchlickTransmissionEval(GeneralizedSchlickTransmissionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxTransmission(wo, wi, l.alpha, l.eta);
    vec3 f = fresnelSchlickInterface(g.z, l.eta, l.fresnel, l.film);
    return vec4((vec3(1.0) - f) * l.gain * (g.x * g.y), g.x);
}

vec3 generalizedSchlickTransmissionSample(GeneralizedSchlickTransmissionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxRefract(wo, ggxSampleNormal(wo, l.alpha, u.xy), l.eta);
    return vec3(wi.xy, wi.z * side);
}

vec3 generalizedSchlickTransmissionAlbedo(GeneralizedSchlickTransmissionLobe l, vec3 wo) { return l.transmitted; }

vec3 generalizedSchlickTransmissionThroughput(GeneralizedSchlickTransmissionLobe l, vec3 wo) { return vec3(0.0); }

#endif
