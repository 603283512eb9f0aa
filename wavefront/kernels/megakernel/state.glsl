// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The path-state contract of lib/path_state.glsl in the megakernel: an invocation works on one path, whose state is
// private. Every chunk is named by a constant, so that after inlining all of it is registers; memory is read when the
// dispatch begins and written when it ends.
#ifndef WAVEFRONT_MEGAKERNEL_STATE_GLSL
#define WAVEFRONT_MEGAKERNEL_STATE_GLSL

#define WAVEFRONT_PATH_CHUNK(Name, index, doc) + 1u
const uint kPathChunks = 0u
#include "shared/path_state.def"
;
#undef WAVEFRONT_PATH_CHUNK

uvec4 megaState[kPathChunks];

uvec4 loadPath(uint chunk, uint path) { return megaState[chunk]; }
uint loadPathWord(uint chunk, uint path, uint word) { return megaState[chunk][word]; }
void storePath(uint chunk, uint path, uvec4 value) { megaState[chunk] = value; }
void storePathWord(uint chunk, uint path, uint word, uint value) { megaState[chunk][word] = value; }

void fetchState(uint path) {
  [[unroll]] for (uint chunk = 0u; chunk < kPathChunks; ++chunk) megaState[chunk] = fetchPath(chunk, path);
}
void writeState(uint path) {
  [[unroll]] for (uint chunk = 0u; chunk < kPathChunks; ++chunk) writePath(chunk, path, megaState[chunk]);
}
#endif
