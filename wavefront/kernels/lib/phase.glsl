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
// Direction of travel after scattering (Witt 1977, "Multiple scattering in reflection nebulae", equation 19).
vec3 phaseSample(float g, vec3 direction, vec2 u) {
  float s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u.x);
  float cosine = abs(g) < 1e-3 ? 2.0 * u.x - 1.0 : clamp((1.0 + g * g - s * s) / (2.0 * g), -1.0, 1.0);
  float sine = sqrt(max(0.0, 1.0 - cosine * cosine)), phi = 6.28318530718 * u.y;
  return normalize(toWorld(frameFromNormal(direction), vec3(sine * cos(phi), sine * sin(phi), cosine)));
}
#endif
