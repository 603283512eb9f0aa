// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The film: 64-bit fixed-point sums by integer atomics (exact in any order), and FirstSample values written by one path.
#ifndef WAVEFRONT_LIB_FILM_GLSL
#define WAVEFRONT_LIB_FILM_GLSL
#include "lib/bindings.glsl"
#include "lib/queue.glsl"

void filmAdd(uint pixel, uint channel, float value) {
  float v = isnan(value) ? 0.0 : clamp(value, -kFilmClamp, kFilmClamp) * kFilmScale;
  atomicAdd(filmSums[pixel * frame.sumChannels + channel], uint64_t(int64_t(roundEven(v))));
}
void filmAdd3(uint pixel, uint channel, vec3 value) {
  filmAdd(pixel, channel, value.x);
  filmAdd(pixel, channel + 1u, value.y);
  filmAdd(pixel, channel + 2u, value.z);
}
// A whole sample's colour. Values that are not finite are dropped and reported: one bad sample must not blacken a pixel.
void filmAddSample(uint pixel, vec3 radiance, float alpha) {
  radiance *= frame.exposureScale;
  if (any(isnan(radiance)) || any(isinf(radiance))) { reportError(kErrorNonFinite); radiance = vec3(0.0); }
  if (frame.radianceClamp > 0.0) radiance = min(radiance, vec3(frame.radianceClamp));
  filmAdd3(pixel, frame.colorChannel, radiance);
  filmAdd(pixel, frame.colorChannel + 3u, alpha);
  filmAdd(pixel, frame.countChannel, 1.0);
}
void filmSetFirst(uint pixel, uint channel, uint bits) {
  if (channel != kNoChannel) filmFirst[pixel * frame.firstChannels + channel] = bits;
}
#endif
