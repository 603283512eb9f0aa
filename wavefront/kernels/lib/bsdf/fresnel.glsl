// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Fresnel reflectances. cosI is the cosine at the (micro) normal on the side of wo, in [0,1].
#ifndef WAVEFRONT_BSDF_FRESNEL_GLSL
#define WAVEFRONT_BSDF_FRESNEL_GLSL
#include "bsdf_common.glsl"

// Unpolarised dielectric. eta = index beyond / index on wo's side; total internal reflection gives 1.
float fresnelDielectric(float cosI, float eta)
{
    float eta2 = eta * eta;
    float g2 = eta2 - 1.0 + cosI * cosI; // (eta cos theta_t)^2
    float g = sqrt(max(g2, 0.0));
    float rs = (cosI - g) / max(cosI + g, 1e-20);
    float rp = (eta2 * cosI - g) / max(eta2 * cosI + g, 1e-20);
    return g2 > 0.0 ? 0.5 * (rs * rs + rp * rp) : 1.0;
}

// Unpolarised conductor of complex index n + ik, seen from vacuum (Lagarde 2013, "Memo on Fresnel equations").
vec3 fresnelConductor(float cosI, vec3 n, vec3 k)
{
    float cos2 = cosI * cosI;
    float sin2 = 1.0 - cos2;
    vec3 n2 = n * n;
    vec3 k2 = k * k;
    vec3 t0 = n2 - k2 - vec3(sin2);
    vec3 ab = sqrt(t0 * t0 + 4.0 * n2 * k2);
    vec3 t1 = ab + vec3(cos2);
    vec3 t2 = sqrt(max(2.0 * (ab + t0), vec3(0.0))) * cosI;
    vec3 rs = (t1 - t2) / max(t1 + t2, vec3(1e-20));
    vec3 t3 = cos2 * ab + vec3(sin2 * sin2);
    vec3 t4 = t2 * sin2;
    return 0.5 * rs * (1.0 + (t3 - t4) / max(t3 + t4, vec3(1e-20)));
}

// Probability of reflection where an interface chooses: both events keep a chance wherever some channel has them. Of a
// grey term, the term itself.
float interfaceChoice(vec3 f)
{
    float high = max(f.x, max(f.y, f.z)), low = min(f.x, min(f.y, f.z));
    return high == low ? low : clamp(bsdfMean(f), min(0.05, high), max(0.95, low));
}

// Schlick with free ends and exponent, and Hoffman's term that sets the value at about 82 degrees
// (Hoffman 2023, "Generalization of Adobe's Fresnel model"), as MaterialX 1.39.
struct SchlickFresnel {
    vec3 f0;
    vec3 f90;
    vec3 a; // factor of x (1 - x)^6
    float exponent;
};

SchlickFresnel schlickFresnelMake(vec3 color0, vec3 color82, vec3 color90, float exponent)
{
    const float factor = 17.6513846; // 1 / (x (1 - x)^6) at x = 1/7
    vec3 f0 = bsdfClamp(color0, 0.0, 1.0);
    vec3 f90 = bsdfClamp(color90, 0.0, 1.0);
    float e = bsdfClamp(exponent, 0.01, 100.0);
    vec3 a = mix(f0, f90, pow(6.0 / 7.0, e)) * (vec3(1.0) - bsdfClamp(color82, 0.0, 1.0)) * factor;
    return SchlickFresnel(f0, f90, a, e);
}

vec3 fresnelSchlick(float cosI, SchlickFresnel s)
{
    float x = clamp(1.0 - cosI, 0.0, 1.0);
    float x2 = x * x;
    return clamp(mix(s.f0, s.f90, pow(x, s.exponent)) - s.a * ((1.0 - x) * x2 * x2 * x2), 0.0, 1.0);
}

#endif
