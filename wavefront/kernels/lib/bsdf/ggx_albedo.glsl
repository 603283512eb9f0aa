// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Directional albedos of reflecting GGX lobes (height-correlated Smith, single scattering), fitted to quadrature over
// cosO in [0.001, 1], alpha in [0.001, 1] by resources/albedo/fit_bsdf_albedo.py (interface_table.glsl: with
// refraction). The natural coordinate is t = cosO / (cosO + alpha): at small alpha everything depends on cosO / alpha
// alone.
#ifndef WAVEFRONT_BSDF_GGX_ALBEDO_GLSL
#define WAVEFRONT_BSDF_GGX_ALBEDO_GLSL
#include "fresnel.glsl"

// Albedo for F = 1, relative error below 0.55 % (0.8 % at cosO < 0.001). Smooth lobes lose nothing: the bound is exact
// to 0.01 % there, which light that is totally reflected many times can tell.
float ggxAlbedo(float cosO, float a)
{
    float t = cosO / (cosO + a);
    float bound = 1.0 - (1.0 + a * (6.0 - a)) * bsdfSquare(1.0 - t);
    float fit = 0.991665 + a * (0.0295469 + a * (-0.0208267 + a * -0.0073178)) + t * (0.0489169 + a * (-1.61719 + a *
        (-2.80995 + a * 0.627514)) + t * (-1.58789 + a * (10.8626 + a * (5.41783 + a * 2.55933)) + t * (2.23711 + a *
        (-24.1364 + a * (-25.7817 + a * -12.0861)) + t * (0.388369 + a * (22.1136 + a * (40.9895 + a * 41.247)) + t *
        (-1.0805 + a * (-7.64329 + a * (-13.201 + a * -48.4905)))))));
    return max(fit, bound);
}

// The isotropic roughness that stands for an anisotropic one where a Fresnel-weighted albedo is asked for: what the
// view sees, the roughness along its azimuth at grazing wo, the root mean square at the normal.
float ggxViewAlpha(vec3 wo, vec2 alpha)
{
    vec2 t = alpha * wo.xy;
    return sqrt(dot(t, t) + 0.5 * dot(alpha, alpha) * wo.z * wo.z);
}

// Albedo for F = 1 of an anisotropic lobe: the albedo at the root mean square, corrected by a small network of rational
// sigmoids. Relative error for alphas of a ratio up to 12, in 98 % of cases: 2 % too great (which loses energy) to
// 0.5 % too small (which gains).
float ggxAlbedo(vec3 wo, vec2 alpha)
{
    float cosO = abs(wo.z);
    if (floatBitsToUint(alpha.x) == floatBitsToUint(alpha.y)) return ggxAlbedo(cosO, alpha.x);
    float wide = max(alpha.x, alpha.y), narrow = min(alpha.x, alpha.y);
    float along = alpha.x > alpha.y ? wo.x : wo.y; // in the direction of the greater alpha
    float azimuth = min(along * along / max(1.0 - cosO * cosO, 1e-12), 1.0);
    vec2 t = cosO / (cosO + vec2(wide, narrow));
    float sum = 0.318296;
    vec4 h;
    h = vec4(-1.23493, -0.570002, 0.447385, 0.407054) +
        azimuth * vec4(0.455926, -3.56819, 0.640989, -4.26306) +
        t.x * vec4(-0.923274, -3.20876, -1.06528, -0.839028) +
        t.y * vec4(1.58681, 1.18896, -0.536264, -1.94883) +
        wide * vec4(-0.335741, 0.496985, 0.0256622, -1.20491) +
        narrow * vec4(-1.45018, -0.607521, -0.481941, 2.22957);
    sum += dot(h / (1.0 + abs(h)), vec4(0.825615, -3.96621, 0.371099, 0.163459));
    h = vec4(-0.347758, -0.539047, -0.364675, 0.780248) +
        azimuth * vec4(-2.39131, -0.265067, -0.180287, 0.0751393) +
        t.x * vec4(-4.23416, 0.478359, 0.48099, 0.0827217) +
        t.y * vec4(0.830411, 0.0745196, 0.211392, -0.562472) +
        wide * vec4(0.592905, 0.454863, 0.131384, -0.296127) +
        narrow * vec4(-0.486025, 0.111707, -0.30346, -0.295714);
    sum += dot(h / (1.0 + abs(h)), vec4(1.73084, -2.09831, 2.04297, -2.93665));
    h = vec4(-0.74889, -0.222837, 0.576255, 2.51253) +
        azimuth * vec4(-3.73427, 0.292341, -0.115852, -0.487793) +
        t.x * vec4(-2.66811, 0.956847, 0.28689, -3.78297) +
        t.y * vec4(1.55119, 0.00708302, -0.723839, -0.104809) +
        wide * vec4(0.287235, -0.121149, 0.0487373, -0.0530531) +
        narrow * vec4(-0.87849, -0.0987905, 0.397957, -0.197777);
    sum += dot(h / (1.0 + abs(h)), vec4(2.42001, 0.661708, 3.29388, 0.161282));
    return min(ggxAlbedo(cosO, sqrt(0.5 * dot(alpha, alpha))) * exp((1.0 - narrow / wide) * sum), 1.0);
}

// Two cosines at the micro normal, and their shares (which sum to 1), that stand for the distribution of reflected
// light: the albedo for any Fresnel curve F without a jump is albedo * dot(share, F(cosine)), within 0.012 for cosO
// above 0.05 and 0.018 below, RMS 0.003 (dielectrics of index 1.05 to 3, Schlick). A critical angle is a jump:
// interface_table.glsl.
struct GgxMean {
    vec2 cosine;
    vec2 share;
};

GgxMean ggxMean(float cosO, float a)
{
    float t = cosO / (cosO + a);
    float c1 = 0.798896 + a * (-0.860356 + a * 0.397372) + t * (1.49975 + a * (-4.44746 + a * 3.44357) + t * (-5.85792
        + a * (4.39223 + a * -8.45097) + t * (6.83271 + a * (5.59394 + a * 16.4037) + t * (-4.08746 + a * (-10.8387 +
        a * -14.6591)))));
    float c2 = 5.23643 + a * (-13.769 + a * 12.0727) + t * (35.9722 + a * (-285.189 + a * 583.299) + t * (-71.8531 + a
        * (277.695 + a * -67.4584) + t * (63.3831 + a * (-19.6201 + a * -116.167) + t * (-29.2222 + a * (-48.4182 + a
        * -83.5425)))));
    float s = 0.555574 + a * (-0.526535 + a * 0.360082) + t * (1.46167 + a * (-0.719967 + a * 0.392713) + t *
        (-3.59186 + a * (-6.08447 + a * -5.42289) + t * (4.93675 + a * (24.0616 + a * 18.8825) + t * (-2.53626 + a *
        (-20.6127 + a * -27.5049)))));
    s = clamp(s, 0.0, 1.0);
    return GgxMean(clamp(vec2(cosO) + a * vec2(c1, c2), 0.0, 1.0), vec2(s, 1.0 - s));
}

GgxMean ggxMean(vec3 wo, vec2 alpha)
{
    return ggxMean(abs(wo.z), ggxViewAlpha(wo, alpha));
}

// What masking loses of F = 1, relative to what it leaves.
float ggxLoss(vec3 wo, vec2 alpha)
{
    float e = ggxAlbedo(wo, alpha);
    return (1.0 - e) / e;
}

// Energy compensated Fresnel term (Turquin 2019, equation 16): F (1 + F (1 - E) / E), E the albedo for F = 1.
float ggxCompensate(float f, float loss) { return f * (1.0 + f * loss); }
vec3 ggxCompensate(vec3 f, float loss) { return f * (1.0 + f * loss); }

// Albedo of the compensated lobe, for the Fresnel term at the two cosines of `mean`.
vec3 ggxCompensatedAlbedo(GgxMean mean, float loss, vec3 f1, vec3 f2)
{
    return (mean.share.x * ggxCompensate(f1, loss) + mean.share.y * ggxCompensate(f2, loss)) / (1.0 + loss);
}

#endif
