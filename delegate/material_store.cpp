// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/material_store.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <set>

#include "delegate/prims/same.h"
#include "wavefront/base/parallel.h"

namespace delegate {
namespace {

double Since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

wavefront::Severity Translate(materialgen::Severity severity) {
  switch (severity) {
    case materialgen::Severity::Info: return wavefront::Severity::Info;
    case materialgen::Severity::Warning: return wavefront::Severity::Warning;
    case materialgen::Severity::Error: return wavefront::Severity::Error;
  }
  return wavefront::Severity::Error;
}

TextureKey KeyOf(const materialgen::TextureRequest& request) {
  TextureKey key;
  key.resolvedPath = request.file.resolvedPath;
  if (key.resolvedPath.empty()) key.authoredPath = request.file.authoredPath;
  // What the node says comes first; "auto" leaves it to the asset, and then to the file.
  key.colorSpace = request.sourceColorSpace;
  if ((key.colorSpace.empty() || key.colorSpace == "auto") && !request.file.colorSpace.empty())
    key.colorSpace = request.file.colorSpace;
  key.isColor = request.isColor;
  return key;
}

// In a thread of the core's.
wavefront::KernelCode CompileEntry(const materialgen::KernelSource& source, wavefront::KernelEntry entry,
                                   materialgen::SpirvCache& cache, const wavefront::DiagnosticSink& sink) {
  const auto start = std::chrono::steady_clock::now();
  const bool isSurface = entry == wavefront::KernelEntry::Surface, isOpacity = entry == wavefront::KernelEntry::Opacity;
  const std::string& text = isSurface ? source.surface : isOpacity ? source.opacity : source.emission;
  wavefront::KernelCode code;
  if (auto kept = cache.Load(text)) {
    code.spirv = std::move(*kept);
    code.fromCache = true;
  } else {
    code.spirv = materialgen::OptimizeSpirv(materialgen::CompileGlsl(text, source.key, &code.error));
    cache.Store(text, code.spirv);
    if (const std::string trouble = cache.trouble(); !trouble.empty() && sink)
      sink({wavefront::Severity::Info, "kernel-cache-unusable", cache.folder(),
            "Compiled kernels are not kept for the next run: " + trouble});
  }
  code.milliseconds = Since(start);
  return code;
}

}  // namespace

MaterialStore::MaterialStore(wavefront::Renderer& renderer, materialgen::Generator& generator, TextureTable& textures,
                             wavefront::DiagnosticSink sink, unsigned threads)
    : renderer_(renderer), generator_(generator), textures_(textures), sink_(std::move(sink)), threads_(threads),
      cache_(std::make_shared<materialgen::SpirvCache>(materialgen::SpirvCache::DefaultFolder())) {
  renderer_.SetMegakernelLinker([this](std::span<const std::string> keys) { return LinkMegakernel(keys); });
}

MaterialStore::Material& MaterialStore::FindOrCreate(const std::string& path) {
  std::lock_guard lock(mutex_);
  auto& material = materials_[path];
  if (!material) {
    material = std::make_unique<Material>();
    material->path = path;
  }
  return *material;
}

void MaterialStore::Create(const std::string& path) { FindOrCreate(path); }

bool MaterialStore::Sync(const std::string& path, MaterialUpdate update) {
  Material& material = FindOrCreate(path);
  if (!Same(material.update, update)) {
    material.update = std::move(update);
    material.dirty = true;
  }
  return material.dirty || material.stale;
}

void MaterialStore::Destroy(const std::string& path) {
  std::lock_guard lock(mutex_);
  const auto found = materials_.find(path);
  if (found == materials_.end()) return;
  removed_.push_back(std::move(found->second));
  materials_.erase(found);
}

void MaterialStore::ReleaseTextures(Material& material) {
  for (uint32_t key : material.textureKeys) textures_.Release(key);
  for (uint32_t key : material.displacementKeys) textures_.Release(key);
  material.textureKeys.clear();
  material.displacementKeys.clear();
}

std::vector<uint32_t> MaterialStore::Acquire(const Material& material, const materialgen::CompiledMaterial& compiled) {
  std::vector<uint32_t> keys;
  for (const materialgen::TextureRequest& request : compiled.textures)
    keys.push_back(textures_.Acquire(KeyOf(request), request.file.authoredPath,
                                     request.node.empty() ? material.path : request.node));
  return keys;
}

void MaterialStore::SetOptions(const materialgen::GenerateOptions& options) {
  if (options.diffuseSubsurface == options_.diffuseSubsurface) return;
  options_ = options;
  std::lock_guard lock(mutex_);
  for (auto& [path, material] : materials_) material->dirty = true;
}

void MaterialStore::Generate() {
  std::vector<Material*> dirty;
  for (auto& [path, material] : materials_)
    if (material->dirty) dirty.push_back(material.get());
  if (dirty.empty()) return;
  const materialgen::MessageSink messages = [this](const materialgen::Message& m) {
    sink_({Translate(m.severity), m.code, m.location, m.text});
  };
  wavefront::ParallelFor(dirty.size(), threads_, [&](size_t i) {
    Material& material = *dirty[i];
    const auto start = std::chrono::steady_clock::now();
    const materialgen::MaterialNetwork* network = ChooseNetwork(material.path, material.update, generator_, sink_);
    material.hasNetwork = network != nullptr;
    for (const auto& [context, candidate] : material.update.contexts)
      if (&candidate == network) material.context = context;
    material.compiled = network ? generator_.Generate(*network, messages, options_) : materialgen::CompiledMaterial();
    const materialgen::MaterialNetwork* displacement = ChooseDisplacement(material.update);
    material.displaced =
        displacement ? generator_.GenerateDisplacement(*displacement, messages) : materialgen::CompiledMaterial();
    material.generateMilliseconds = Since(start);
  });
  for (Material* material : dirty) {  // in order of path
    material->dirty = false;
    if (material->hasNetwork) ++generated_;
    // The new images are taken before the old ones are let go: what both use stays loaded.
    std::vector<uint32_t> keys = Acquire(*material, material->compiled);
    std::vector<uint32_t> displacementKeys = Acquire(*material, material->displaced);
    ReleaseTextures(*material);
    material->textureKeys = std::move(keys);
    material->displacementKeys = std::move(displacementKeys);
    material->stale = true;
  }
}

void MaterialStore::RegisterKernel(const Material& material) {
  if (!material.compiled.kernel) return;
  const auto [known, isNew] = kernels_.try_emplace(material.compiled.kernel->key);
  if (!isNew) return;
  const std::shared_ptr<const materialgen::KernelSource> source = material.compiled.kernel;
  known->second.source = source;
  known->second.generateMilliseconds = material.generateMilliseconds;
  for (const std::string* entry : {&source->surface, &source->opacity, &source->emission})
    for (const char* value : {"frameNumber()", "frameSeconds()"})
      followsFrame_ = followsFrame_ || entry->find(value) != std::string::npos;
  ++compiled_;
  wavefront::MaterialKernelData data;
  data.key = source->key;
  data.hasOpacity = !source->opacity.empty();
  data.hasEmission = !source->emission.empty();
  data.primvars = source->primvars;
  data.user = material.path;
  data.compile = [source, cache = cache_, sink = sink_](wavefront::KernelEntry entry) {
    return CompileEntry(*source, entry, *cache, sink);
  };
  renderer_.RegisterKernel(std::move(data));
}

// The parameter block with the ids of its textures.
std::vector<wavefront::Float4> MaterialStore::Block(const materialgen::CompiledMaterial& compiled,
                                                    const std::vector<uint32_t>& keys) {
  std::vector<float> values = compiled.parameters;
  values.resize((values.size() + 3) / 4 * 4, 0.0f);
  for (size_t i = 0; i < compiled.textures.size(); ++i)
    if (compiled.textures[i].offset < values.size())
      values[compiled.textures[i].offset] = std::bit_cast<float>(textures_.Id(keys[i]));
  std::vector<wavefront::Float4> block;
  for (size_t i = 0; i < values.size(); i += 4)
    block.push_back({values[i], values[i + 1], values[i + 2], values[i + 3]});
  return block;
}

void MaterialStore::UpdateDisplacement(Material& material) {
  const materialgen::CompiledMaterial& compiled = material.displaced;
  const auto spirv = compiled.kernel ? displacementKernels_.Compile(*compiled.kernel, *cache_, sink_) : nullptr;
  if (!spirv) {
    material.displacement = nullptr;
    return;
  }
  auto data = std::make_shared<wavefront::DisplacementData>();
  data->kernelKey = compiled.kernel->key;
  data->spirv = spirv;
  data->primvars = compiled.kernel->primvars;
  data->parameters = Block(compiled, material.displacementKeys);
  const bool isSame = material.displacement && material.displacement->kernelKey == data->kernelKey &&
                      Same(material.displacement->parameters, data->parameters);
  if (!isSame) material.displacement = std::move(data);
}

wavefront::Result<std::vector<uint32_t>> MaterialStore::LinkMegakernel(std::span<const std::string> keys) const {
  std::vector<std::shared_ptr<const materialgen::KernelSource>> sources;
  for (const std::string& key : keys) sources.push_back(kernels_.at(key).source);
  std::string error;
  std::vector<uint32_t> spirv = materialgen::CompileGlsl(materialgen::LinkMegakernel(sources), "megakernel", &error);
  if (spirv.empty()) return wavefront::Error{error};
  return spirv;
}

void MaterialStore::Upload(Material& material) {
  const materialgen::CompiledMaterial& compiled = material.compiled;
  material.stale = false;
  if (!compiled.kernel) {
    if (material.id != wavefront::kInvalidId) {
      garbage_.push_back(material.id);
      material.id = wavefront::kInvalidId;
      ++idVersion_;
    }
    material.data = {};
    return;
  }
  wavefront::MaterialData data;
  data.path = material.path;
  data.kernelKey = compiled.kernel->key;
  data.mediumPriority = compiled.mediumPriority;
  data.scatters = compiled.scatters;
  data.lightEnters = compiled.lightEnters;
  data.parameters = Block(compiled, material.textureKeys);
  if (material.id != wavefront::kInvalidId && Same(data, material.data)) return;
  material.data = data;
  ++uploaded_;
  if (material.id != wavefront::kInvalidId) {
    renderer_.SetMaterial(material.id, std::move(data));
  } else {
    material.id = renderer_.CreateMaterial(std::move(data));
    ++idVersion_;
  }
}

void MaterialStore::MakeDefault(Material& material, bool isOpaque) {
  if (material.compiled.kernel) return;
  const auto start = std::chrono::steady_clock::now();
  material.compiled = generator_.GenerateDefault(isOpaque);
  material.generateMilliseconds = Since(start);
  RegisterKernel(material);
  Upload(material);
}

void MaterialStore::NeedDefault() {
  const bool isNew = default_.id == wavefront::kInvalidId;
  MakeDefault(default_, true);
  if (isNew && default_.id != wavefront::kInvalidId) renderer_.SetDefaultMaterial(default_.id);
}

wavefront::MaterialId MaterialStore::TranslucentDefault() {
  MakeDefault(translucentDefault_, false);
  return translucentDefault_.id;
}

void MaterialStore::Commit() {
  Generate();
  for (const auto& [path, material] : materials_) RegisterKernel(*material);
  const uint64_t textureVersion = textures_.version();
  const bool texturesChanged = textureVersion != textureVersion_;
  textureVersion_ = textureVersion;
  for (auto& [path, material] : materials_) {
    if (material->stale || (texturesChanged && !material->displacementKeys.empty())) UpdateDisplacement(*material);
    if (material->stale || (texturesChanged && !material->textureKeys.empty())) Upload(*material);
  }
  for (auto& material : removed_) {
    ReleaseTextures(*material);
    if (material->id != wavefront::kInvalidId) garbage_.push_back(material->id);
    ++idVersion_;
  }
  removed_.clear();
}

void MaterialStore::Collect() {
  for (wavefront::MaterialId id : garbage_) renderer_.DestroyMaterial(id);
  garbage_.clear();
}

wavefront::MaterialId MaterialStore::Id(const std::string& path, const std::string& user) {
  if (path.empty()) return wavefront::kInvalidId;
  const auto found = materials_.find(path);
  if (found != materials_.end()) return found->second->id;
  sink_({wavefront::Severity::Warning, "material-missing", user,
         "The material " + path + " does not exist; the default material is shown."});
  return wavefront::kInvalidId;
}

std::shared_ptr<const wavefront::DisplacementData> MaterialStore::Displacement(const std::string& path) const {
  const auto found = materials_.find(path);
  return found == materials_.end() ? nullptr : found->second->displacement;
}

std::vector<std::string> MaterialStore::MaterialsOf(const std::string& kernelKey) const {
  std::vector<std::string> paths;
  std::lock_guard lock(mutex_);
  for (const auto& [path, material] : materials_)
    if (material->compiled.kernel && material->compiled.kernel->key == kernelKey) paths.push_back(path);
  return paths;
}

std::optional<MaterialExplanation> MaterialStore::Explain(const std::string& path) const {
  std::lock_guard lock(mutex_);
  const auto found = materials_.find(path);
  if (found == materials_.end() || !found->second->compiled.kernel) return std::nullopt;
  const Material& material = *found->second;
  MaterialExplanation facts;
  facts.context = material.context;
  for (const auto& [context, network] : material.update.contexts)
    if (context == material.context) facts.network = network;
  facts.kernelKey = material.compiled.kernel->key;
  facts.closureTree = material.compiled.closureTree;
  for (const materialgen::ParameterSlot& slot : material.compiled.slots) {
    if (slot.isTexture || slot.offset + slot.components > material.compiled.parameters.size()) continue;
    const auto first = material.compiled.parameters.begin() + slot.offset;
    facts.parameters.push_back({slot.node, slot.input, {first, first + slot.components}});
  }
  return facts;
}

std::shared_ptr<const materialgen::KernelSource> MaterialStore::SourceOf(const std::string& path) const {
  std::lock_guard lock(mutex_);
  const auto found = materials_.find(path);
  return found == materials_.end() ? nullptr : found->second->compiled.kernel;
}

std::shared_ptr<const materialgen::KernelSource> MaterialStore::DisplacementSourceOf(const std::string& path) const {
  std::lock_guard lock(mutex_);
  const auto found = materials_.find(path);
  return found == materials_.end() ? nullptr : found->second->displaced.kernel;
}

}  // namespace delegate
