// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's generalized_schlick_bsdf, scatter_mode T: GGX refraction weighted by 1 - F. See dielectric_transmission.
#ifndef WAVEFRONT_BSDF_GENERALIZED_SCHLICK_TRANSMISSION_GLSL
#define WAVEFRONT_BSDF_GENERALIZED_SCHLICK_TRANSMISSION_GLSL
#include "schlick_interface.glsl"

struct GeneralizedSchlickTransmissionLobe {
    SchlickFresnel fresnel;
    vec2 alpha;
    float ior;
};

GeneralizedSchlickTransmissionLobe generalizedSchlickTransmissionMake(vec3 color0, vec3 color82, vec3 color90,
                                                                      float exponent, vec2 roughness)
{
    SchlickFresnel s = schlickFresnelMake(color0, color82, color90, exponent);
    return GeneralizedSchlickTransmissionLobe(s, ggxAlpha(roughness), schlickIndex(s));
}

vec4 generalizedSchlickTransmissionEval(GeneralizedSchlickTransmissionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    float eta = side > 0.0 ? l.ior : 1.0 / l.ior;
    wo.z *= side;
    wi.z *= side;
    vec3 g = ggxTransmission(wo, wi, l.alpha, eta);
    return vec4((vec3(1.0) - fresnelSchlickInterface(g.z, eta, l.fresnel)) * (g.x * g.y), g.x);
}

vec3 generalizedSchlickTransmissionSample(GeneralizedSchlickTransmissionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxRefract(wo, ggxSampleNormal(wo, l.alpha, u.xy), side > 0.0 ? l.ior : 1.0 / l.ior);
    return vec3(wi.xy, wi.z * side);
}

vec3 generalizedSchlickTransmissionAlbedo(GeneralizedSchlickTransmissionLobe l, vec3 wo)
{
    float eta = wo.z < 0.0 ? 1.0 / l.ior : l.ior;
    return schlickAlbedo(wo, l.alpha, eta, l.fresnel)[1];
}

vec3 generalizedSchlickTransmissionThroughput(GeneralizedSchlickTransmissionLobe l, vec3 wo) { return vec3(0.0); }

#endif
