// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// MaterialX's chiang_hair_bsdf: Chiang et al. 2016, "A Practical and Controllable Hair and Fur Model for Production
// Path Tracing", with the inputs of MaterialX 1.39 (roughness as variance and logistic scale, cuticle_angle 0.5 = no
// tilt). x of the frame runs along the hair. It scatters all around; where on the hair's width wo meets it follows
// from the angle between wo and the normal. Two departures from MaterialX's GLSL, both for energy: it divides by pi
// once more than the paper and spreads the rest term by pi / 2 instead of 1 / (2 pi). Without absorption this lobe
// returns all light.
#ifndef WAVEFRONT_BSDF_CHIANG_HAIR_GLSL
#define WAVEFRONT_BSDF_CHIANG_HAIR_GLSL
#include "bsdf_common.glsl"
#include "fresnel.glsl"

// Of the terms R, TT, TRT and the rest: what they carry, how likely they are sampled, the tilted inclination of wo.
struct ChiangHairLobe {
    vec3 carryR, carryTT, carryTRT, carryRest;
    vec4 chance;
    vec4 sinO, cosO;
    vec3 centreY, centreZ; // cosine and sine of the azimuths where R, TT and TRT leave
    vec3 variance; // along the hair, of R, TT, and TRT and the rest
    vec3 width;    // logistic scales around it
};

vec4 chiangHairSpread(vec3 perTerm) { return vec4(perTerm, perTerm.z); }

ChiangHairLobe chiangHairMake(vec3 wo, vec3 tintR, vec3 tintTT, vec3 tintTRT, float ior, vec2 roughnessR,
                              vec2 roughnessTT, vec2 roughnessTRT, float cuticleAngle, vec3 absorption)
{
    ChiangHairLobe l;
    float n = bsdfClamp(ior, 1.001, 10.0);
    float sinO = clamp(wo.x, -1.0, 1.0), cosO = sqrt(max(1.0 - sinO * sinO, 0.0));
    // Angle between the normal and wo around the hair, on the side of the normal that wo is on; y is towards -gamma.
    float sinGammaO = clamp(-wo.y * bsdfSide(wo) / max(cosO, 1e-4), -1.0, 1.0);
    float cosGammaO = sqrt(1.0 - sinGammaO * sinGammaO);
    float sinGammaT = clamp(sinGammaO * cosO / sqrt(n * n - sinO * sinO), -1.0, 1.0);
    float gammaO = asin(sinGammaO), gammaT = asin(sinGammaT);
    float cosThetaT = sqrt(1.0 - sinO * sinO / (n * n));
    float f = fresnelDielectric(cosO * cosGammaO, n);
    float path = 2.0 * sqrt(1.0 - sinGammaT * sinGammaT) / cosThetaT;
    vec3 t = exp(-bsdfClamp(absorption, 0.0, 1e6) * path);
    vec3 through = (1.0 - f) * (1.0 - f) * t;
    vec3 tint = bsdfClamp(tintTRT, 0.0, 1.0);
    l.carryR = bsdfClamp(tintR, 0.0, 1.0) * f;
    l.carryTT = bsdfClamp(tintTT, 0.0, 1.0) * through;
    l.carryTRT = tint * through * t * f;
    l.carryRest = tint * through * t * f * t * f / max(vec3(1.0) - t * f, vec3(1e-4));
    l.chance = vec4(bsdfMean(l.carryR), bsdfMean(l.carryTT), bsdfMean(l.carryTRT), bsdfMean(l.carryRest));
    float total = l.chance.x + l.chance.y + l.chance.z + l.chance.w;
    l.chance = total > 0.0 ? l.chance / total : vec4(0.25);
    float alpha = (bsdfClamp(cuticleAngle, 0.0, 1.0) - 0.5) * kBsdfPi;
    vec4 tilt = alpha * vec4(2.0, -1.0, -4.0, 0.0);
    l.sinO = sinO * cos(tilt) + cosO * sin(tilt);
    l.cosO = abs(cosO * cos(tilt) - sinO * sin(tilt));
    vec3 order = vec3(0.0, 1.0, 2.0);
    vec3 azimuth = 2.0 * order * gammaT - vec3(2.0 * gammaO) + order * kBsdfPi;
    vec2 around = wo.yz * inversesqrt(max(dot(wo.yz, wo.yz), 1e-30));
    around = dot(around, around) > 0.5 ? around : vec2(0.0, 1.0);
    l.centreY = around.x * cos(azimuth) - around.y * sin(azimuth);
    l.centreZ = around.x * sin(azimuth) + around.y * cos(azimuth);
    l.variance = bsdfClamp(vec3(roughnessR.x, roughnessTT.x, roughnessTRT.x), 1e-3, 1.0);
    l.width = bsdfClamp(vec3(roughnessR.y, roughnessTT.y, roughnessTRT.y), 1e-3, 1.0) * 0.626657; // sqrt(pi / 8)
    return l;
}

// I0(x) exp(-x): Abramowitz and Stegun 9.8.1 and 9.8.2.
vec4 chiangHairBessel(vec4 x)
{
    vec4 s = x * x / (3.75 * 3.75), y = max(x, vec4(3.75)), r = 3.75 / y;
    vec4 small = 1.0 + s * (3.5156229 + s * (3.0899424 + s * (1.2067492 + s * (0.2659732 + s * (0.0360768 +
        s * 0.0045813)))));
    vec4 large = 0.39894228 + r * (0.01328592 + r * (0.00225319 + r * (-0.00157565 + r * (0.00916281 +
        r * (-0.02057706 + r * (0.02635537 + r * (-0.01647633 + r * 0.00392377)))))));
    return mix(small * exp(-x), large * inversesqrt(y), greaterThan(x, vec4(3.75)));
}

// Longitudinal scattering (d'Eon et al. 2011, equation 7), normalised over the inclination: the integral with cosI is
// 1. The exponents are put together before they grow: at small variances floats have no digits left afterwards.
vec4 chiangHairLongitudinal(ChiangHairLobe l, float sinI, float cosI)
{
    vec4 v = chiangHairSpread(l.variance);
    vec4 along = l.cosO * cosI;
    vec4 falloff = exp((along - l.sinO * sinI - 1.0) / v);
    return chiangHairBessel(along / v) * falloff / (v * (1.0 - exp(-2.0 / v)));
}

// Azimuthal scattering: logistic about the term's azimuth, cut at pi. The angle is taken from the lobe's own centre: near 0
// an arc tangent is exact, elsewhere drivers' are good to some 1e-4, which narrow lobes would show.
vec3 chiangHairAzimuthal(ChiangHairLobe l, vec3 wi)
{
    vec3 d = atan(wi.z * l.centreY - wi.y * l.centreZ, wi.y * l.centreY + wi.z * l.centreZ + 1e-30);
    vec3 e = exp(-abs(d) / l.width);
    vec3 edge = exp(-vec3(kBsdfPi) / l.width);
    return e / (l.width * bsdfSquare(vec3(1.0) + e)) * (vec3(1.0) + edge) / (vec3(1.0) - edge);
}

vec4 chiangHairEval(ChiangHairLobe l, vec3 wo, vec3 wi)
{
    float sinI = clamp(wi.x, -1.0, 1.0), cosI = sqrt(max(1.0 - sinI * sinI, 0.0));
    vec4 m = chiangHairLongitudinal(l, sinI, cosI) * vec4(chiangHairAzimuthal(l, wi), 0.5 * kBsdfInvPi);
    vec3 value = l.carryR * m.x + l.carryTT * m.y + l.carryTRT * m.z + l.carryRest * m.w;
    return vec4(value, dot(l.chance, m));
}

vec3 chiangHairSample(ChiangHairLobe l, vec3 wo, vec3 u)
{
    // The number that chooses the term is stretched and used again.
    vec4 end = vec4(l.chance.x, l.chance.x + l.chance.y, l.chance.x + l.chance.y + l.chance.z, 1.0);
    int p = u.z < end.x ? 0 : u.z < end.y ? 1 : u.z < end.z ? 2 : 3;
    vec4 pick = vec4(p == 0, p == 1, p == 2, p == 3);
    float again = clamp((u.z - dot(pick, end - l.chance)) / max(dot(pick, l.chance), 1e-9), 0.0, 0.9999999);
    float v = dot(pick, chiangHairSpread(l.variance));
    float sinO = dot(pick, l.sinO), cosO = dot(pick, l.cosO);
    float cosine = 1.0 + v * log(max(u.x + (1.0 - u.x) * exp(-2.0 / v), 1e-30));
    float sine = sqrt(clamp(1.0 - cosine * cosine, 0.0, 1.0));
    float sinI = clamp(-cosine * sinO + sine * cos(2.0 * kBsdfPi * again) * cosO, -1.0, 1.0);
    float cosI = sqrt(max(1.0 - sinI * sinI, 0.0));
    float s = dot(pick.xyz, l.width), low = 1.0 / (1.0 + exp(kBsdfPi / max(s, 1e-6)));
    float x = clamp(mix(low, 1.0 - low, u.y), 1e-7, 1.0 - 1e-7);
    float around = p == 3 ? 2.0 * kBsdfPi * u.y : s * log(x / (1.0 - x));
    vec2 centre = p == 3 ? vec2(1.0, 0.0) : vec2(dot(pick.xyz, l.centreY), dot(pick.xyz, l.centreZ));
    vec2 yz = cos(around) * centre + sin(around) * vec2(-centre.y, centre.x);
    return vec3(sinI, cosI * yz);
}

vec3 chiangHairAlbedo(ChiangHairLobe l, vec3 wo) { return l.carryR + l.carryTT + l.carryTRT + l.carryRest; }

vec3 chiangHairThroughput(ChiangHairLobe l, vec3 wo) { return vec3(0.0); }

#endif
