// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// The way into a random walk, MaterialX's subsurface_bsdf: Lambert to the side that the viewer is not on. What leaves the
// body again adds up to `color` (lib/subsurface.glsl), so that is the albedo here; the walk takes the light on.
// Channels whose mean free path is shorter than rounding allows to walk are what a walk becomes as it shrinks to nothing:
// Lambert on the viewer's side, of their colour.
#ifndef WAVEFRONT_BSDF_SUBSURFACE_GLSL
#define WAVEFRONT_BSDF_SUBSURFACE_GLSL
#include "bsdf_common.glsl"

// The shortest mean free path that can be walked here: set by whoever knows the place, before lobes are made.
float gSubsurfaceShortest = 0.0;

struct SubsurfaceLobe {
    vec3 color;  // of what walks; 0 in the channels that do not
    vec3 radius;
    float anisotropy;
    vec3 near;   // of what leaves where it came
};

SubsurfaceLobe subsurfaceMake(vec3 wo, vec3 color, vec3 radius, float anisotropy)
{
    float g = isnan(anisotropy) ? 0.0 : clamp(anisotropy, -0.95, 0.95);
    color = bsdfClamp(color, 0.0, 1.0);
    radius = bsdfClamp(radius, 0.0, 1e9);
    vec3 walks = vec3(greaterThan(radius, vec3(gSubsurfaceShortest)));
    return SubsurfaceLobe(color * walks, radius, g, color * (1.0 - walks));
}

float subsurfaceNearShare(SubsurfaceLobe l)
{
    float near = bsdfMean(l.near);
    return near > 0.0 ? near / (near + bsdfMean(l.color)) : 0.0;
}

vec4 subsurfaceEval(SubsurfaceLobe l, vec3 wo, vec3 wi)
{
    float cosine = wi.z * bsdfSide(wo) * kBsdfInvPi;
    float near = subsurfaceNearShare(l);
    return cosine > 0.0 ? vec4(l.near * cosine, near * cosine) : vec4(l.color, 1.0 - near) * -cosine;
}

vec3 subsurfaceSample(SubsurfaceLobe l, vec3 wo, vec3 u)
{
    vec3 wi = bsdfSampleCosine(u.xy);
    float side = u.z < subsurfaceNearShare(l) ? 1.0 : -1.0;
    return vec3(wi.xy, wi.z * side * bsdfSide(wo));
}

vec3 subsurfaceAlbedo(SubsurfaceLobe l, vec3 wo) { return l.color + l.near; }

vec3 subsurfaceThroughput(SubsurfaceLobe l, vec3 wo) { return vec3(0.0); }

#endif
