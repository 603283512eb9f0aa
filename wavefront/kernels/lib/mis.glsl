// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Multiple importance sampling weights (Veach 1997).
#ifndef WAVEFRONT_LIB_MIS_GLSL
#define WAVEFRONT_LIB_MIS_GLSL
// Power heuristic with exponent 2, on the ratio: pdfs of narrow lobes overflow when squared.
float powerHeuristic(float a, float b) {
  float r = b / a;
  return 1.0 / (1.0 + r * r);
}
// Solid-angle pdf of a uniformly sampled point on a triangle with these world edges (both sides emit).
float trianglePdf(vec3 e1, vec3 e2, vec3 wi, float distance) {
  float projected = 0.5 * abs(dot(cross(e1, e2), wi));
  return projected > 0.0 ? distance * distance / projected : 0.0;
}
#endif
