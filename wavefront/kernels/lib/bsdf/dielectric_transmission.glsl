// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's dielectric_bsdf, scatter_mode T: GGX refraction (Walter et al. 2007) weighted by 1 - F, without energy
// compensation. It already leaves out what the interface reflects: a `layer` of the same interface's R lobe above it
// must not take that away again. `ior` is inside / outside; see bsdf_common.glsl for the radiance convention.
#ifndef WAVEFRONT_BSDF_DIELECTRIC_TRANSMISSION_GLSL
#define WAVEFRONT_BSDF_DIELECTRIC_TRANSMISSION_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"
#include "microfacet.glsl"

struct DielectricTransmissionLobe {
    vec3 tint;
    float ior;
    vec2 alpha;
};

DielectricTransmissionLobe dielectricTransmissionMake(vec3 tint, float ior, vec2 roughness)
{
    return DielectricTransmissionLobe(bsdfClamp(tint, 0.0, 1.0), ggxRefractiveIndex(ior), ggxAlpha(roughness));
}

vec4 dielectricTransmissionEval(DielectricTransmissionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    float eta = side > 0.0 ? l.ior : 1.0 / l.ior;
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxTransmission(wo, wi, l.alpha, eta);
    return vec4(l.tint * (g.x * g.y * (1.0 - fresnelDielectric(g.z, eta))), g.x);
}

vec3 dielectricTransmissionSample(DielectricTransmissionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxRefract(wo, ggxSampleNormal(wo, l.alpha, u.xy), side > 0.0 ? l.ior : 1.0 / l.ior);
    return vec3(wi.xy, wi.z * side);
}

vec3 dielectricTransmissionAlbedo(DielectricTransmissionLobe l, vec3 wo)
{
    float eta = wo.z < 0.0 ? 1.0 / l.ior : l.ior;
    return l.tint * ggxDielectricAlbedo(abs(wo.z), ggxViewAlpha(wo, l.alpha), eta).y;
}

// A T lobe belongs below the R lobe of its interface; what it refracts is not there for a base.
vec3 dielectricTransmissionThroughput(DielectricTransmissionLobe l, vec3 wo) { return vec3(0.0); }

#endif
