// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Directional albedos of GGX lobes (height-correlated Smith, single scattering) as polynomials, so that no lobe reads
// a table. Fitted to quadrature over cosO in [0.001, 1], alpha in [0.001, 1] by resources/albedo/fit_bsdf_albedo.py;
// the natural coordinate is t = cosO / (cosO + alpha): at small alpha everything depends on cosO / alpha alone.
// Errors are given at each function, for isotropic alpha. An anisotropic lobe is taken as one of
// ggxMeanAlpha or ggxViewAlpha.
#ifndef WAVEFRONT_BSDF_GGX_ALBEDO_GLSL
#define WAVEFRONT_BSDF_GGX_ALBEDO_GLSL
#include "fresnel.glsl"

// Albedo for F = 1, relative error below 0.5 % (0.8 % at cosO < 0.001).
float ggxAlbedo(float cosO, float a)
{
    float t = cosO / (cosO + a);
    return 0.991665 + a * (0.0295469 + a * (-0.0208267 + a * -0.0073178)) + t * (0.0489169 + a * (-1.61719 + a *
        (-2.80995 + a * 0.627514)) + t * (-1.58789 + a * (10.8626 + a * (5.41783 + a * 2.55933)) + t * (2.23711 + a *
        (-24.1364 + a * (-25.7817 + a * -12.0861)) + t * (0.388369 + a * (22.1136 + a * (40.9895 + a * 41.247)) + t *
        (-1.0805 + a * (-7.64329 + a * (-13.201 + a * -48.4905)))))));
}

// Two cosines at the micro normal, and their shares (which sum to 1), that stand for the distribution of reflected
// light: the albedo for any Fresnel curve F without a jump is albedo * dot(share, F(cosine)), within 0.012 for cosO
// above 0.05 and 0.018 below, RMS 0.003 (dielectrics of index 1.05 to 3, Schlick). A critical angle is a jump, for
// which there is another fit below.
struct GgxMean {
    float albedo; // for F = 1
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
    return GgxMean(ggxAlbedo(cosO, a), clamp(vec2(cosO) + a * vec2(c1, c2), 0.0, 1.0), vec2(s, 1.0 - s));
}

// Energy compensated Fresnel term (Turquin 2019, equation 16): F (1 + F (1 - E) / E), E the albedo for F = 1.
float ggxCompensate(float f, float albedo) { return f * (1.0 + f * ((1.0 - albedo) / albedo)); }
vec3 ggxCompensate(vec3 f, float albedo) { return f * (1.0 + f * ((1.0 - albedo) / albedo)); }

// The isotropic roughness that stands for an anisotropic one. For the energy compensation it is MaterialX's average,
// which knows no direction: it gives back too little (up to 20 % of the light is lost at alpha 0.8, 0.3) and hardly
// ever too much (2.5 %). For a Fresnel-weighted albedo it is what the view sees: the roughness along its azimuth at
// grazing wo, the root mean square at the normal (dielectric of index 1.5: error below 0.02; a conductor's up to 0.25).
float ggxMeanAlpha(vec2 alpha) { return sqrt(alpha.x * alpha.y); }
float ggxViewAlpha(vec3 wo, vec2 alpha)
{
    vec2 t = alpha * wo.xy;
    return sqrt(dot(t, t) + 0.5 * dot(alpha, alpha) * wo.z * wo.z);
}

// Albedo of the compensated lobe, for the Fresnel term at the two cosines of `mean`; e: the albedo that it compensates.
float ggxCompensatedAlbedo(GgxMean mean, float e, vec2 f)
{
    return mean.albedo * dot(mean.share, vec2(ggxCompensate(f.x, e), ggxCompensate(f.y, e)));
}
vec3 ggxCompensatedAlbedo(GgxMean mean, float e, vec3 f1, vec3 f2)
{
    return mean.albedo * (mean.share.x * ggxCompensate(f1, e) + mean.share.y * ggxCompensate(f2, e));
}

// What follows serves the refracting lobes, where an albedo only steers the choice of a lobe: it is rougher.

// Share of refracted light that masking lets pass, eta > 1. Error up to 0.1 at grazing wo.
float ggxRefractedShare(float cosO, float a, float eta)
{
    float t = cosO / (cosO + a);
    float g0 = 0.90605 + a * (0.583622 + a * -0.261859) + t * (0.464077 + a * (-0.638458 + a * -2.50935) + t *
        (-0.34479 + a * (-1.36398 + a * 5.31299)));
    float g1 = 0.0813708 + a * (-0.841436 + a * 0.353984) + t * (-0.456018 + a * (-2.27234 + a * 2.86164) + t *
        (0.332463 + a * (5.1531 + a * -2.87326)));
    return clamp(g0 + g1 / eta, 0.0, 1.0);
}

// Albedo of refraction into the thinner medium, eta < 1: a Fresnel curve whose critical angle is smeared by roughness.
// RMS error 0.03, up to 0.22 beside the critical angle. (What passes before masking, what masking lets pass of it.)
vec2 ggxInnerTransmission(float cosO, float a, float eta)
{
    float t = cosO / (cosO + a);
    float coneShare = min(9.0 * eta * eta, 1.0); // the fit ends at index 3; beyond, the cone of transmission closes
    eta = max(eta, 1.0 / 3.0);
    float shift = 1.06905 + a * -0.0236079 + t * (-0.995666 + a * -0.698873) +
        eta * (-0.23554 + a * -0.580285 + t * (0.014228 + a * 0.162582));
    float smear = -0.00367215 + a * 0.00925685 + t * (0.0140421 + a * 0.174801) +
        eta * (0.0157705 + a * -0.0225605 + t * (-0.0342046 + a * -0.761954));
    float loss = 2.00282 + a * -1.28454 + t * (0.656984 + a * 0.584102) +
        eta * (-0.0171825 + a * 0.0444184 + t * (-3.18629 + a * 0.416584));
    float c = clamp(cosO + a * shift, 1e-3, 1.0);
    smear = abs(a * smear) + 1e-6;
    float eta2 = eta * eta;
    float g2 = eta2 - 1.0 + c * c;
    float g = sqrt(0.5 * (g2 + sqrt(g2 * g2 + smear * smear)));
    float rs = (c - g) / (c + g);
    float rp = (eta2 * c - g) / (eta2 * c + g);
    return vec2(coneShare * (1.0 - 0.5 * (rs * rs + rp * rp)), clamp(1.0 - a * loss, 0.0, 1.0));
}

// (reflection, refraction) of an uncompensated dielectric interface, eta = index beyond / index on wo's side.
vec2 ggxDielectricAlbedo(float cosO, float a, float eta)
{
    GgxMean mean = ggxMean(cosO, a);
    float f = dot(mean.share, vec2(fresnelDielectric(mean.cosine.x, eta), fresnelDielectric(mean.cosine.y, eta)));
    vec2 inner = ggxInnerTransmission(cosO, a, eta);
    return eta > 1.0 ? vec2(f * mean.albedo, (1.0 - f) * ggxRefractedShare(cosO, a, eta))
                     : vec2((1.0 - inner.x) * mean.albedo, inner.x * inner.y);
}

#endif
