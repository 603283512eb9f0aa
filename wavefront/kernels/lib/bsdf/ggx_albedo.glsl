// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#ifndef WAVEFRONT_BSDF_GGX_ALBEDO_GLSL
#define WAVEFRONT_BSDF_GGX_ALBEDO_GLSL
#include "fresnel.glsl"

struct GgxMean {
    float albedo; // directional albedo for F = 1
    vec2 cosine;  // two cosines at the micro normal that stand for their distribution ...
    vec2 share;   // ... and their shares, which sum to 1
};

float ggxAlbedo(float cosO, float alpha) { return 1.0 - 0.6 * alpha * alpha * cosO; }
GgxMean ggxMean(float cosO, float alpha) { return GgxMean(ggxAlbedo(cosO, alpha), vec2(cosO), vec2(0.5)); }
float ggxTransmitted(float cosO, float alpha, float eta) { return 1.0; }
vec2 ggxDielectricAlbedo(float cosO, float alpha, float eta)
{
    float f = fresnelDielectric(cosO, eta);
    return vec2(f * ggxAlbedo(cosO, alpha), (1.0 - f) * ggxTransmitted(cosO, alpha, eta));
}

// Energy compensated Fresnel term (Turquin 2019): f (1 + f (1 - E) / E), for the white albedo E.
float ggxCompensate(float f, float albedo) { return f * (1.0 + f * (1.0 - albedo) / albedo); }
vec3 ggxCompensate(vec3 f, float albedo) { return f * (1.0 + f * ((1.0 - albedo) / albedo)); }

#endif
