// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Anisotropic GGX: Trowbridge-Reitz distribution, height-correlated Smith masking (Heitz 2014, "Understanding the
// masking-shadowing function", equation 99), visible normals sampled by spherical caps (Dupuy and Benyoub 2023).
// Everything here takes wo with wo.z >= 0: a lobe mirrors its frame first.
//
// With S(w) = sqrt(w.z^2 + (ax w.x)^2 + (ay w.y)^2) = |w.z| (1 + 2 Lambda(w)):
//   G1(o) = 2 o.z / (o.z + S(o)),   G2(o,i) = 2 o.z i.z / (i.z S(o) + o.z S(i)),
// so neither the pdf nor the weight G2/G1 divides by a cosine, and wo.z = 0 needs no special case.
#ifndef WAVEFRONT_BSDF_MICROFACET_GLSL
#define WAVEFRONT_BSDF_MICROFACET_GLSL
#include "bsdf_common.glsl"

// There are no delta lobes: a mirror is a lobe of this width (0.06 degrees), far below a pixel.
const float kMinAlpha = 1e-3;

vec2 ggxAlpha(vec2 roughness)
{
    return vec2(bsdfClamp(roughness.x, kMinAlpha, 1.0), bsdfClamp(roughness.y, kMinAlpha, 1.0));
}

float ggxStretch(vec3 w, vec2 alpha) { vec2 t = alpha * w.xy; return sqrt(w.z * w.z + dot(t, t)); }

float ggxDistribution(vec3 m, vec2 alpha)
{
    vec2 t = m.xy / alpha;
    float d = dot(t, t) + m.z * m.z;
    return kBsdfInvPi / (alpha.x * alpha.y * d * d);
}

// A normal from the distribution of those visible from wo.
vec3 ggxSampleNormal(vec3 wo, vec2 alpha, vec2 u)
{
    vec3 w = normalize(vec3(alpha * wo.xy, wo.z));
    float phi = 2.0 * kBsdfPi * u.x;
    float z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    float r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(r * cos(phi), r * sin(phi), z) + w;
    return normalize(vec3(alpha * h.xy, max(h.z, 1e-7)));
}

// Both return (pdf of the direction, G2/G1, wo.m): eval = pdf * G2/G1 * Fresnel term. All zero where wi is not
// reached. They differ in the Jacobian of the half vector (Walter et al. 2007, equations 13-17).
vec3 ggxReflection(vec3 wo, vec3 wi, vec2 alpha)
{
    vec3 m = normalize(wo + wi);
    float so = ggxStretch(wo, alpha);
    float si = ggxStretch(wi, alpha);
    float pdf = 0.5 * ggxDistribution(m, alpha) / (wo.z + so);
    float mask = wi.z * (wo.z + so) / (wi.z * so + wo.z * si);
    return wi.z > 0.0 ? vec3(pdf, mask, min(dot(wo, m), 1.0)) : vec3(0.0);
}

// eta = index on wi's side / index on wo's side.
vec3 ggxTransmission(vec3 wo, vec3 wi, vec2 alpha, float eta)
{
    vec3 h = wo + eta * wi;
    vec3 m = h * (inversesqrt(max(dot(h, h), 1e-20)) * (h.z < 0.0 ? -1.0 : 1.0));
    float so = ggxStretch(wo, alpha);
    float si = ggxStretch(wi, alpha);
    float cosO = dot(wo, m);
    float cosI = dot(wi, m);
    float jacobian = eta * eta * abs(cosI) / max(bsdfSquare(cosO + eta * cosI), 1e-20);
    float pdf = 2.0 * cosO * ggxDistribution(m, alpha) * jacobian / (wo.z + so);
    float mask = -wi.z * (wo.z + so) / (-wi.z * so + wo.z * si);
    return wi.z < 0.0 && cosO > 0.0 && cosI < 0.0 ? vec3(pdf, mask, min(cosO, 1.0)) : vec3(0.0);
}

// wi, or vec3(0) where it would leave on the wrong side (single scattering: such paths are lost) or cannot refract.
vec3 ggxReflect(vec3 wo, vec3 m)
{
    vec3 wi = 2.0 * dot(wo, m) * m - wo;
    return wi.z > 0.0 ? normalize(wi) : vec3(0.0);
}

vec3 ggxRefract(vec3 wo, vec3 m, float eta)
{
    float c = dot(wo, m);
    float g2 = c * c + eta * eta - 1.0;
    vec3 wi = (c - sqrt(max(g2, 0.0))) * m - wo;
    return g2 > 0.0 && wi.z < 0.0 ? normalize(wi) : vec3(0.0);
}

// MaterialX's `retroreflective`: what would leave to the mirror direction leaves towards wo instead. The lobe
// reflects as ever (its distribution knows no difference between a direction's azimuth and the opposite one) and wi
// is turned.
vec3 ggxTurn(vec3 wi, bool retroreflective) { return retroreflective ? vec3(-wi.xy, wi.z) : wi; }

// `ior` of a refracting lobe. Half vectors need some contrast between the two sides: 1 becomes 1.01 (F0 = 2.5e-5).
float ggxRefractiveIndex(float ior)
{
    float n = bsdfClamp(ior, 0.1, 10.0);
    return n >= 1.0 ? max(n, 1.01) : min(n, 0.99);
}

#endif
