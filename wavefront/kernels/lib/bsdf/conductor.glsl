// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's conductor_bsdf: GGX reflection with the conductor Fresnel term per channel, energy compensated as
// dielectric_reflection is.
#ifndef WAVEFRONT_BSDF_CONDUCTOR_GLSL
#define WAVEFRONT_BSDF_CONDUCTOR_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "microfacet.glsl"
#include "thin_film.glsl"

struct ConductorLobe {
    vec3 ior;
    vec3 extinction;
    vec2 alpha;
    float loss; // see ggxLoss
    bool retroreflective;
    vec2 film;
};

ConductorLobe conductorMake(vec3 wo, vec3 ior, vec3 extinction, vec2 roughness, bool retroreflective, vec2 film)
{
    vec2 alpha = ggxAlpha(roughness);
    return ConductorLobe(bsdfClamp(ior, 1e-3, 1e3), bsdfClamp(extinction, 0.0, 1e3), alpha, ggxLoss(wo, alpha),
                         retroreflective, thinFilmMake(film));
}

vec4 conductorEval(ConductorLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxReflection(wo, ggxTurn(wi, l.retroreflective), l.alpha);
    vec3 f = fresnelConductor(g.z, l.ior, l.extinction, l.film);
    return vec4((g.x * g.y) * ggxCompensate(f, l.loss), g.x);
}

vec3 conductorSample(ConductorLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return ggxTurn(vec3(wi.xy, wi.z * side), l.retroreflective);
}

vec3 conductorAlbedo(ConductorLobe l, vec3 wo)
{
    GgxMean mean = ggxMean(wo, l.alpha);
    vec3 sum = vec3(0.0);
    [[dont_unroll]] for (int i = 0; i < 2; ++i) {
        vec3 f = fresnelConductor(i == 0 ? mean.cosine.x : mean.cosine.y, l.ior, l.extinction, l.film);
        sum += (i == 0 ? mean.share.x : mean.share.y) * ggxCompensate(f, l.loss);
    }
    return sum / (1.0 + l.loss);
}

vec3 conductorThroughput(ConductorLobe l, vec3 wo) { return vec3(0.0); }

#endif
