// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's generalized_schlick_bsdf, scatter_mode RT: GGX reflection and refraction of one interface, chosen by the
// mean Fresnel term of the micro normal. No energy compensation, as in dielectric: R + T never exceeds 1.
#ifndef WAVEFRONT_BSDF_GENERALIZED_SCHLICK_RT_GLSL
#define WAVEFRONT_BSDF_GENERALIZED_SCHLICK_RT_GLSL
#include "schlick_interface.glsl"

struct GeneralizedSchlickRtLobe {
    SchlickFresnel fresnel;
    vec2 alpha;
    float ior;
};

GeneralizedSchlickRtLobe generalizedSchlickRtMake(vec3 color0, vec3 color82, vec3 color90, float exponent,
                                                  vec2 roughness)
{
    SchlickFresnel s = schlickFresnelMake(color0, color82, color90, exponent);
    return GeneralizedSchlickRtLobe(s, ggxAlpha(roughness), schlickIndex(s));
}

// Probability of reflection: both events keep a chance wherever some channel has them.
float generalizedSchlickRtChoice(vec3 f)
{
    float low = min(0.05, max(f.x, max(f.y, f.z)));
    float high = max(0.95, min(f.x, min(f.y, f.z)));
    return clamp(bsdfMean(f), low, high);
}

vec4 generalizedSchlickRtEval(GeneralizedSchlickRtLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    float eta = side > 0.0 ? l.ior : 1.0 / l.ior;
    wo.z *= side;
    wi.z *= side;
    bool reflects = wi.z > 0.0;
    vec3 g = reflects ? ggxReflection(wo, wi, l.alpha) : ggxTransmission(wo, wi, l.alpha, eta);
    vec3 f = fresnelSchlickInterface(g.z, eta, l.fresnel);
    float p = generalizedSchlickRtChoice(f);
    return vec4((reflects ? f : vec3(1.0) - f) * (g.x * g.y), g.x * (reflects ? p : 1.0 - p));
}

vec3 generalizedSchlickRtSample(GeneralizedSchlickRtLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    float eta = side > 0.0 ? l.ior : 1.0 / l.ior;
    wo.z *= side;
    vec3 m = ggxSampleNormal(wo, l.alpha, u.xy);
    float p = generalizedSchlickRtChoice(fresnelSchlickInterface(min(dot(wo, m), 1.0), eta, l.fresnel));
    vec3 wi = u.z < p ? ggxReflect(wo, m) : ggxRefract(wo, m, eta);
    return vec3(wi.xy, wi.z * side);
}

vec3 generalizedSchlickRtAlbedo(GeneralizedSchlickRtLobe l, vec3 wo)
{
    float eta = wo.z < 0.0 ? 1.0 / l.ior : l.ior;
    mat2x3 rt = schlickAlbedo(wo, l.alpha, eta, l.fresnel);
    return rt[0] + rt[1];
}

vec3 generalizedSchlickRtThroughput(GeneralizedSchlickRtLobe l, vec3 wo) { return vec3(0.0); }

#endif
