// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's dielectric_bsdf, scatter_mode RT: GGX reflection and refraction of one interface, chosen by the Fresnel
// term of the micro normal. No energy compensation: what masking takes is lost, and R + T never exceeds 1.
// `ior` is inside / outside; see bsdf_common.glsl for the radiance convention.
#ifndef WAVEFRONT_BSDF_DIELECTRIC_GLSL
#define WAVEFRONT_BSDF_DIELECTRIC_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "microfacet.glsl"

struct DielectricLobe {
    vec3 tint;
    float ior;
    vec2 alpha;
};

DielectricLobe dielectricMake(vec3 tint, float ior, vec2 roughness)
{
    return DielectricLobe(bsdfClamp(tint, 0.0, 1.0), ggxRefractiveIndex(ior), ggxAlpha(roughness));
}

vec4 dielectricEval(DielectricLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    float eta = side > 0.0 ? l.ior : 1.0 / l.ior;
    wo.z *= side;
    wi.z *= side;
    bool reflects = wi.z > 0.0;
    vec3 g = reflects ? ggxReflection(wo, wi, l.alpha) : ggxTransmission(wo, wi, l.alpha, eta);
    float f = fresnelDielectric(g.z, eta);
    float pdf = g.x * (reflects ? f : 1.0 - f);
    return vec4(l.tint * (pdf * g.y), pdf);
}

vec3 dielectricSample(DielectricLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    float eta = side > 0.0 ? l.ior : 1.0 / l.ior;
    wo.z *= side;
    vec3 m = ggxSampleNormal(wo, l.alpha, u.xy);
    vec3 wi = u.z < fresnelDielectric(min(dot(wo, m), 1.0), eta) ? ggxReflect(wo, m) : ggxRefract(wo, m, eta);
    return vec3(wi.xy, wi.z * side);
}

vec3 dielectricAlbedo(DielectricLobe l, vec3 wo)
{
    float eta = wo.z < 0.0 ? 1.0 / l.ior : l.ior;
    vec2 rt = ggxDielectricAlbedo(abs(wo.z), ggxViewAlpha(wo, l.alpha), eta);
    return l.tint * (rt.x + rt.y);
}

// Everything that is not reflected is this lobe's own refraction: nothing is left for a base.
vec3 dielectricThroughput(DielectricLobe l, vec3 wo) { return vec3(0.0); }

#endif
