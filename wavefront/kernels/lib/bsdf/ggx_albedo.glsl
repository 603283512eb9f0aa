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
// sigmoids. Relative error for alphas of a ratio up to 12, in 98 % of cases: 2.4 % too great (which loses energy) to
// 0.5 % too small (which gains).
float ggxAlbedo(vec3 wo, vec2 alpha)
{
    float cosO = abs(wo.z);
    if (floatBitsToUint(alpha.x) == floatBitsToUint(alpha.y)) return ggxAlbedo(cosO, alpha.x);
    float wide = max(alpha.x, alpha.y), narrow = min(alpha.x, alpha.y);
    float along = alpha.x > alpha.y ? wo.x : wo.y; // in the direction of the greater alpha
    float azimuth = min(along * along / max(1.0 - cosO * cosO, 1e-12), 1.0);
    vec2 t = cosO / (cosO + vec2(wide, narrow));
    float sum = -0.538354;
    vec4 h;
    h = vec4(-1.72857, -0.82112, 0.643366, -0.566661) +
        azimuth * vec4(0.835384, -3.88483, 0.300053, 0.109134) +
        t.x * vec4(-0.737396, -3.45306, -0.490989, -0.06837) +
        t.y * vec4(1.71453, 1.36055, -0.137989, 0.541255) +
        wide * vec4(-0.595414, 0.614372, -0.53084, -0.0519906) +
        narrow * vec4(0.0847818, -0.064367, -0.186832, -0.00321843);
    sum += dot(h / (1.0 + abs(h)), vec4(0.470665, -4.85745, 1.45913, -3.67074));
    h = vec4(-0.525517, -0.136381, -0.820374, 1.19345) +
        azimuth * vec4(-2.53057, -0.615173, -0.455432, 0.0812292) +
        t.x * vec4(-4.00016, -0.780131, 0.737977, 0.284827) +
        t.y * vec4(0.955648, 0.445885, 0.638671, -0.856085) +
        wide * vec4(0.563333, 0.135798, 0.137455, -0.400813) +
        narrow * vec4(-0.0337486, 0.170768, -0.124942, -0.400173);
    sum += dot(h / (1.0 + abs(h)), vec4(3.42783, -2.6084, 0.796219, -3.09323));
    h = vec4(-0.673746, -1.23984, 0.887251, 2.03634) +
        azimuth * vec4(-2.79298, 1.25397, -0.350604, -0.412843) +
        t.x * vec4(-1.78893, 0.218336, 1.00363, -3.34429) +
        t.y * vec4(1.27573, 1.64951, 0.370544, -0.0394927) +
        wide * vec4(0.209968, 0.949959, -0.116287, 0.0775255) +
        narrow * vec4(0.215425, -2.22258, 0.340414, -0.0825184);
    sum += dot(h / (1.0 + abs(h)), vec4(2.76327, 0.0989722, 1.59851, 0.187006));
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
