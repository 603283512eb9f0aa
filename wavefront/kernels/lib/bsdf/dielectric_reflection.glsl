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
#include "interface_table.glsl"
#include "microfacet.glsl"

struct DielectricReflectionLobe {
    vec3 tint;
    float ior;
    vec2 alpha;
    float loss;      // see ggxLoss
    float reflected; // albedo without tint
};

DielectricReflectionLobe dielectricReflectionMake(vec3 wo, vec3 tint, float ior, vec2 roughness)
{
    vec2 alpha = ggxAlpha(roughness);
    float n = bsdfClamp(ior, 0.01, 100.0);
    float reflected = ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), n).reflected;
    return DielectricReflectionLobe(bsdfClamp(tint, 0.0, 1.0), n, alpha, ggxLoss(wo, alpha), reflected);
}

vec4 dielectricReflectionEval(DielectricReflectionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxReflection(wo, wi, l.alpha);
    float f = fresnelDielectric(g.z, l.ior);
    return vec4(l.tint * (g.x * g.y * ggxCompensate(f, l.loss)), g.x);
}

vec3 dielectricReflectionSample(DielectricReflectionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return vec3(wi.xy, wi.z * side);
}

vec3 dielectricReflectionAlbedo(DielectricReflectionLobe l, vec3 wo) { return l.tint * l.reflected; }

vec3 dielectricReflectionThroughput(DielectricReflectionLobe l, vec3 wo) { return vec3(1.0 - l.reflected); }

#endif
