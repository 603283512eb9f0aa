// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scenes for the tests of the scheduler, through the renderer's facade, with materials written by hand.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "materialgen/materialgen.h"
#include "wavefront/renderer.h"
#include "wavefront/shared/film_layout.h"

namespace wavefront {

// texels 0 and 1: the medium inside, as every body's; texel 2: albedo, opacity; texel 3: emission. WAX: what is diffuse
// lets light in for a random walk instead; its radius is where others have their emission.
inline constexpr const char* kClosure = R"(
struct Closure { vec3 opacity; vec3 emission; Medium interior; vec3 albedo; vec3 n; vec3 radius; };
const bool kHasSubsurface = WAX;
const bool kHasTransmission = GLASS;
const bool kHasOpacity = OPACITY;
const bool kHasEmission = EMISSION;
void closureMake(ShadingPoint sp, out Closure c) {
  vec4 a = materialParameter(sp, 2u);
  c.albedo = a.rgb;
  c.opacity = vec3(a.a);
  c.emission = EMISSION ? materialParameter(sp, 3u).rgb : vec3(0.0);
  c.radius = materialParameter(sp, 3u).rgb;
  c.interior = mediumAt(sp.parameterBase);
  c.n = dot(sp.normalWorld, sp.wo) < 0.0 ? -sp.normalWorld : sp.normalWorld;
}
// Lambert; or, as glass, a boundary that nothing happens at: straight on, with the pdf of a narrow cone.
vec4 closureEval(Closure c, vec3 wo, vec3 wi, inout vec3 below) {
  if (GLASS) return dot(wi, wo) < -0.99999 ? vec4(1e6) : vec4(0.0);
  float k = max(WAX ? -dot(c.n, wi) : dot(c.n, wi), 0.0) * 0.31830988618;
  if (WAX) below = c.albedo * k;
  return vec4(c.albedo * k, k);
}
vec3 closureSample(Closure c, vec3 wo, float uLobe, vec2 u) {
  if (GLASS) return -wo;
  float r = sqrt(u.x), phi = 6.28318530718 * u.y;
  vec3 x = normalize(cross(abs(c.n.x) > 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), c.n));
  return normalize(r * cos(phi) * x + r * sin(phi) * cross(c.n, x) + sqrt(max(0.0, 1.0 - u.x)) * (WAX ? -c.n : c.n));
}
SubsurfaceLobe closureWalk(Closure c, float u, inout vec3 below) { return subsurfaceMake(c.n, c.albedo, c.radius, 0.0); }
vec3 closureAlbedo(Closure c, vec3 wo) { return c.albedo; }
)";

inline std::string MaterialSource(const std::string& head, const std::string& body, const std::string& tail) {
  return "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"material/" + head + "\"\n" + body +
         "\n#include \"material/" + tail + "\"\n";
}

// As materialgen writes them; the megakernel is linked of these.
inline std::shared_ptr<const materialgen::KernelSource> MakeSource(const std::string& key, bool opacity, bool emission, bool glass, bool wax = false) {
  std::string closure = kClosure;
  for (auto [name, value] : {std::pair{"OPACITY", opacity}, {"EMISSION", emission}, {"GLASS", glass}, {"WAX", wax}}) {
    for (std::size_t at; (at = closure.find(name)) != std::string::npos;) closure.replace(at, std::strlen(name), value ? "true" : "false");
  }
  auto source = std::make_shared<materialgen::KernelSource>();
  source->key = key;
  source->surface = MaterialSource("surface_head.glsl", closure, "surface_tail.glsl");
  if (opacity) {
    source->opacity = MaterialSource("pattern_head.glsl", "vec3 materialOpacity(ShadingPoint sp) { return vec3(materialParameter(sp, 2u).a); }",
                                     "opacity_tail.glsl");
  }
  if (emission) {
    source->emission = MaterialSource("pattern_head.glsl", "vec3 materialEmission(ShadingPoint sp) { return materialParameter(sp, 3u).rgb; }",
                                      "emission_tail.glsl");
  }
  return source;
}

inline std::vector<uint32_t> CompileSource(const std::string& source, const std::string& name) {
  if (source.empty()) return {};
  std::string error;
  auto spirv = materialgen::CompileGlsl(source, name, &error);
  EXPECT_FALSE(spirv.empty()) << error;
  return spirv;
}

inline MaterialKernelData MakeKernel(const materialgen::KernelSource& source) {
  MaterialKernelData kernel;
  kernel.key = source.key;
  kernel.surfaceSpirv = CompileSource(source.surface, source.key);
  kernel.opacitySpirv = CompileSource(source.opacity, source.key + " opacity");
  kernel.emissionSpirv = CompileSource(source.emission, source.key + " emission");
  return kernel;
}

inline MaterialKernelData MakeKernel(const std::string& key, bool opacity, bool emission, bool glass, bool wax = false) {
  return MakeKernel(*MakeSource(key, opacity, emission, glass, wax));
}

inline MaterialData MakeMaterial(const std::string& kernel, Float3 albedo, float opacity = 1, Float3 emission = {}, Float3 absorption = {},
                                 Float3 scattering = {}, float anisotropy = 0) {
  MaterialData data{"/material/" + kernel, kernel,
          {{absorption.x, absorption.y, absorption.z, anisotropy}, {scattering.x, scattering.y, scattering.z, 1},
           {albedo.x, albedo.y, albedo.z, opacity}, {emission.x, emission.y, emission.z, 0}}};
  data.scatters = kernel == "wax" || scattering.x + scattering.y + scattering.z > 0;
  data.lightEnters = kernel == "wax" || kernel == "glass";
  return data;
}

inline Matrix4d Scaled(double sx, double sy, double sz, double tx = 0, double ty = 0, double tz = 0) {
  Matrix4d m;
  m.m[0][0] = sx; m.m[1][1] = sy; m.m[2][2] = sz;
  m.m[3][0] = tx; m.m[3][1] = ty; m.m[3][2] = tz;
  return m;
}
inline Matrix4d Moved(double tx, double ty, double tz) { return Scaled(1, 1, 1, tx, ty, tz); }

// A square of side 2 in the xy plane, facing +Z.
inline MeshData Quad() {
  MeshData mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}
// A box [-1, 1]^3, faces outwards.
inline MeshData Box() {
  MeshData mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
  for (auto q : {std::array<uint32_t, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

// A renderer with the test's materials, and everything that one test put into it.
class World {
 public:
  explicit World(uint32_t hostThreads = 0) {
    RendererOptions options;
    options.threads = hostThreads;
    options.diagnostics = [this](const Diagnostic& d) {
      std::lock_guard lock(mutex_);
      diagnostics_.push_back(d);
    };
    auto made = Renderer::Create(options);
    if (!made) {
      ADD_FAILURE() << made.error().message;
      std::abort();
    }
    renderer = std::move(made).value();
    settings.width = 40;
    settings.height = 30;
    settings.samples = 16;
    // From z = 4 along -Z; the square of side 2 at z = 0 fills half of the image's height.
    camera.transforms = {{0, Moved(0, 0, 4)}};
    camera.left = -2.0f / 3; camera.right = 2.0f / 3; camera.bottom = -0.5f; camera.top = 0.5f;
  }
  MaterialId Material(MaterialData data) {
    if (!renderer->HasKernel(data.kernelKey)) {
      const std::string& k = data.kernelKey;
      sources_[k] = MakeSource(k, k == "cutout", k == "emissive", k == "glass", k == "wax");
      renderer->RegisterKernel(MakeKernel(*sources_[k]));
    }
    return renderer->CreateMaterial(std::move(data));
  }
  // Lets Commit make megakernels of the materials' kernels.
  void LinkMegakernels() {
    renderer->SetMegakernelLinker([this](std::span<const std::string> keys) -> Result<std::vector<uint32_t>> {
      ++linked;
      std::vector<std::shared_ptr<const materialgen::KernelSource>> sources;
      for (const std::string& key : keys) sources.push_back(sources_.at(key));
      return CompileSource(materialgen::LinkMegakernel(sources), "megakernel");
    });
  }
  int linked = 0;
  InstanceGroupId Instance(const std::string& path, MeshId mesh, MaterialId material, std::vector<Matrix4d> transforms) {
    InstanceData data;
    data.path = path;
    data.mesh = mesh;
    data.materials = {material};
    for (const Matrix4d& m : transforms) data.transforms.push_back({{0, m}});
    return renderer->CreateInstances(std::move(data));
  }
  LightId Dome(float radiance) {
    LightData light;
    light.path = "/dome";
    light.type = LightType::Dome;
    light.radiance = {radiance, radiance, radiance};
    return renderer->CreateLight(light);
  }
  Status Commit() {
    renderer->SetCamera(camera);
    renderer->SetRenderSettings(settings);
    return renderer->Commit();
  }
  // Commits, renders to the end, and hands out the sums.
  RawFilm Render() {
    Status s = Commit();
    EXPECT_TRUE(s.ok()) << s.error().message;
    if (!s) return {};
    return Finish();
  }
  // The same, paused, looked at, resumed, stopped and started again on the way.
  RawFilm RenderInterrupted() {
    Status s = Commit();
    EXPECT_TRUE(s.ok()) << s.error().message;
    if (!s) return {};
    EXPECT_TRUE(renderer->Start().ok());
    int interruptions = 0;
    for (; interruptions < 12 && !renderer->IsConverged(); ++interruptions) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (interruptions % 2 == 0) {
        renderer->Pause();
        EXPECT_TRUE(renderer->Map(Aov::Color).ok());
        renderer->Resume();
      } else {
        renderer->Stop();
        EXPECT_FALSE(renderer->progress().running);
        EXPECT_TRUE(renderer->Start().ok());
      }
    }
    EXPECT_GT(interruptions, 0);
    return Finish();
  }
  RawFilm Finish() {
    Status s = renderer->Start();
    EXPECT_TRUE(s.ok()) << s.error().message;
    EXPECT_TRUE(renderer->WaitUntilDone(120));
    EXPECT_TRUE(renderer->status().ok()) << renderer->status().error().message;
    EXPECT_TRUE(renderer->IsConverged());
    auto film = renderer->ReadFilm();
    EXPECT_TRUE(film.ok());
    return film.ok() ? std::move(film).value() : RawFilm{};
  }
  bool Said(const std::string& code, const std::string& location = "") const {
    std::lock_guard lock(mutex_);
    return std::any_of(diagnostics_.begin(), diagnostics_.end(),
                       [&](const Diagnostic& d) { return d.code == code && (location.empty() || d.location == location); });
  }
  std::size_t diagnosticCount() const {
    std::lock_guard lock(mutex_);
    return diagnostics_.size();
  }

  // Lambert walls, an emissive square, cutouts, bodies that scatter and analytic lights: every kind of bucket and queue has work.
  void AddMixedScene() {
    const MeshId quad = renderer->CreateMesh(Quad()), box = renderer->CreateMesh(Box());
    const MaterialId grey = Material(MakeMaterial("lambert", {0.7f, 0.6f, 0.5f}));
    const MaterialId lamp = Material(MakeMaterial("emissive", {0.2f, 0.2f, 0.2f}, 1, {4, 3, 2}));
    const MaterialId gauze = Material(MakeMaterial("cutout", {0.4f, 0.8f, 0.3f}, 0.4f));
    const MaterialId glass = Material(MakeMaterial("glass", {}, 1, {}, {0.3f, 0.6f, 0.1f}, {1, 2, 3}, 0.3f));
    const MaterialId wax = Material(MakeMaterial("wax", {0.8f, 0.5f, 0.3f}, 1, {0.1f, 0.2f, 0.05f}));
    Instance("/wall", quad, grey, {Scaled(3, 3, 1, 0, 0, -1.5), Scaled(0.4, 0.4, 0.4, 0.8, 0.5, 0.3)});
    Instance("/lamp", quad, lamp, {Scaled(0.3, 0.3, 1, -0.9, 0.7, -0.7)});
    Instance("/gauze", quad, gauze, {Scaled(0.8, 0.8, 1, 0.2, -0.3, 0.4), Scaled(0.8, 0.8, 1, 0.3, -0.2, 0.4)});
    Instance("/glass", box, glass, {Scaled(0.3, 0.3, 0.3, -0.7, -0.6, 0)});
    Instance("/wax", box, wax, {Scaled(0.2, 0.3, 0.2, 0.9, -0.4, 0)});
    LightData light;
    light.path = "/rect";
    light.type = LightType::Rect;
    light.transforms = {{0, Moved(0.5, 1.2, 2.5)}};
    light.radiance = {6, 6, 7};
    renderer->CreateLight(light);
    light.path = "/sphere";
    light.type = LightType::Sphere;
    light.radius = 0.2f;
    light.transforms = {{0, Moved(-1.2, 0, 0.5)}};
    renderer->CreateLight(light);
    Dome(0.2f);
    settings.aovs = {Aov::Albedo, Aov::Normal, Aov::Depth, Aov::CameraDepth, Aov::PrimId, Aov::ElementId};
  }

  std::unique_ptr<Renderer> renderer;
  RenderSettings settings;
  CameraData camera;

 private:
  std::map<std::string, std::shared_ptr<const materialgen::KernelSource>> sources_;
  mutable std::mutex mutex_;
  std::vector<Diagnostic> diagnostics_;
};

inline uint64_t HashFilm(const RawFilm& film) {  // FNV-1a over the words
  uint64_t h = 1469598103934665603ull;
  auto add = [&](uint64_t v) { h = (h ^ v) * 1099511628211ull; };
  for (int64_t v : film.sums) add(static_cast<uint64_t>(v));
  for (uint32_t v : film.first) add(v);
  return h;
}

// Channel c of the colour of pixel (x, y), y down from the top row.
inline float ColorAt(const RawFilm& film, uint32_t x, uint32_t y, uint32_t c) {
  return std::bit_cast<float>(ResolveFilm(film, Aov::Color).bits[(static_cast<std::size_t>(y) * film.width + x) * 4 + c]);
}
inline double MeanColor(const RawFilm& film, uint32_t c) {
  const AovImage image = ResolveFilm(film, Aov::Color);
  double sum = 0;
  for (std::size_t p = 0; p < image.bits.size() / 4; ++p) sum += std::bit_cast<float>(image.bits[4 * p + c]);
  return sum / static_cast<double>(image.bits.size() / 4);
}

}  // namespace wavefront
