// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A whole scene as the core was told it: the updates of wavefront/scene.h by id, with the kernels of its materials. What
// `hdwavefront capture` writes, `wavefront-bench` replays, and what the bench makes its own scenes of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "wavefront/renderer.h"

namespace delegate {

constexpr std::size_t TexelBytes(wavefront::TexelFormat format) {
  using enum wavefront::TexelFormat;
  return format == Rgba8Unorm ? 4 : format == Rgba32Float ? 16 : 8;
}

// An entry (by wavefront::KernelEntry) is there if its GLSL is. The SPIR-V is what that GLSL compiles to, or empty: it
// is compiled when it is wanted.
struct CapturedKernel {
  std::string key;
  std::vector<std::string> primvars;  // names that it reads, in slot order
  std::array<std::string, wavefront::kKernelEntryCount> glsl;
  std::array<std::vector<uint32_t>, wavefront::kKernelEntryCount> spirv;
};

struct CaptureInfo {
  std::string name;      // of the scene: the stage's file name
  std::string version;   // of hdWavefront
  std::string glslHash;  // of the GLSL that kernels include: with another one, SPIR-V is compiled anew from the GLSL
};

// Ids are those of the renderer that was told; texture ids stand in parameter blocks too, so they must be given again.
struct CapturedScene {
  CaptureInfo info;
  std::vector<CapturedKernel> kernels;
  std::map<wavefront::TextureId, wavefront::TextureData> textures;
  std::map<wavefront::TextureId, std::vector<wavefront::TextureTile>> tiles;
  std::map<wavefront::MaterialId, wavefront::MaterialData> materials;
  wavefront::MaterialId defaultMaterial = wavefront::kInvalidId;
  std::map<wavefront::MeshId, wavefront::MeshData> meshes;
  std::map<wavefront::InstanceGroupId, wavefront::InstanceData> instances;
  std::map<wavefront::LightId, wavefront::LightData> lights;
  wavefront::CameraData camera;
  wavefront::RenderSettings settings;
};

// Hash of the GLSL of this build that kernels include.
std::string IncludedGlslHash();

// What the core takes for granted and would abort or misbehave without: ids that are known, indices and sizes that fit,
// finite positions. The error names the part ("MESHES") and what is wrong with it.
wavefront::Status CheckScene(const CapturedScene& scene);

// Halves textures until no side is longer. How many it had to; the picture is another one if any.
std::size_t ShrinkTextures(CapturedScene& scene, uint32_t maxSide);

// Tells a renderer that was told nothing before all of it; Commit is the caller's. The renderer gets a megakernel linker.
// The scene must have passed CheckScene, or been made by code that is right.
wavefront::Status SendScene(CapturedScene scene, wavefront::Renderer& renderer);

}  // namespace delegate
