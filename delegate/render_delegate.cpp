// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/render_delegate.h"

#include <algorithm>
#include <set>

#include "delegate/capture/scene_file.h"
#include "delegate/capture/scene_recorder.h"
#include "delegate/gprim_store.h"
#include "delegate/instancer_store.h"
#include "delegate/light_store.h"
#include "delegate/material_store.h"
#include "delegate/photometric_profile.h"
#include "delegate/prims/same.h"
#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"

namespace delegate {
namespace {

constexpr uint32_t kMaxImageSide = 65536;

bool Contains(const std::vector<std::string>& list, const std::string& value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

wavefront::Error UnsupportedType(const std::string& type, const std::string& path) {
  return {"Prims of type \"" + type + "\" are not supported (" + path + ")."};
}

}  // namespace

struct RenderDelegate::Impl {
  Impl(wavefront::Renderer& renderer, std::unique_ptr<materialgen::Generator> materialGenerator,
       wavefront::DiagnosticSink diagnosticSink, unsigned threads)
      : sink(std::move(diagnosticSink)),
        generator(std::move(materialGenerator)),
        textures(renderer, sink),
        instancers(sink, threads),
        materials(renderer, *generator, textures, sink, threads),
        gprims(renderer, instancers, materials, sink, threads),
        lights(renderer, instancers, textures, sink, threads) {}

  struct Camera {
    CameraParams params;
    TimeSamples<wavefront::Matrix4d> transforms{{0, {}}};
  };

  // Light profiles are text: hosts know images only.
  void LoadProfile(const TextureLoadRequest& request) {
    ++imagesDecoded;
    auto profile = ReadPhotometricProfile(request.texture.resolvedPath);
    auto texture = profile.ok() ? EmissionTexture(*profile) : wavefront::Result<wavefront::TextureData>(profile.error());
    const wavefront::Status done = texture.ok() ? textures.Set(request.key, std::move(*texture))
                                                : textures.SetMissing(request.key, texture.error().message);
    WAVEFRONT_CHECK(done.ok(), "%s", done.error().message.c_str());
  }

  wavefront::DiagnosticSink sink;
  std::unique_ptr<materialgen::Generator> generator;
  TextureTable textures;
  InstancerStore instancers;
  MaterialStore materials;
  GprimStore gprims;
  LightStore lights;
  std::atomic<uint64_t> imagesDecoded = 0;

  mutable std::mutex mutex;  // of all below
  std::map<std::string, Camera> cameras;
  SettingValues settings;
  uint32_t settingsVersion = 1;
  std::string camera;
  uint32_t width = 0, height = 0;
  double pixelAspectRatio = 1;
  DataWindow dataWindow;
  ConformPolicy windowPolicy = ConformPolicy::Fit;
  std::set<std::string> renderTags{"geometry", "render"};
  std::vector<wavefront::Aov> aovs{wavefront::Aov::Color};
  std::vector<std::string> primvarAovs;
  std::optional<wavefront::CameraData> sentCamera;
  std::optional<wavefront::RenderSettings> sentSettings;
  DelegateCounters counters;
  std::vector<KernelUse> kernelUses;

  std::vector<KernelUse> ReadKernelUses() const;  // by the committing thread
};

wavefront::Result<std::unique_ptr<RenderDelegate>> RenderDelegate::Create(const RenderDelegateOptions& options) {
  auto log = std::make_shared<DiagnosticLog>();
  std::string generatorTrouble;
  auto generator = materialgen::Generator::Create(options.materialxLibraries, [&](const materialgen::Message& message) {
    if (generatorTrouble.empty()) generatorTrouble = message.text;
  });
  if (!generator)
    return wavefront::Error{"MaterialX's libraries cannot be read from \"" + options.materialxLibraries + "\"" +
                            (generatorTrouble.empty() ? "." : ": " + generatorTrouble)};
  if (options.captureOnly) {
    auto recorder = std::make_unique<SceneRecorder>();
    SceneRecorder* const kept = recorder.get();
    auto made = std::make_unique<RenderDelegate>(std::move(recorder), std::move(generator), log, options.threads);
    made->recorder_ = kept;
    return made;
  }
  wavefront::RendererOptions rendererOptions;
  rendererOptions.device = options.device;
  rendererOptions.validation = options.validation;
  rendererOptions.memoryBudget = options.memoryBudget;
  rendererOptions.threads = options.threads;
  rendererOptions.cacheFolder = materialgen::CacheFolder();
  // The log is kept alive by the sink: the renderer may report to its last breath.
  rendererOptions.diagnostics = [log](const wavefront::Diagnostic& diagnostic) { log->Add(diagnostic); };
  auto renderer = wavefront::Renderer::Create(rendererOptions);
  if (!renderer) return renderer.error();
  return std::make_unique<RenderDelegate>(std::move(renderer).value(), std::move(generator), log, options.threads);
}

RenderDelegate::RenderDelegate(std::unique_ptr<wavefront::Renderer> renderer,
                               std::unique_ptr<materialgen::Generator> generator, std::shared_ptr<DiagnosticLog> log,
                               uint32_t threads)
    : log_(std::move(log)),
      renderer_(std::move(renderer)),
      impl_(std::make_unique<Impl>(*renderer_, std::move(generator), log_->Sink(), threads)) {}

RenderDelegate::~RenderDelegate() { renderer_->Stop(); }

const std::vector<std::string>& RenderDelegate::SupportedRprimTypes() {
  static const std::vector<std::string> types{"mesh", "sphere", "cube", "cone", "cylinder", "capsule", "plane"};
  return types;
}

const std::vector<std::string>& RenderDelegate::SupportedSprimTypes() {
  static const std::vector<std::string> types{"camera",      "material",      "rectLight",    "diskLight",
                                              "sphereLight", "cylinderLight", "distantLight", "domeLight"};
  return types;
}

wavefront::Status RenderDelegate::CreateRprim(const std::string& type, const std::string& path) {
  if (!Contains(SupportedRprimTypes(), type)) return UnsupportedType(type, path);
  impl_->gprims.Create(path, type == "mesh");
  return {};
}

wavefront::Status RenderDelegate::CreateSprim(const std::string& type, const std::string& path) {
  if (!Contains(SupportedSprimTypes(), type)) return UnsupportedType(type, path);
  if (type == "camera") {
    std::lock_guard lock(impl_->mutex);
    impl_->cameras.try_emplace(path);
  } else if (type == "material") {
    impl_->materials.Create(path);
  } else {
    std::string schema = type;
    schema[0] = static_cast<char>(schema[0] - 'a' + 'A');  // UsdLux's name
    impl_->lights.Create(path, schema);
  }
  return {};
}

void RenderDelegate::CreateInstancer(const std::string& path) { impl_->instancers.Create(path); }

bool RenderDelegate::Sync(const std::string& path, MeshUpdate update) {
  return impl_->gprims.Sync(path, std::move(update));
}
bool RenderDelegate::Sync(const std::string& path, ImplicitUpdate update) {
  return impl_->gprims.Sync(path, std::move(update));
}
bool RenderDelegate::Sync(const std::string& path, InstancerUpdate update) {
  return impl_->instancers.Sync(path, std::move(update));
}
bool RenderDelegate::Sync(const std::string& path, LightUpdate update) {
  return impl_->lights.Sync(path, std::move(update));
}
bool RenderDelegate::Sync(const std::string& path, MaterialUpdate update) {
  return impl_->materials.Sync(path, std::move(update));
}

bool RenderDelegate::Sync(const std::string& path, CameraUpdate update) {
  std::lock_guard lock(impl_->mutex);
  const auto [found, isNew] = impl_->cameras.try_emplace(path);
  if (update.transforms && update.transforms->empty()) update.transforms.reset();
  bool changed = Take(found->second.params, update.params);
  changed |= Take(found->second.transforms, update.transforms);
  return changed || isNew;
}

void RenderDelegate::DestroyRprim(const std::string& path) { impl_->gprims.Destroy(path); }

void RenderDelegate::DestroySprim(const std::string& path) {
  impl_->lights.Destroy(path);
  impl_->materials.Destroy(path);
  std::lock_guard lock(impl_->mutex);
  impl_->cameras.erase(path);
}

void RenderDelegate::DestroyInstancer(const std::string& path) { impl_->instancers.Destroy(path); }

void RenderDelegate::SetUnconvertedColorSpaces(const std::vector<std::string>& names) {
  impl_->textures.SetUnconvertedSpaces(names);
}

std::vector<TextureLoadRequest> RenderDelegate::PendingTextures() {
  impl_->materials.Generate();
  impl_->lights.AcquireTextures();
  wavefront::RenderSettings settings;
  {
    std::lock_guard lock(impl_->mutex);
    impl_->settings.FillInto(settings);
  }
  impl_->textures.ReloadCoarse(settings.textureMemory);
  std::vector<TextureLoadRequest> forHost;
  for (TextureLoadRequest& request : impl_->textures.Pending()) {
    if (IsPhotometricProfile(request.texture.resolvedPath)) impl_->LoadProfile(request);
    else forHost.push_back(std::move(request));
  }
  return forHost;
}

void RenderDelegate::CountDecodedImage() { ++impl_->imagesDecoded; }

wavefront::Status RenderDelegate::SetTexture(uint32_t key, wavefront::TextureData data) {
  return impl_->textures.Set(key, std::move(data));
}

wavefront::Status RenderDelegate::SetTextureTiles(
    uint32_t key, std::vector<std::pair<uint32_t, wavefront::TextureData>> tiles) {
  return impl_->textures.SetTiles(key, std::move(tiles));
}

wavefront::Status RenderDelegate::SetTextureMissing(uint32_t key, const std::string& reason) {
  return impl_->textures.SetMissing(key, reason);
}

wavefront::Status RenderDelegate::SetRenderPass(const RenderPassUpdate& update) {
  for (const auto& side : {update.width, update.height})
    if (side && (*side == 0 || *side > kMaxImageSide))
      return wavefront::Error{"An image must be 1 to " + std::to_string(kMaxImageSide) + " pixels wide and high, not " +
                              std::to_string(update.width.value_or(0)) + " x " +
                              std::to_string(update.height.value_or(0)) + "."};
  if (update.pixelAspectRatio && !(*update.pixelAspectRatio > 1e-6 && *update.pixelAspectRatio < 1e6))
    return wavefront::Error{"The pixel aspect ratio " + std::to_string(*update.pixelAspectRatio) + " makes no sense."};
  if (const auto& part = update.dataWindow; part && !(part->right > part->left && part->top > part->bottom))
    return wavefront::Error{"The data window has no area."};
  std::lock_guard lock(impl_->mutex);
  if (update.camera) impl_->camera = *update.camera;
  if (update.width) impl_->width = *update.width;
  if (update.height) impl_->height = *update.height;
  if (update.pixelAspectRatio) impl_->pixelAspectRatio = *update.pixelAspectRatio;
  if (update.dataWindow) impl_->dataWindow = *update.dataWindow;
  if (update.windowPolicy) impl_->windowPolicy = *update.windowPolicy;
  if (update.renderTags) {
    impl_->renderTags.clear();
    for (const std::string& tag : *update.renderTags) impl_->renderTags.insert(tag.empty() ? "geometry" : tag);
  }
  if (update.aovs) {
    std::set<wavefront::Aov> wanted(update.aovs->begin(), update.aovs->end());
    wanted.insert(wavefront::Aov::Color);
    impl_->aovs.assign(wanted.begin(), wanted.end());
  }
  if (update.primvarAovs) impl_->primvarAovs = *update.primvarAovs;
  return {};
}

wavefront::Result<bool> RenderDelegate::SetRenderSetting(const std::string& token, const SettingValue& value) {
  std::lock_guard lock(impl_->mutex);
  auto changed = impl_->settings.Set(token, value);
  if (changed && changed.value()) ++impl_->settingsVersion;
  return changed;
}

wavefront::Result<SettingValue> RenderDelegate::GetRenderSetting(const std::string& token) const {
  std::lock_guard lock(impl_->mutex);
  return impl_->settings.Get(token);
}

uint32_t RenderDelegate::GetRenderSettingsVersion() const {
  std::lock_guard lock(impl_->mutex);
  return impl_->settingsVersion;
}

wavefront::Status RenderDelegate::CommitResources() {
  Impl& impl = *impl_;
  GprimStore::What what;
  wavefront::RenderSettings settings;
  bool sceneLights;
  {
    std::lock_guard lock(impl.mutex);
    if (impl.width == 0 || impl.height == 0) return wavefront::Error{"No image size is set."};
    const auto camera = impl.cameras.find(impl.camera);
    if (camera == impl.cameras.end())
      return wavefront::Error{impl.camera.empty() ? "No camera is set."
                                                  : "The camera \"" + impl.camera + "\" does not exist."};
    const DataWindow& part = impl.dataWindow;
    const double aspect = (impl.width / (part.right - part.left)) / (impl.height / (part.top - part.bottom)) *
                          impl.pixelAspectRatio;
    wavefront::CameraData data = ConvertCamera(camera->first, camera->second.params, camera->second.transforms, aspect,
                                               impl.windowPolicy, impl.sink);
    CropWindow(part, data);
    if (!impl.sentCamera || !Same(*impl.sentCamera, data)) {
      renderer_->SetCamera(data);
      impl.sentCamera = data;
      ++impl.counters.camerasUploaded;
    }
    impl.settings.FillInto(settings);
    settings.width = impl.width;
    settings.height = impl.height;
    settings.aovs = impl.aovs;
    settings.primvarAovs = impl.primvarAovs;
    what.renderTags = impl.renderTags;
    what.sceneMaterials = impl.settings.Bool("enableSceneMaterials");
    what.displacementTriangles = static_cast<uint64_t>(impl.settings.Int("displacementTriangles"));
    sceneLights = impl.settings.Bool("enableSceneLights");
    impl.materials.SetOptions({.diffuseSubsurface = !impl.settings.Bool("subsurfaceRandomWalk")});
  }
  impl.materials.Commit();
  if (!impl.materials.followsFrame()) {  // another frame restarts nothing where no material asks for it
    settings.frame = wavefront::RenderSettings().frame;
    settings.time = wavefront::RenderSettings().time;
  }
  if (!impl.sentSettings || !Same(*impl.sentSettings, settings)) {
    renderer_->SetRenderSettings(settings);
    impl.sentSettings = settings;
  }
  impl.gprims.Commit(what);
  impl.lights.Commit(sceneLights);
  impl.instancers.Forget();
  impl.materials.Collect();  // nothing refers to them any more
  impl.textures.Collect();
  const wavefront::Status status = renderer_->Commit();
  std::vector<KernelUse> kernelUses = impl.ReadKernelUses();
  std::lock_guard lock(impl.mutex);
  impl.kernelUses = std::move(kernelUses);
  DelegateCounters& c = impl.counters;
  c.meshesBuilt = impl.gprims.built();
  c.meshesUploaded = impl.gprims.meshesUploaded();
  c.instancesUploaded = impl.gprims.instancesUploaded();
  c.lightsUploaded = impl.lights.uploaded();
  c.materialsGenerated = impl.materials.generated();
  c.materialsUploaded = impl.materials.uploaded();
  c.kernelsCompiled = impl.materials.compiled();
  c.imagesDecoded = impl.imagesDecoded;
  c.texturesUploaded = impl.textures.uploads();
  ++c.commits;
  return status;
}

wavefront::Result<size_t> RenderDelegate::WriteCapture(const std::string& path, const std::string& name,
                                                       const std::string& version, uint32_t maxTextureSide) const {
  if (!recorder_) return wavefront::Error{"This delegate renders; a scene is captured by one that was made for it."};
  CapturedScene scene = recorder_->Scene();
  scene.info = {name, version, IncludedGlslHash()};
  const size_t shrunk = maxTextureSide == 0 ? 0 : ShrinkTextures(scene, maxTextureSide);
  std::vector<std::string> troubles(scene.kernels.size());
  wavefront::ParallelFor(scene.kernels.size(), 0, [&](size_t i) {
    CapturedKernel& kernel = scene.kernels[i];
    const materialgen::KernelSource& source = *impl_->materials.kernels().at(kernel.key).source;
    kernel.glsl = {source.surface, source.opacity, source.emission};
    for (size_t entry = 0; entry < kernel.glsl.size(); ++entry) {
      if (kernel.glsl[entry].empty()) continue;
      wavefront::KernelCode code = recorder_->Compile(kernel.key, static_cast<wavefront::KernelEntry>(entry));
      kernel.spirv[entry] = std::move(code.spirv);
      if (kernel.spirv[entry].empty()) troubles[i] = code.error;
    }
  });
  for (const std::string& trouble : troubles)
    if (!trouble.empty()) return wavefront::Error{"A kernel does not compile, so the scene is not captured: " + trouble};
  if (const wavefront::Status status = WriteSceneFile(scene, path); !status) return status.error();
  return shrunk;
}

std::optional<wavefront::Aov> RenderDelegate::FindAov(const std::string& token) const {
  std::lock_guard lock(impl_->mutex);
  return wavefront::FindAov(token, impl_->primvarAovs);
}

DelegateCounters RenderDelegate::counters() const {
  std::lock_guard lock(impl_->mutex);
  return impl_->counters;
}

CameraMatrices RenderDelegate::cameraMatrices() const {
  std::lock_guard lock(impl_->mutex);
  return impl_->sentCamera ? MatricesOf(*impl_->sentCamera) : CameraMatrices();
}

std::vector<RenderDelegate::KernelUse> RenderDelegate::Impl::ReadKernelUses() const {
  std::vector<KernelUse> uses;
  for (const auto& [key, kernel] : materials.kernels()) {
    KernelUse use;
    use.key = key;
    use.lobes = kernel.source->lobes;
    use.primvars = kernel.source->primvars;
    use.materials = materials.MaterialsOf(key);
    use.generateMilliseconds = kernel.generateMilliseconds;
    uses.push_back(std::move(use));
  }
  return uses;
}

std::vector<RenderDelegate::KernelUse> RenderDelegate::kernelUses() const {
  std::vector<KernelUse> uses;
  {
    std::lock_guard lock(impl_->mutex);
    uses = impl_->kernelUses;
  }
  const wavefront::RenderStats stats = renderer_->stats();
  std::map<std::string, KernelUse*> byKey;
  for (KernelUse& use : uses) byKey[use.key] = &use;
  double total = 0;
  for (const wavefront::KernelStats& kernel : stats.kernels) {
    total += kernel.milliseconds;
    // "material:<key>:<entry>"
    const size_t first = kernel.name.find(':'), last = kernel.name.rfind(':');
    if (first == last) continue;
    const auto found = byKey.find(kernel.name.substr(first + 1, last - first - 1));
    if (found == byKey.end()) continue;
    KernelUse& use = *found->second;
    if (kernel.name.ends_with(":surface")) use.state = kernel.state;
    use.codeMilliseconds += kernel.codeMilliseconds;
    use.createMilliseconds += kernel.createMilliseconds;
    use.firstDispatchMilliseconds += kernel.firstDispatchMilliseconds;
    use.codeFromCache = use.codeFromCache || kernel.codeFromCache;
    use.spirvBytes += kernel.spirvBytes;
    use.spirvInstructions += kernel.spirvInstructions;
    const std::string entry = kernel.name.substr(last + 1);
    for (const std::string& statistic : kernel.driverStatistics) use.driverStatistics.push_back(entry + ": " + statistic);
    use.milliseconds += kernel.milliseconds;
    use.paths += kernel.items;
  }
  for (KernelUse& use : uses) {
    if (use.paths != 0) use.nanosecondsPerPath = use.milliseconds * 1e6 / static_cast<double>(use.paths);
    if (total > 0) use.share = use.milliseconds / total;
  }
  return uses;
}

std::optional<MaterialExplanation> RenderDelegate::ExplainMaterial(const std::string& path) const {
  return impl_->materials.Explain(path);
}

std::vector<std::pair<std::string, std::string>> RenderDelegate::MaterialSource(const std::string& path) const {
  std::vector<std::pair<std::string, std::string>> sources;
  if (const auto source = impl_->materials.SourceOf(path)) {
    sources.emplace_back("surface", source->surface);
    if (!source->opacity.empty()) sources.emplace_back("opacity", source->opacity);
    if (!source->emission.empty()) sources.emplace_back("emission", source->emission);
  }
  if (const auto source = impl_->materials.DisplacementSourceOf(path))
    sources.emplace_back("displacement", source->displacement);
  return sources;
}

}  // namespace delegate
