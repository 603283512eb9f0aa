// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's generalized_schlick_bsdf, scatter_mode RT: GGX reflection and refraction of one interface, chosen by the
// mean Fresnel term of the micro normal, energy compensated as its R and T modes are.
#ifndef WAVEFRONT_BSDF_GENERALIZED_SCHLICK_RT_GLSL
#define WAVEFRONT_BSDF_GENERALIZED_SCHLICK_RT_GLSL
#include "schlick_interface.glsl"

struct GeneralizedSchlickRtLobe {
    SchlickFresnel fresnel;
    vec2 alpha;
    float eta; // index beyond / index on wo's side
    float loss;
    vec3 gain;
    bool retroreflective;
    vec2 film;
};

GeneralizedSchlickRtLobe generalizedSchlickRtMake(vec3 wo, vec3 color0, vec3 color82, vec3 color90, float exponent,
                                                  vec2 roughness, bool retroreflective, vec2 film)
{
    SchlickFresnel s = schlickFresnelMake(color0, color82, color90, exponent);
    vec2 alpha = ggxAlpha(roughness);
    float n = schlickIndex(s);
    float eta = wo.z < 0.0 ? 1.0 / n : n;
    float loss = ggxLoss(wo, alpha);
    film = thinFilmMake(film);
    float plain = ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), eta).gain;
    vec3 gain = schlickGain(wo, alpha, loss, eta, plain, s, film);
    return GeneralizedSchlickRtLobe(s, alpha, eta, loss, gain, retroreflective, film);
}

vec4 generalizedSchlickRtEval(GeneralizedSchlickRtLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    bool reflects = wi.z > 0.0;
    vec3 g = reflects ? ggxReflection(wo, ggxTurn(wi, l.retroreflective), l.alpha)
                      : ggxTransmission(wo, wi, l.alpha, l.eta);
    vec3 f = fresnelSchlickInterface(g.z, l.eta, l.fresnel, l.film);
    float p = interfaceChoice(f);
    vec3 value = reflects ? ggxCompensate(f, l.loss) : l.gain * (vec3(1.0) - f);
    return vec4(value * (g.x * g.y), g.x * (reflects ? p : 1.0 - p));
}

vec3 generalizedSchlickRtSample(GeneralizedSchlickRtLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 m = ggxSampleNormal(wo, l.alpha, u.xy);
    bool reflects = u.z < interfaceChoice(fresnelSchlickInterface(min(dot(wo, m), 1.0), l.eta, l.fresnel, l.film));
    vec3 wi = reflects ? ggxReflect(wo, m) : ggxRefract(wo, m, l.eta);
    return ggxTurn(vec3(wi.xy, wi.z * side), l.retroreflective && reflects);
}

vec3 generalizedSchlickRtAlbedo(GeneralizedSchlickRtLobe l, vec3 wo) { return vec3(1.0); }

vec3 generalizedSchlickRtThroughput(GeneralizedSchlickRtLobe l, vec3 wo) { return vec3(0.0); }

#endif
