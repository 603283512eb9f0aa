// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The megakernel: the scheduler's loop (path_tracer.cpp, RecordIteration) inside of one kernel, for one path, with path
// regeneration. It is the rival of the paper's comparison and the oracle of this renderer: same functions, same numbers.
// pushWord1: turns at most; pushWord2: loop iterations after which no turn is begun. Software Vulkan ends every loop of
// an invocation after 65,535 iterations in all, silently, and counts an iteration of any of the eight paths of a
// subgroup: a path that stays below an eighth of that is safe. State is saved and the host dispatches again.
// Reads: the whole path state, the work that mega_turn hands out. Writes: path state, film, counters.
// Runs after: mega_turn.

const uint kFixedLoops = 64u;   // of a turn, an eighth: loops of constant length run side by side (sampler.glsl, geometry.glsl)
const uint kSafeLoops = 8191u;

uint loopsSoFar() { return megaLoops + 2u * traversalSteps; }

void main() {
  uint path = gl_GlobalInvocationID.x;
  if (path >= frame.poolSize) return;
  fetchState(path);
  [[unroll]] for (uint q = 0u; q < kQueueKinds; ++q) megaItems[q] = 0u;
  bool wasActive = (megaState[kChunkIds].w & kPhaseMask) != kPhaseIdle;
  [[dont_unroll]] for (uint turn = 0u; turn < pushWord1 && loopsSoFar() < pushWord2; ++turn) {
    megaQueues = 0u;
    megaBucket = kNoBucket;
    stageLogic();
    stageLightSample();
    stageEscape();
    stageMediumScatter();
    stageSubsurfaceWalk();
    stageNewPath();
    if ((megaState[kChunkIds].w & kPhaseMask) == kPhaseIdle) break;  // no work left
    megaMaterials();
    stageSubsurfaceExit();
    stageExtensionRay();
    stageShadowRay();
    megaLoops += kFixedLoops + frame.infiniteLightCount;
  }
  if (pushWord2 <= kSafeLoops && loopsSoFar() > kSafeLoops) reportError(kErrorTraversalBudget);
  writeState(path);
  // Modulo 2^32: a path that ended takes one off.
  bool isActive = (megaState[kChunkIds].w & kPhaseMask) != kPhaseIdle;
  if (isActive != wasActive) atomicAdd(counters[kActivePaths], isActive ? 1u : 0xffffffffu);
  [[unroll]] for (uint q = 0u; q < kQueueKinds; ++q) {
    if (megaItems[q] != 0u) atomicAdd(counters[kQueueBase + q * kQueueStride + kQueueFill], megaItems[q]);
  }
}
