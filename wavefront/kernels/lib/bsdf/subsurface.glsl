// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// The way into a random walk, MaterialX's subsurface_bsdf: Lambert to the side that the viewer is not on. What leaves the
// body again adds up to `color` (lib/subsurface.glsl), so that is the albedo here; the walk takes the light on.
#ifndef WAVEFRONT_BSDF_SUBSURFACE_GLSL
#define WAVEFRONT_BSDF_SUBSURFACE_GLSL
#include "bsdf_common.glsl"

struct SubsurfaceLobe {
    vec3 color;
    vec3 radius;
    float anisotropy;
};

SubsurfaceLobe subsurfaceMake(vec3 wo, vec3 color, vec3 radius, float anisotropy)
{
    float g = isnan(anisotropy) ? 0.0 : clamp(anisotropy, -0.95, 0.95);
    return SubsurfaceLobe(bsdfClamp(color, 0.0, 1.0), bsdfClamp(radius, 0.0, 1e9), g);
}

vec4 subsurfaceEval(SubsurfaceLobe l, vec3 wo, vec3 wi)
{
    float pdf = -wi.z * bsdfSide(wo) * kBsdfInvPi;
    return pdf > 0.0 ? vec4(l.color * pdf, pdf) : vec4(0.0);
}

vec3 subsurfaceSample(SubsurfaceLobe l, vec3 wo, vec3 u)
{
    vec3 wi = bsdfSampleCosine(u.xy);
    return vec3(wi.xy, -wi.z * bsdfSide(wo));
}

vec3 subsurfaceAlbedo(SubsurfaceLobe l, vec3 wo) { return l.color; }

vec3 subsurfaceThroughput(SubsurfaceLobe l, vec3 wo) { return vec3(0.0); }

#endif
