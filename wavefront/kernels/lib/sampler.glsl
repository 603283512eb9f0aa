// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Owen-scrambled Sobol keyed by (pixel, sample, dimension): Burley 2020, "Practical Hash-based Owen Scrambling" (JCGT
// 9(4)). Dimensions are padded in pairs: each pair is a (0,2)-sequence whose index is shuffled by its own hash, so no
// table and no limit on dimensions. Random numbers never depend on slot, thread or order.
#ifndef WAVEFRONT_LIB_SAMPLER_GLSL
#define WAVEFRONT_LIB_SAMPLER_GLSL

uint hashUint(uint x) {  // Wang/PCG-like finaliser "lowbias32" (Wellons)
  x ^= x >> 16; x *= 0x7feb352du; x ^= x >> 15; x *= 0x846ca68bu; x ^= x >> 16;
  return x;
}
uint hashCombine(uint seed, uint v) { return hashUint(seed ^ (v + 0x9e3779b9u + (seed << 6) + (seed >> 2))); }

// Laine-Karras permutation with the constants of Vegdahl 2021 ("Building a Better LK Hash"); works on reversed bits.
uint laineKarras(uint x, uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}
uint owenScramble(uint x, uint seed) { return bitfieldReverse(laineKarras(bitfieldReverse(x), seed)); }

// Second dimension of Sobol's sequence, of an index whose bits are reversed (the first dimension is that reversal). Its
// matrix is Pascal's triangle modulo 2, in which the triangle of half the size stands three times (Sierpinski's): a step for
// each of the five halvings. A loop over the bits of the index, all of which count once it is scrambled, takes 32.
uint sobol2OfReversed(uint x) {
  x ^= x << 16; x ^= (x & 0x00ff00ffu) << 8; x ^= (x & 0x0f0f0f0fu) << 4; x ^= (x & 0x33333333u) << 2; x ^= (x & 0x55555555u) << 1;
  return x;
}
float unitFloat(uint x) { return float(x >> 8) * 5.9604644775390625e-8; }

// A 2-D point of the sequence of (pixelSeed, pair) at `index`.
vec2 sample2D(uint pixelSeed, uint index, uint pair) {
  uint seed = hashCombine(pixelSeed, pair);
  uint x = laineKarras(bitfieldReverse(index), seed);  // the shuffled index, reversed
  uint y = sobol2OfReversed(x);
  return vec2(unitFloat(owenScramble(x, hashUint(seed ^ 0xa511e9b3u))), unitFloat(owenScramble(y, hashUint(seed ^ 0x63d83595u))));
}
float sample1D(uint pixelSeed, uint index, uint pair) {
  uint seed = hashCombine(pixelSeed, pair);
  uint x = laineKarras(bitfieldReverse(index), seed);
  return unitFloat(owenScramble(x, hashUint(seed ^ 0xa511e9b3u)));
}

// Pairs: camera first, then a block per bounce.
const uint kPairPixel = 0u;
const uint kPairLens = 1u;
const uint kPairTime = 2u;
const uint kPairFirstBounce = 4u;
const uint kPairsPerBounce = 5u;
const uint kPairLightPick = 0u;
const uint kPairLightPoint = 1u;
const uint kPairLobe = 2u;
const uint kPairDirection = 3u;
const uint kPairExit = 4u;  // direction in which a random walk leaves the surface
uint bouncePair(uint bounce, uint pair) { return kPairFirstBounce + bounce * kPairsPerBounce + pair; }
// Events inside of a body cost no bounce: a block of pairs per event since the path entered it.
const uint kMediumDirection = 0u;
const uint kMediumFlight = 1u;  // and the second number: Russian roulette
const uint kMediumLightPick = 2u;
const uint kMediumLightPoint = 3u;
const uint kMediumWalkEvents = 2048u;  // events of random walks start here: one may begin inside of a body that scatters
uint mediumPair(uint bounce, uint event, uint pair) { return 0x40000000u + ((bounce << 12) + event) * 4u + pair; }
// Passing through a transparent surface costs no bounce: its random number comes from a hash of its own.
float samplePass(uint pixelSeed, uint index, uint bounce, uint passes) {
  return unitFloat(hashCombine(hashCombine(hashCombine(pixelSeed, index), bounce + 0x51ed270bu), passes));
}
uint pixelSeed(uint x, uint y, uint seed) { return hashCombine(hashCombine(hashUint(x + 0x68bc21ebu), y), seed); }
#endif
