// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// What every lobe shares. A lobe `foo` (a row of wavefront/shared/bsdfs.def) is a struct FooLobe and
//
//   FooLobe fooMake(vec3 wo, ...)               MaterialX inputs in document order; clamps, NaN becomes a legal value;
//                                               what depends on wo alone is computed here, once: the others are called
//                                               with the same wo
//   vec4 fooEval(FooLobe l, vec3 wo, vec3 wi)   rgb = f |cos wi|, a = solid-angle pdf of fooSample(wo) at wi; 0 where
//                                               invalid
//   vec3 fooSample(FooLobe l, vec3 wo, vec3 u)  unit wi for u in [0,1)^3; vec3(0): the sample is lost, and its mass is
//                                               not in the pdf
//   vec3 fooAlbedo(FooLobe l, vec3 wo)          directional albedo, the integral of eval.rgb over wi: to choose a lobe
//   vec3 fooThroughput(FooLobe l, vec3 wo)      what MaterialX's `layer` lets through to the base at weight 1;
//                                               at weight w it is 1 - w * (1 - fooThroughput)
//
// Space: the lobe's frame, z = shading normal, x = tangent. wo points to the viewer, wi to the light, both unit
// and away from the surface. Reflection lobes act on both sides (wo.z < 0 mirrors the frame), as MaterialX's do.
// Transmissive lobes: `ior` is inside / outside, the outside at +z; the sign of wo.z says which way a ray passes.
// Radiance convention: paths carry L / n^2 ("basic radiance"), so refraction is NOT scaled by 1/eta^2: no lobe's
// albedo passes 1, Russian roulette sees no false gain, and a body that light enters and leaves again (sphere,
// slab) equals the scaled convention exactly. Only an emitter or a camera inside a medium of index n differs, by n^2.
#ifndef WAVEFRONT_BSDF_COMMON_GLSL
#define WAVEFRONT_BSDF_COMMON_GLSL

const float kBsdfPi = 3.14159265358979;
const float kBsdfInvPi = 0.318309886183791;

// Clamp that sends NaN to `low` (GLSL's clamp leaves it undefined).
float bsdfClamp(float x, float low, float high) { return x >= low ? min(x, high) : low; }
vec3 bsdfClamp(vec3 x, float low, float high)
{
    return vec3(bsdfClamp(x.x, low, high), bsdfClamp(x.y, low, high), bsdfClamp(x.z, low, high));
}

float bsdfSquare(float x) { return x * x; }
vec3 bsdfSquare(vec3 x) { return x * x; }
float bsdfPow5(float x) { float x2 = x * x; return x2 * x2 * x; }
float bsdfMean(vec3 c) { return (c.x + c.y + c.z) * (1.0 / 3.0); }

// +1 on the side of the normal, -1 behind it. wo.z = 0 counts as the front.
float bsdfSide(vec3 w) { return w.z < 0.0 ? -1.0 : 1.0; }

// Cosine-distributed direction about +z; pdf = z / pi.
vec3 bsdfSampleCosine(vec2 u)
{
    float r = sqrt(u.x);
    float phi = 2.0 * kBsdfPi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

#endif
