// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What traversal asks of the scene around it.
#ifndef WAVEFRONT_LIB_TRAVERSAL_HOOKS_GLSL
#define WAVEFRONT_LIB_TRAVERSAL_HOOKS_GLSL
#include "lib/bindings.glsl"
#include "lib/queue.glsl"

#define WAVEFRONT_TLAS_ROOT frame.tlasRoot

// Opaque: the material of this slot has no opacity kernel.
bool isTriangleOpaque(uint instance, uint slot) {
  uint bindingBase = texelFetch(instanceRecords, int(instance * kInstanceTexels + 7u)).y;
  uint binding = texelFetch(indexStream, int(bindingBase + slot)).x;
  return texelFetch(bindingRecords, int(binding)).y == kNoBucket;
}
void reportTraversalOverflow() { reportError(kErrorTraversalBudget); }
#endif
