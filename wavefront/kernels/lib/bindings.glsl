// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The one descriptor set, as GLSL sees it; numbers are those of shared/bindings.def (a test compares them).
#ifndef WAVEFRONT_LIB_BINDINGS_GLSL
#define WAVEFRONT_LIB_BINDINGS_GLSL
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/scene_layout.h"
#include "shared/frame_constants.h"

layout(set = 0, binding = 0, scalar) uniform FrameConstantsBlock { FrameConstants frame; };
layout(set = 0, binding = 1, scalar) buffer PathStateWriteBlock { uvec4 pathStateWrite[]; };
layout(set = 0, binding = 2) uniform utextureBuffer pathStateRead;
layout(set = 0, binding = 3, scalar) buffer CountersBlock { uint counters[]; };
layout(set = 0, binding = 4, scalar) buffer QueueItemsBlock { uint queueItems[]; };
layout(set = 0, binding = 5, scalar) buffer FilmSumsBlock { uint64_t filmSums[]; };
layout(set = 0, binding = 6, scalar) buffer FilmFirstBlock { uint filmFirst[]; };
layout(set = 0, binding = 7, scalar) buffer ResolveBlock { uint resolved[]; };
layout(set = 0, binding = 8) uniform utextureBuffer bvhNodes;
layout(set = 0, binding = 9) uniform textureBuffer triangleRecords;
layout(set = 0, binding = 10) uniform utextureBuffer instanceRecords;
layout(set = 0, binding = 11) uniform utextureBuffer meshRecords;
layout(set = 0, binding = 12) uniform utextureBuffer indexStream;
layout(set = 0, binding = 13) uniform textureBuffer primvarStream;
layout(set = 0, binding = 14) uniform utextureBuffer bindingRecords;
layout(set = 0, binding = 15) uniform textureBuffer materialParameters;
layout(set = 0, binding = 16) uniform textureBuffer lightRecords;
layout(set = 0, binding = 17) uniform utextureBuffer lightItems;
layout(set = 0, binding = 18) uniform textureBuffer lightDistribution;
layout(set = 0, binding = 19) uniform utextureBuffer textureRecords;
layout(set = 0, binding = 20) uniform utextureBuffer pageTable;
layout(set = 0, binding = 21) uniform utextureBuffer texturePages;
layout(set = 0, binding = 22) uniform utextureBuffer lobeTable;
layout(set = 0, binding = 23) uniform utextureBuffer bvhWords;  // bvhNodes, word by word

// Per dispatch: which bucket a material kernel works on, and free words for others.
layout(push_constant, scalar) uniform PushConstants { uint pushBucket; uint pushWord1; uint pushWord2; uint pushWord3; };
#endif
