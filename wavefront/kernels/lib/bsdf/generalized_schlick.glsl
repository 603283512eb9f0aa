// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's generalized_schlick_bsdf, scatter_mode R: GGX reflection with a generalised Schlick Fresnel term,
// energy compensated as dielectric_reflection is. `isBody`: the surface also refracts; seen from the inside (wo.z <
// 0) the interface is that of generalized_schlick_rt, total reflection and all. What it lets through is the mean over
// channels, as in MaterialX.
#ifndef WAVEFRONT_BSDF_GENERALIZED_SCHLICK_GLSL
#define WAVEFRONT_BSDF_GENERALIZED_SCHLICK_GLSL
#include "schlick_interface.glsl"

struct GeneralizedSchlickLobe {
    SchlickFresnel fresnel;
    vec2 alpha;
    float loss; // see ggxLoss
    vec3 reflected;
    bool retroreflective;
    vec2 film;
    float eta; // below 1: inside of a body
};

GeneralizedSchlickLobe generalizedSchlickMake(vec3 wo, vec3 color0, vec3 color82, vec3 color90, float exponent,
                                              vec2 roughness, bool retroreflective, vec2 film, bool isBody)
{
    SchlickFresnel s = schlickFresnelMake(color0, color82, color90, exponent);
    vec2 alpha = ggxAlpha(roughness);
    float loss = ggxLoss(wo, alpha);
    GgxMean mean = ggxMean(wo, alpha);
    film = thinFilmMake(film);
    vec3 sum = vec3(0.0);
    [[dont_unroll]] for (int i = 0; i < 2; ++i) {
        vec3 f = fresnelSchlick(i == 0 ? mean.cosine.x : mean.cosine.y, s, film);
        sum += (i == 0 ? mean.share.x : mean.share.y) * ggxCompensate(f, loss);
    }
    vec3 reflected = sum / (1.0 + loss);
    float eta = 1.0;
    if (isBody) {
        eta = wo.z < 0.0 ? 1.0 / schlickIndex(s) : 1.0;
        float inner = ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), min(eta, 0.99)).reflected;
        if (eta < 1.0) reflected = schlickReflected(wo, alpha, loss, eta, inner, s, film);
    }
    return GeneralizedSchlickLobe(s, alpha, loss, reflected, retroreflective, film, eta);
}

vec4 generalizedSchlickEval(GeneralizedSchlickLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxReflection(wo, ggxTurn(wi, l.retroreflective), l.alpha);
    vec3 f = l.eta < 1.0 ? fresnelSchlickInterface(g.z, l.eta, l.fresnel, l.film)
                         : fresnelSchlick(g.z, l.fresnel, l.film);
    return vec4((g.x * g.y) * ggxCompensate(f, l.loss), g.x);
}

vec3 generalizedSchlickSample(GeneralizedSchlickLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return ggxTurn(vec3(wi.xy, wi.z * side), l.retroreflective);
}

vec3 generalizedSchlickAlbedo(GeneralizedSchlickLobe l, vec3 wo) { return l.reflected; }

vec3 generalizedSchlickThroughput(GeneralizedSchlickLobe l, vec3 wo)
{
    return vec3(clamp(1.0 - bsdfMean(l.reflected), 0.0, 1.0));
}

#endif
