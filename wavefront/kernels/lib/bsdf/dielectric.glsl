// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's dielectric_bsdf, scatter_mode RT: GGX reflection and refraction of one interface, chosen by the Fresnel
// term of the micro normal. Modes R layered over T of the same interface are made one of these: sampled apart,
// refraction would lose the facets that reflect all light, and make up for them by rare, bright samples. Energy
// compensated as the R lobe layered over the T lobe is: an untinted interface returns all light
// (interface_table.glsl). `ior` is inside / outside; see bsdf_common.glsl for the radiance convention.
#ifndef WAVEFRONT_BSDF_DIELECTRIC_GLSL
#define WAVEFRONT_BSDF_DIELECTRIC_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "interface_table.glsl"
#include "microfacet.glsl"
#include "thin_film.glsl"

struct DielectricLobe {
    vec3 reflectTint, transmitTint;
    float eta; // index beyond / index on wo's side
    vec2 alpha;
    float loss;
    GgxInterface faces;
    bool retroreflective;
    vec2 film;
};

DielectricLobe dielectricMake(vec3 wo, vec3 reflectTint, vec3 transmitTint, float ior, vec2 roughness,
                              bool retroreflective, vec2 film)
{
    vec2 alpha = ggxAlpha(roughness);
    float n = ggxRefractiveIndex(ior);
    float eta = wo.z < 0.0 ? 1.0 / n : n;
    GgxInterface faces = ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), eta);
    return DielectricLobe(bsdfClamp(reflectTint, 0.0, 1.0), bsdfClamp(transmitTint, 0.0, 1.0), eta, alpha,
                          ggxLoss(wo, alpha), faces, retroreflective, thinFilmMake(film));
}

// Probability of reflection: its share in what the facet passes on.
float dielectricChoice(DielectricLobe l, vec3 f)
{
    float r = bsdfMean(l.reflectTint * f), t = bsdfMean(l.transmitTint * (vec3(1.0) - f));
    return r + t > 0.0 ? r / (r + t) : 0.5;
}

vec4 dielectricEval(DielectricLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    bool reflects = wi.z > 0.0;
    vec3 g = reflects ? ggxReflection(wo, ggxTurn(wi, l.retroreflective), l.alpha)
                      : ggxTransmission(wo, wi, l.alpha, l.eta);
    vec3 f = fresnelDielectric(g.z, l.eta, l.film);
    float p = dielectricChoice(l, f);
    vec3 value = reflects ? l.reflectTint * ggxCompensate(f, l.loss)
                          : l.transmitTint * l.faces.gain * (vec3(1.0) - f);
    return vec4(value * (g.x * g.y), g.x * (reflects ? p : 1.0 - p));
}

vec3 dielectricSample(DielectricLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 m = ggxSampleNormal(wo, l.alpha, u.xy);
    bool reflects = u.z < dielectricChoice(l, fresnelDielectric(min(dot(wo, m), 1.0), l.eta, l.film));
    vec3 wi = reflects ? ggxReflect(wo, m) : ggxRefract(wo, m, l.eta);
    return ggxTurn(vec3(wi.xy, wi.z * side), l.retroreflective && reflects);
}

// Without regard to a film, which moves little between the two.
vec3 dielectricAlbedo(DielectricLobe l, vec3 wo) { return mix(l.transmitTint, l.reflectTint, l.faces.reflected); }

// Everything that is not reflected is this lobe's own refraction: nothing is left for a base.
vec3 dielectricThroughput(DielectricLobe l, vec3 wo) { return vec3(0.0); }

#endif
