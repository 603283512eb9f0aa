// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Path state: SoA of 16-byte chunks. Read through a texel buffer (fast to run and to compile on lavapipe), written
// through a storage buffer over the same memory; a kernel reads a chunk before it writes it, once.
#ifndef WAVEFRONT_LIB_PATH_STATE_GLSL
#define WAVEFRONT_LIB_PATH_STATE_GLSL
#include "lib/bindings.glsl"

#define WAVEFRONT_PATH_CHUNK(Name, index, doc) const uint kChunk##Name = index;
#include "shared/path_state.def"
#undef WAVEFRONT_PATH_CHUNK

// Flags word of chunk Ids: phase | a bit | bounce << 4 | passes << 12 | shadow passes << 20 | bits
const uint kPhaseIdle = 0u;       // no path; wants a new one
const uint kPhaseReady = 1u;      // rays are done: logic
const uint kPhaseOpacity = 2u;    // shadow ray met a surface that is not opaque: opacity kernel
const uint kPhaseEmission = 3u;   // light sample is seen, its emission is to be found: emission kernel
const uint kPhaseHeld = 4u;       // logic is done with it; its surface kernel is still being compiled
const uint kPhaseMask = 0x7u;
const uint kFlagSubsurface = 0x8u;          // on a random walk below a surface
const uint kBounceShift = 4u;
const uint kPassShift = 12u;
const uint kShadowPassShift = 20u;
const uint kFlagAovWritten = 0x10000000u;   // first hit's AOVs are in the film
const uint kFlagEnd = 0x40000000u;          // the path is over once its shadow ray is done; no extension ray was cast
const uint kFlagCovered = 0x20000000u;      // the camera ray met something: alpha 1
const uint kFlagMediumLight = 0x80000000u;  // the light was sampled from a point inside of a body

uvec4 fetchPath(uint chunk, uint path) { return texelFetch(pathStateRead, int(chunk * frame.poolSize + path)); }
void writePath(uint chunk, uint path, uvec4 value) { pathStateWrite[chunk * frame.poolSize + path] = value; }

// Kernels go by these five. In the megakernel the state of an invocation's one path stays in registers.
#ifdef WAVEFRONT_MEGAKERNEL
#include "megakernel/state.glsl"
#else
uvec4 loadPath(uint chunk, uint path) { return fetchPath(chunk, path); }
// One word of a chunk, where the others are not needed.
uint loadPathWord(uint chunk, uint path, uint word) { return pathStateWrite[chunk * frame.poolSize + path][word]; }
void storePath(uint chunk, uint path, uvec4 value) { writePath(chunk, path, value); }
// One word of a chunk: a quarter of the bytes, and no need to know the others.
void storePathWord(uint chunk, uint path, uint word, uint value) { pathStateWrite[chunk * frame.poolSize + path][word] = value; }
#endif
// Three words of a chunk, the fourth stays.
void storePathRgb(uint chunk, uint path, vec3 value) {
  storePathWord(chunk, path, 0u, floatBitsToUint(value.r));
  storePathWord(chunk, path, 1u, floatBitsToUint(value.g));
  storePathWord(chunk, path, 2u, floatBitsToUint(value.b));
}
void storePathF(uint chunk, uint path, vec4 value) { storePath(chunk, path, floatBitsToUint(value)); }

// Of a triangle record in chunk Hit, before the cast: a camera ray, which sees what others do not (visibility mask).
const uint kHitCamera = 0x80000000u;
// Of an instance in chunk ShadowOrigin: the ray starts at the t in chunk ShadowHit, not at 0.
const uint kShadowPassed = 0x80000000u;
bool shadowPassed(uint instance) { return (instance & kShadowPassed) != 0u && instance != 0xffffffffu; }

uint pathBounce(uint flags) { return (flags >> kBounceShift) & 0xffu; }
uint pathPasses(uint flags) { return (flags >> kPassShift) & 0xffu; }
uint pathShadowPasses(uint flags) { return (flags >> kShadowPassShift) & 0xffu; }
float pathAlpha(uint flags) { return (flags & kFlagCovered) != 0u ? 1.0 : 0.0; }
uint withPhase(uint flags, uint phase) { return (flags & ~kPhaseMask) | phase; }
#endif
