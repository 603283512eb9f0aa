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
#include "thin_film.glsl"

struct DielectricReflectionLobe {
    vec3 tint;
    float ior;
    vec2 alpha;
    float loss;     // see ggxLoss
    vec3 reflected; // albedo without tint
    bool retroreflective;
    vec2 film;
};

DielectricReflectionLobe dielectricReflectionMake(vec3 wo, vec3 tint, float ior, vec2 roughness, bool retroreflective,
                                                  vec2 film)
{
    vec2 alpha = ggxAlpha(roughness);
    float n = bsdfClamp(ior, 0.01, 100.0);
    film = thinFilmMake(film);
    float loss = ggxLoss(wo, alpha);
    vec3 reflected = vec3(ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), n).reflected);
    if (film.x > 0.0) reflected = filmAlbedo(ggxMean(wo, alpha), loss, n, reflected.x, film);
    return DielectricReflectionLobe(bsdfClamp(tint, 0.0, 1.0), n, alpha, loss, reflected, retroreflective, film);
}

vec4 dielectricReflectionEval(DielectricReflectionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxReflection(wo, ggxTurn(wi, l.retroreflective), l.alpha);
    vec3 f = fresnelDielectric(g.z, l.ior, l.film);
    return vec4(l.tint * (g.x * g.y) * ggxCompensate(f, l.loss), g.x);
}

vec3 dielectricReflectionSample(DielectricReflectionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return ggxTurn(vec3(wi.xy, wi.z * side), l.retroreflective);
}

vec3 dielectricReflectionAlbedo(DielectricReflectionLobe l, vec3 wo) { return l.tint * l.reflected; }

vec3 dielectricReflectionThroughput(DielectricReflectionLobe l, vec3 wo) { return vec3(1.0) - l.reflected; }

#endif
