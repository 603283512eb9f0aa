// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's generalized_schlick_bsdf, scatter_mode R: GGX reflection with a generalised Schlick Fresnel term,
// energy compensated as dielectric_reflection is. What it lets through is the mean over channels, as in MaterialX.
#ifndef WAVEFRONT_BSDF_GENERALIZED_SCHLICK_GLSL
#define WAVEFRONT_BSDF_GENERALIZED_SCHLICK_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "microfacet.glsl"

struct GeneralizedSchlickLobe {
    SchlickFresnel fresnel;
    vec2 alpha;
};

GeneralizedSchlickLobe generalizedSchlickMake(vec3 color0, vec3 color82, vec3 color90, float exponent, vec2 roughness)
{
    return GeneralizedSchlickLobe(schlickFresnelMake(color0, color82, color90, exponent), ggxAlpha(roughness));
}

vec4 generalizedSchlickEval(GeneralizedSchlickLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxReflection(wo, wi, l.alpha);
    vec3 f = fresnelSchlick(g.z, l.fresnel);
    return vec4((g.x * g.y) * ggxCompensate(f, ggxAlbedo(wo.z, ggxMeanAlpha(l.alpha))), g.x);
}

vec3 generalizedSchlickSample(GeneralizedSchlickLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return vec3(wi.xy, wi.z * side);
}

vec3 generalizedSchlickAlbedo(GeneralizedSchlickLobe l, vec3 wo)
{
    GgxMean mean = ggxMean(abs(wo.z), ggxViewAlpha(wo, l.alpha));
    vec3 fx = fresnelSchlick(mean.cosine.x, l.fresnel);
    vec3 fy = fresnelSchlick(mean.cosine.y, l.fresnel);
    return ggxCompensatedAlbedo(mean, ggxAlbedo(abs(wo.z), ggxMeanAlpha(l.alpha)), fx, fy);
}

vec3 generalizedSchlickThroughput(GeneralizedSchlickLobe l, vec3 wo)
{
    return vec3(clamp(1.0 - bsdfMean(generalizedSchlickAlbedo(l, wo)), 0.0, 1.0));
}

#endif
