// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Directional albedo of sheen_conty_kulla for white, a rational fit to quadrature
// (resources/albedo/fit_bsdf_albedo.py). x = cosine of wo. Error below 0.005 for roughness from 0.06, below 0.014
// (relative where the albedo passes 1) down to 0.005.
#ifndef WAVEFRONT_BSDF_SHEEN_ALBEDO_GLSL
#define WAVEFRONT_BSDF_SHEEN_ALBEDO_GLSL

float sheenContyKullaReflectance(float x, float roughness)
{
    float y = sqrt(roughness);
    float p = 32.7309 + y * (2490.75 + y * (7157.99 + y * (5049.58 + y * 2005.25))) + x * (-1158.18 + y * (6345.79 + y
        * (35373.5 + y * -15809.5)) + x * (-183.7 + y * (-18467.1 + y * 21021.7) + x * (2850.11 + y * -17053.6 + x *
        947.332)));
    float q = 1.0 + y * (92.0666 + y * (6073.98 + y * 20458.3)) + x * (666.217 + y * (4.67803 + y * 122796.0) + x *
        (395.361 + y * 4.60577e-06 + x * 71250.7));
    return max(p / q, 0.0);
}

#endif
