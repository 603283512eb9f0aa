// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// What a thin-walled dielectric lets through: two parallel faces bend light back to where it came from, so that only
// their roughness spreads it. A mirrored GGX reflection of lower roughness: a facet tilted by d turns a ray by 2 d in
// reflection, by (n - 1) d in refraction, and two independent faces do so in quadrature: (n - 1) / sqrt(2) of the
// roughness. `passed` is what the interface's reflection leaves; the lobe is energy compensated to just that.
#ifndef WAVEFRONT_BSDF_THIN_TRANSMISSION_GLSL
#define WAVEFRONT_BSDF_THIN_TRANSMISSION_GLSL
#include "ggx_albedo.glsl"
#include "microfacet.glsl"

struct ThinTransmissionLobe {
    vec3 passed;
    vec2 alpha;
    float gain;
};

ThinTransmissionLobe thinTransmissionMake(vec3 wo, vec3 passed, float ior, vec2 roughness)
{
    float n = bsdfClamp(ior, 0.1, 10.0);
    float blur = min((max(n, 1.0 / n) - 1.0) * 0.70710678, 1.0);
    vec2 alpha = ggxAlpha(ggxAlpha(roughness) * blur);
    return ThinTransmissionLobe(bsdfClamp(passed, 0.0, 1.0), alpha, 1.0 + ggxLoss(wo, alpha));
}

vec4 thinTransmissionEval(ThinTransmissionLobe l, vec3 wo, vec3 wi)
{
    float side = bsdfSide(wo);
    vec3 g = ggxReflection(vec3(wo.xy, wo.z * side), vec3(wi.xy, -wi.z * side), l.alpha);
    return vec4(l.passed * (l.gain * g.x * g.y), g.x);
}

vec3 thinTransmissionSample(ThinTransmissionLobe l, vec3 wo, vec3 u)
{
    float side = bsdfSide(wo);
    wo.z *= side;
    vec3 wi = ggxReflect(wo, ggxSampleNormal(wo, l.alpha, u.xy));
    return vec3(wi.xy, -wi.z * side);
}

vec3 thinTransmissionAlbedo(ThinTransmissionLobe l, vec3 wo) { return l.passed; }

vec3 thinTransmissionThroughput(ThinTransmissionLobe l, vec3 wo) { return vec3(0.0); }

#endif
