// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Henyey and Greenstein's phase function ("Diffuse radiation in the galaxy", 1941). `cosine`: between the directions of
// travel before and after; the mean cosine is g. Its value is its pdf.
#ifndef WAVEFRONT_LIB_PHASE_GLSL
#define WAVEFRONT_LIB_PHASE_GLSL
#include "lib/frame.glsl"

float phaseEval(float g, float cosine) {
  float d = max(1.0 + g * g - 2.0 * g * cosine, 1e-7);
  return 0.07957747154594767 * (1.0 - g * g) / (d * sqrt(d));
}
// Direction of travel after scattering (Witt 1977, "Multiple scattering in reflection nebulae", equation 19, solved for
// 1 - cosine, which narrow lobes need to more digits than the cosine has).
vec3 phaseSample(float g, vec3 direction, vec2 u) {
  float k = abs(g), d = 1.0 - k + 2.0 * k * u.x;
  float s = (1.0 - k * k) / d;
  float off = clamp((1.0 - k) * (1.0 - u.x) * (s + 1.0 - k) / d, 0.0, 2.0);
  float sine = sqrt(off * (2.0 - off)), phi = 6.28318530718 * u.y;
  Frame f = frameFromNormal(g < 0.0 ? -direction : direction);
  return normalize(toWorld(f, vec3(sine * cos(phi), sine * sin(phi), 1.0 - off)));
}
#endif
