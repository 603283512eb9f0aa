// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>
#include <chrono>

#include "delegate/capture/captured_scene.h"
#include "materialgen/embedded_glsl.h"
#include "materialgen/materialgen.h"
#include "materialgen/spirv_cache.h"

namespace delegate {
namespace {

using namespace wavefront;

using KernelPointer = std::shared_ptr<const CapturedKernel>;

KernelCode CodeOf(const CapturedKernel& kernel, KernelEntry entry, bool sameGlsl) {
  const auto e = static_cast<std::size_t>(entry);
  if (sameGlsl && !kernel.spirv[e].empty()) return {kernel.spirv[e], {}, 0, true};
  const auto start = std::chrono::steady_clock::now();
  KernelCode code;
  code.spirv = materialgen::OptimizeSpirv(materialgen::CompileGlsl(kernel.glsl[e], kernel.key, &code.error));
  code.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return code;
}

Result<std::vector<uint32_t>> Link(const std::map<std::string, KernelPointer>& kernels, std::span<const std::string> keys) {
  std::vector<std::shared_ptr<const materialgen::KernelSource>> sources;
  for (const std::string& key : keys) {
    const CapturedKernel& kernel = *kernels.at(key);
    auto source = std::make_shared<materialgen::KernelSource>();
    source->key = key;
    source->surface = kernel.glsl[0];
    source->opacity = kernel.glsl[1];
    source->emission = kernel.glsl[2];
    sources.push_back(std::move(source));
  }
  std::string error;
  std::vector<uint32_t> spirv = materialgen::CompileGlsl(materialgen::LinkMegakernel(sources), "megakernel", &error);
  if (spirv.empty()) return Error{error};
  return spirv;
}

void SendKernels(CapturedScene& scene, Renderer& renderer) {
  const bool sameGlsl = scene.info.glslHash == IncludedGlslHash();
  std::map<std::string, KernelPointer> kernels;
  for (CapturedKernel& captured : scene.kernels) {
    auto kernel = std::make_shared<const CapturedKernel>(std::move(captured));
    kernels[kernel->key] = kernel;
    MaterialKernelData data;
    data.key = kernel->key;
    data.primvars = kernel->primvars;
    data.hasOpacity = !kernel->glsl[1].empty();
    data.hasEmission = !kernel->glsl[2].empty();
    data.user = kernel->key;
    data.compile = [kernel, sameGlsl](KernelEntry entry) { return CodeOf(*kernel, entry, sameGlsl); };
    renderer.RegisterKernel(std::move(data));
  }
  renderer.SetMegakernelLinker([kernels](std::span<const std::string> keys) { return Link(kernels, keys); });
}

// Parameter blocks hold texture ids, so the ids must be the recorded ones: those that were let go before the capture are
// made again and let go.
Status SendTextures(CapturedScene& scene, Renderer& renderer) {
  uint32_t last = 0;
  if (!scene.textures.empty()) last = scene.textures.rbegin()->first;
  if (!scene.tiles.empty()) last = std::max(last, scene.tiles.rbegin()->first);
  if (scene.textures.empty() && scene.tiles.empty()) return {};
  std::vector<TextureId> unused;
  for (uint32_t wanted = 0; wanted <= last; ++wanted) {
    TextureId id;
    if (const auto texture = scene.textures.find(wanted); texture != scene.textures.end()) {
      id = renderer.CreateTexture(std::move(texture->second));
    } else if (const auto tiles = scene.tiles.find(wanted); tiles != scene.tiles.end()) {
      id = renderer.CreateTextureTiles(std::move(tiles->second));
    } else {
      id = renderer.CreateTexture({"unused", 1, 1, TexelFormat::Rgba8Unorm, std::vector<uint8_t>(4)});
      unused.push_back(id);
    }
    if (id != wanted) return Error{"This renderer numbers textures in another way than the one that was captured."};
  }
  for (TextureId id : unused) renderer.DestroyTexture(id);
  return {};
}

}  // namespace

std::string IncludedGlslHash() {
  static const std::string hash = materialgen::HashOf(materialgen::EmbeddedGlslText());
  return hash;
}

Status SendScene(CapturedScene scene, Renderer& renderer) {
  if (scene.info.glslHash != IncludedGlslHash())
    for (const auto& [id, mesh] : scene.meshes)
      for (const auto& displacement : mesh.displacements)
        if (displacement)
          return Error{"The scene " + scene.info.name + " displaces " + mesh.path +
                       " by a kernel of another version of hdWavefront. Capture the stage again."};
  SendKernels(scene, renderer);
  if (Status status = SendTextures(scene, renderer); !status) return status;
  // The core sorts by path and keeps the order of ids where paths are equal, so that all come in that order.
  std::map<MaterialId, MaterialId> materials;
  const auto materialOf = [&](MaterialId id) { return id == kInvalidId ? kInvalidId : materials.at(id); };
  for (auto& [id, material] : scene.materials) materials[id] = renderer.CreateMaterial(std::move(material));
  if (scene.defaultMaterial != kInvalidId) renderer.SetDefaultMaterial(materialOf(scene.defaultMaterial));
  std::map<MeshId, MeshId> meshes;
  for (auto& [id, mesh] : scene.meshes) meshes[id] = renderer.CreateMesh(std::move(mesh));
  for (auto& [id, data] : scene.instances) {
    data.mesh = meshes.at(data.mesh);
    for (MaterialId& material : data.materials) material = materialOf(material);
    renderer.CreateInstances(std::move(data));
  }
  for (auto& [id, light] : scene.lights) renderer.CreateLight(std::move(light));
  renderer.SetCamera(scene.camera);
  renderer.SetRenderSettings(scene.settings);
  return {};
}

}  // namespace delegate
