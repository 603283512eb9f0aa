// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's dielectric_bsdf, scatter_mode T: GGX refraction (Walter et al. 2007) weighted by 1 - F, energy
// compensated (interface_table.glsl). It already leaves out what the interface reflects: a `layer` of the same
// interface's R lobe above it must not take that away again, and the two together lose nothing. `ior` is inside /
// outside; see bsdf_common.glsl for the radiance convention.
#ifndef WAVEFRONT_BSDF_DIELECTRIC_TRANSMISSION_GLSL
#define WAVEFRONT_BSDF_DIELECTRIC_TRANSMISSION_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "interface_table.glsl"
#include "microfacet.glsl"
#include "thin_film.glsl"

struct DielectricTransmissionLobe {
    vec3 tint;
    float eta; // index beyond / index on wo's side
    vec2 alpha;
    float gain;
    vec3 transmitted; // albedo without tint
    vec2 film;
};

DielectricTransmissionLobe dielectricTransmissionMake(vec3 wo, vec3 tint, float ior, vec2 roughness, vec2 film)
{
    vec2 alpha = ggxAlpha(roughness);
    float n = ggxRefractiveIndex(ior);
    float eta = wo.z < 0.0 ? 1.0 / n : n;
    GgxInterface i = ggxInterface(abs(wo.z), ggxViewAlpha(wo, alpha), eta);
    film = thinFilmMake(film);
    vec3 reflected = vec3(i.reflected);
    if (film.x > 0.0) reflected = filmAlbedo(ggxMean(wo, alpha), ggxLoss(wo, alpha), eta, i.reflected, film);
    return DielectricTransmissionLobe(bsdfClamp(tint, 0.0, 1.0), eta, alpha, i.gain, vec3(1.0) - reflected, film);
}

vec4 dielectricTransmissionEval(DielectricTransmissionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxTransmission(wo, wi, l.alpha, l.eta);
    return vec4(l.tint * (l.gain * g.x * g.y) * (vec3(1.0) - fresnelDielectric(g.z, l.eta, l.film)), g.x);
}

vec3 dielectricTransmissionSample(DielectricTransmissionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxRefract(wo, ggxSampleNormal(wo, l.alpha, u.xy), l.eta);
    return vec3(wi.xy, wi.z * side);
}

vec3 dielectricTransmissionAlbedo(DielectricTransmissionLobe l, vec3 wo) { return l.tint * l.transmitted; }

// A T lobe belongs below the R lobe of its interface; what it refracts is not there for a base.
vec3 dielectricTransmissionThroughput(DielectricTransmissionLobe l, vec3 wo) { return vec3(0.0); }

#endif
