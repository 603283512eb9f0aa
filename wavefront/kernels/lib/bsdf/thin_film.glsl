// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// Fresnel terms of an interface under a thin film: Belcour and Barla 2017, "A Practical Extension to Microfacet
// Theory for the Modeling of Varying Iridescence", with three bounces, as MaterialX 1.39's mx_fresnel_airy: the
// outside is vacuum, and spectra are integrated by Gaussian fits of the sensitivities. One departure: under
// generalized_schlick MaterialX halves the reflectance of the base, so that a film of index 1 would darken it; here
// such a film changes nothing. film = (thickness in nanometers, index); thickness 0: the plain term. Generated
// kernels without film pass a constant 0, and the compiler drops all of this.
#ifndef WAVEFRONT_BSDF_THIN_FILM_GLSL
#define WAVEFRONT_BSDF_THIN_FILM_GLSL
#include "fresnel.glsl"
#include "ggx_albedo.glsl"

vec2 thinFilmMake(vec2 film) { return vec2(bsdfClamp(film.x, 0.0, 1e5), bsdfClamp(film.y, 1.0, 10.0)); }

// Reflectance of the base under the film and its phase shift, per polarisation and channel.
struct FilmBase {
    vec3 reflectP, reflectS;
    vec3 phaseP, phaseS;
};

// Integral of the sensitivities (XYZ) against a cosine of the optical path difference (in meters) with a phase shift.
vec3 thinFilmSensitivity(float path, vec3 shift)
{
    float phase = 2.0 * kBsdfPi * path;
    float square = phase * phase;
    const vec3 peak = vec3(1.6810e6, 1.7953e6, 2.2084e6), width = vec3(4.3278e9, 9.3046e9, 6.6121e9);
    // value * sqrt(2 pi width) / 1.0685e-7
    const vec3 height = vec3(0.84659, 1.00021, 1.00113);
    vec3 xyz = height * cos(peak * phase + shift) * exp(-width * square);
    xyz.x += 0.15387 * cos(2.2399e6 * phase + shift.x) * exp(-4.5282e9 * square);
    return xyz;
}

// Equations 10 and 11 for one polarisation, in XYZ. r12, phase21: the film's outer face; cosines are accounted for.
vec3 thinFilmPolarised(float r12, float phase21, vec3 r23, vec3 phase23, float path)
{
    float t121 = 1.0 - r12;
    vec3 r123 = sqrt(max(r12 * r23, vec3(0.0)));
    vec3 rs = t121 * t121 * r23 / max(vec3(1.0) - r12 * r23, vec3(1e-6));
    vec3 sum = r12 + rs;
    vec3 amplitude = rs - t121;
    for (int m = 1; m <= 2; ++m) {
        amplitude *= r123;
        sum += amplitude * 2.0 * thinFilmSensitivity(float(m) * path, float(m) * (phase23 + phase21));
    }
    return sum;
}

// cosI: outside; cosT: in the film.
vec3 thinFilmReflectance(float cosI, float cosT, vec2 film, FilmBase base)
{
    float n = film.y;
    float rs = (cosI - n * cosT) / (cosI + n * cosT), rp = (n * cosI - cosT) / (n * cosI + cosT);
    float path = 2.0 * n * cosT * film.x * 1e-9;
    // Brewster's angle: cos(atan(n)).
    float phaseP = cosI * sqrt(1.0 + n * n) < 1.0 ? 0.0 : kBsdfPi;
    vec3 xyz = 0.5 * (thinFilmPolarised(rp * rp, phaseP, base.reflectP, base.phaseP, path) +
                      thinFilmPolarised(rs * rs, kBsdfPi, base.reflectS, base.phaseS, path));
    // To RGB by MaterialX's matrix (CIE RGB, illuminant E: white stays white).
    vec3 rgb = vec3(dot(vec3(2.3706743, -0.9000405, -0.4706338), xyz), dot(vec3(-0.5138850, 1.4253036, 0.0885814), xyz),
                    dot(vec3(0.0052982, -0.0146949, 1.0093968), xyz));
    return clamp(rgb, 0.0, 1.0);
}

float thinFilmCosine(float cosI, vec2 film) { return sqrt(max(1.0 - (1.0 - cosI * cosI) / (film.y * film.y), 0.0)); }

// A base of complex index n + ik under the film.
FilmBase thinFilmConductor(float cosT, float film, vec3 n, vec3 k)
{
    float cos2 = cosT * cosT, sin2 = 1.0 - cos2;
    vec3 n2 = n * n / (film * film), k2 = k * k / (film * film);
    vec3 t0 = n2 - k2 - vec3(sin2);
    vec3 ab = sqrt(t0 * t0 + 4.0 * n2 * k2);
    vec3 t1 = ab + vec3(cos2);
    vec3 u2 = max(0.5 * (ab + t0), vec3(0.0)), v2 = max(0.5 * (ab - t0), vec3(0.0));
    vec3 u = sqrt(u2), v = sqrt(v2);
    vec3 t2 = 2.0 * u * cosT;
    vec3 rs = (t1 - t2) / max(t1 + t2, vec3(1e-20));
    vec3 t3 = cos2 * ab + vec3(sin2 * sin2);
    vec3 t4 = t2 * sin2;
    vec3 rp = rs * (t3 - t4) / max(t3 + t4, vec3(1e-20));
    // u + iv = n cos of the transmitted ray, in units of the film's index (Belcour and Barla, supplemental).
    vec3 phaseS = atan(2.0 * v * cosT, u2 + v2 - vec3(cos2));
    vec3 nk = sqrt(n2 * k2);
    vec3 phaseP = atan(2.0 * cosT * (2.0 * nk * u - (n2 - k2) * v), bsdfSquare((n2 + k2) * cosT) - (u2 + v2));
    return FilmBase(max(rp, vec3(0.0)), max(rs, vec3(0.0)), phaseP, phaseS);
}

vec3 fresnelConductor(float cosI, vec3 n, vec3 k, vec2 film)
{
    if (film.x <= 0.0) return fresnelConductor(cosI, n, k);
    float cosT = thinFilmCosine(cosI, film);
    return thinFilmReflectance(cosI, cosT, film, thinFilmConductor(cosT, film.y, n, k));
}

// From the inside (eta < 1) the film reflects what it reflects at the angle outside, and beyond the critical angle all.
vec3 fresnelDielectric(float cosI, float eta, vec2 film)
{
    if (film.x <= 0.0) return vec3(fresnelDielectric(cosI, eta));
    float cosT2 = 1.0 - (1.0 - cosI * cosI) / (eta * eta);
    float outer = eta < 1.0 ? sqrt(max(cosT2, 0.0)) : cosI;
    vec3 f = fresnelConductor(outer, vec3(max(eta, 1.0 / eta)), vec3(0.0), film);
    return eta < 1.0 && cosT2 <= 0.0 ? vec3(1.0) : f;
}

// Albedo of the compensated reflection of a dielectric under a film; `plain`: without film.
vec3 filmAlbedo(GgxMean mean, float loss, float eta, float plain, vec2 film)
{
    // Two cosines do not catch the critical angle: from the inside, what passes is scaled as at the normal.
    if (eta < 1.0) {
        vec3 passing = (vec3(1.0) - fresnelDielectric(1.0, eta, film)) / (1.0 - fresnelDielectric(1.0, eta));
        return max(vec3(1.0) - (1.0 - plain) * passing, vec3(0.0));
    }
    vec3 sum = vec3(0.0);
    [[dont_unroll]] for (int i = 0; i < 2; ++i) {
        vec3 f = fresnelDielectric(i == 0 ? mean.cosine.x : mean.cosine.y, eta, film);
        sum += (i == 0 ? mean.share.x : mean.share.y) * ggxCompensate(f, loss);
    }
    return min(sum / (1.0 + loss), vec3(1.0));
}

vec3 fresnelSchlick(float cosI, SchlickFresnel s, vec2 film)
{
    if (film.x <= 0.0) return fresnelSchlick(cosI, s);
    float cosT = thinFilmCosine(cosI, film);
    vec3 f = fresnelSchlick(cosT, s);
    vec3 root = sqrt(clamp(s.f0, 0.01, 0.99));
    vec3 phase = mix(vec3(0.0), vec3(kBsdfPi), lessThan((1.0 + root) / (1.0 - root), vec3(film.y)));
    return thinFilmReflectance(cosI, cosT, film, FilmBase(f, f, phase, phase));
}

#endif
