// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Head of the megakernel: the fixed kernels, word for word, as functions over one path. What lib/path_state.glsl and
// lib/queue.glsl promise them is kept by the files of this folder. The generated text follows: the materials and
// `megaMaterials`, which calls the one that the path's bucket names; then megakernel/tail.glsl.
#define WAVEFRONT_MEGAKERNEL
#include "lib/bindings.glsl"
#include "lib/path_state.glsl"
#include "lib/queue.glsl"
#include "lib/traversal_hooks.glsl"  // before the first stage that reaches lib/bvh_fetch.glsl, which asks it for the root

#define main stageLogic
#include "logic.comp"
#undef main
#define main stageLightSample
#include "light_sample.comp"
#undef main
#define main stageEscape
#include "escape.comp"
#undef main
#define main stageMediumScatter
#include "medium_scatter.comp"
#undef main
#define main stageSubsurfaceWalk
#include "subsurface_walk.comp"
#undef main
#define main stageNewPath
#include "new_path.comp"
#undef main
#define main stageSubsurfaceExit
#include "subsurface_exit.comp"
#undef main
#define main stageExtensionRay
#include "extension_ray.comp"
#undef main
#define main stageShadowRay
#include "shadow_ray.comp"
#undef main
