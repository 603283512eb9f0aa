// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's dielectric_bsdf, scatter_mode R: GGX reflection with the dielectric Fresnel term, energy compensated
// (Turquin 2019, "Practical multiple scattering compensation for microfacet models", equation 16, with the Fresnel
// term of the micro normal, as MaterialX 1.39).
// `ior` holds on both sides. In a body that also refracts, pass 1 / ior when wo.z < 0: then total internal
// reflection is right. As in MaterialX, `tint` colours what is reflected but not what is let through.
#ifndef WAVEFRONT_BSDF_DIELECTRIC_REFLECTION_GLSL
#define WAVEFRONT_BSDF_DIELECTRIC_REFLECTION_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "microfacet.glsl"

struct DielectricReflectionLobe {
    vec3 tint;
    float ior;
    vec2 alpha;
};

DielectricReflectionLobe dielectricReflectionMake(vec3 tint, float ior, vec2 roughness)
{
    return DielectricReflectionLobe(bsdfClamp(tint, 0.0, 1.0), bsdfClamp(ior, 1e-3, 1e3), ggxAlpha(roughness));
}

vec4 dielectricReflectionEval(DielectricReflectionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxReflection(wo, wi, l.alpha);
    float f = fresnelDielectric(g.z, l.ior);
    return vec4(l.tint * (g.x * g.y * ggxCompensate(f, ggxAlbedo(wo.z, ggxMeanAlpha(l.alpha)))), g.x);
}

vec3 dielectricReflectionSample(DielectricReflectionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return vec3(wi.xy, wi.z * side);
}

float dielectricReflectionUntinted(DielectricReflectionLobe l, vec3 wo)
{
    float cosO = abs(wo.z);
    float a = ggxViewAlpha(wo, l.alpha);
    GgxMean mean = ggxMean(cosO, a);
    vec2 f = vec2(fresnelDielectric(mean.cosine.x, l.ior), fresnelDielectric(mean.cosine.y, l.ior));
    // With a critical angle (ior < 1) the two cosines say too little.
    f = l.ior < 1.0 ? vec2(1.0 - ggxInnerTransmission(cosO, a, l.ior).x) : f;
    return ggxCompensatedAlbedo(mean, ggxAlbedo(cosO, ggxMeanAlpha(l.alpha)), f);
}

vec3 dielectricReflectionAlbedo(DielectricReflectionLobe l, vec3 wo)
{
    return l.tint * dielectricReflectionUntinted(l, wo);
}

vec3 dielectricReflectionThroughput(DielectricReflectionLobe l, vec3 wo)
{
    return vec3(clamp(1.0 - dielectricReflectionUntinted(l, wo), 0.0, 1.0));
}

#endif
