// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Diffuse transmission, MaterialX's translucent_bsdf: Lambert into the side that the viewer is not on.
#ifndef WAVEFRONT_BSDF_TRANSLUCENT_GLSL
#define WAVEFRONT_BSDF_TRANSLUCENT_GLSL
#include "bsdf_common.glsl"

struct TranslucentLobe {
    vec3 color;
};

TranslucentLobe translucentMake(vec3 wo, vec3 color) { return TranslucentLobe(bsdfClamp(color, 0.0, 1.0)); }

vec4 translucentEval(TranslucentLobe l, vec3 wo, vec3 wi)
{
    float pdf = -wi.z * bsdfSide(wo) * kBsdfInvPi;
    return pdf > 0.0 ? vec4(l.color * pdf, pdf) : vec4(0.0);
}

vec3 translucentSample(TranslucentLobe l, vec3 wo, vec3 u)
{
    vec3 wi = bsdfSampleCosine(u.xy);
    return vec3(wi.xy, -wi.z * bsdfSide(wo));
}

vec3 translucentAlbedo(TranslucentLobe l, vec3 wo) { return l.color; }

vec3 translucentThroughput(TranslucentLobe l, vec3 wo) { return vec3(0.0); }

#endif
