// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A scene and a seeded series of random edits to it, told to whoever drives a render delegate: directly, or through Hd.
// The script says what it changed, part by part, as a host's change tracker would; the values stand in the scene.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "delegate/render_delegate.h"

namespace delegate_test {

enum class PrimKind { Mesh, Implicit, Instancer, Light, Camera, Material };

// What of a prim is dirty. A kind that has no such part ignores it.
enum Part : uint32_t {
  kPartTransform = 1,
  kPartVisibility = 2,
  kPartMaterial = 4,    // binding, those of subsets included
  kPartPoints = 8,
  kPartTopology = 16,   // subdivision tags and subsets included
  kPartPrimvars = 32,
  kPartRenderTag = 64,
  kPartSides = 128,
  kPartRefine = 256,
  kPartShape = 512,     // of implicit shapes
  kPartInstances = 1024,  // an instancer's arrays
  kPartParams = 2048,   // of lights and cameras
  kPartNetwork = 4096,  // of materials
  kPartAll = 0x7fffffff,
};

// One prim in full: every member of the update that its kind has is there.
struct ScenePrim {
  PrimKind kind = PrimKind::Mesh;
  std::string type;  // Hydra's name: mesh, sphere, rectLight ...; "instancer"
  delegate::MeshUpdate mesh;
  delegate::ImplicitUpdate implicit;
  delegate::InstancerUpdate instancer;
  delegate::LightUpdate light;
  delegate::CameraUpdate camera;
  delegate::MaterialUpdate material;

  // The instancer that draws it and its prototype there; an empty path: none.
  std::pair<std::string, int32_t> drawnBy() const {
    if (kind == PrimKind::Instancer) return {instancer.parent.value_or(""), instancer.parentPrototype.value_or(0)};
    if (kind == PrimKind::Light) return {light.instancer.value_or(""), light.prototype.value_or(0)};
    if (kind == PrimKind::Mesh) return {mesh.instancer.value_or(""), mesh.prototype.value_or(0)};
    if (kind == PrimKind::Implicit) return {implicit.instancer.value_or(""), implicit.prototype.value_or(0)};
    return {};
  }
  bool isGprim() const { return kind == PrimKind::Mesh || kind == PrimKind::Implicit; }
  delegate::GprimUpdate& gprim() { return kind == PrimKind::Mesh ? static_cast<delegate::GprimUpdate&>(mesh) : implicit; }
};

struct Scene {
  std::map<std::string, ScenePrim> prims;
  std::string camera;
  uint32_t width = 24, height = 16;
  std::vector<std::string> aovs;  // tokens
  std::map<std::string, delegate::SettingValue> settings;
};

// One sample. (A helper, not braces: GCC 12 breaks on nested ones here.)
template <typename T>
delegate::TimeSamples<T> Still(T value) {
  delegate::TimeSamples<T> samples(1);
  samples[0].value = std::move(value);
  return samples;
}

// Every scene has these materials, each with one of so many networks (EditScript::Network).
inline const std::vector<std::string> kSceneMaterials{"/looks/plain", "/looks/wood", "/looks/lamp", "/looks/veil"};
constexpr uint32_t kSceneNetworks = 5;

// The image behind a resolved path: a few texels that depend on the path only.
wavefront::TextureData SceneTexture(const std::string& resolvedPath);

// Who is told. Edits arrive one at a time; none makes anything real: the driver commits when it likes.
class EditSink {
 public:
  virtual ~EditSink() = default;
  virtual void Insert(const std::string& path, const ScenePrim& prim) = 0;
  virtual void Change(const std::string& path, const ScenePrim& prim, uint32_t parts) = 0;
  virtual void Remove(const std::string& path, const ScenePrim& prim) = 0;
  virtual void ChangeRender(const Scene& scene) = 0;  // camera, size, AOVs or settings
};

// What the driver is to do with the render after an edit, beside committing and starting it.
enum class RenderControl { Go, PauseAndResume, StopAndStart, EditWhilePaused, EditWhileRunning };

class EditScript {
 public:
  explicit EditScript(uint32_t seed);

  const Scene& scene() const { return scene_; }
  // Inserts all prims of the scene as it stands, in an order of the script's own.
  void Populate(EditSink& sink);
  // One random edit. What was done, for messages.
  std::string Step(EditSink& sink);
  RenderControl control() const { return control_; }  // of the last step
  // Every edit that there is, by name, and how often it was made.
  const std::map<std::string, int>& counts() const { return counts_; }

 private:
  struct Edit {
    const char* name;
    int weight;
    std::string (EditScript::*run)(EditSink&);  // empty: nothing here to edit
  };
  static const std::vector<Edit>& Edits();

  uint32_t Pick(uint32_t n) { return static_cast<uint32_t>(random_() % n); }  // 0 .. n-1, alike on all platforms
  double Number(double low, double high);                                      // one of 65 steps
  bool Chance(uint32_t outOf) { return Pick(outOf) == 0; }
  template <typename T>
  const T& Any(const std::vector<T>& list) { return list[Pick(static_cast<uint32_t>(list.size()))]; }
  std::string AnyPath(const std::function<bool(const ScenePrim&)>& fits);  // empty: none
  wavefront::Matrix4d RandomTransform();
  // Tells the sink, with all parts now and then: equal values must do no harm.
  std::string Tell(EditSink& sink, const std::string& path, uint32_t parts, const std::string& what);

  void BuildMeshes();
  void BuildShapes();
  void BuildInstancers();
  void BuildLights();
  void BuildMaterials();
  delegate::MaterialUpdate Network(const std::string& path, uint32_t variant);

  std::string EditPoints(EditSink&);
  std::string EditTopology(EditSink&);
  std::string EditPrimvars(EditSink&);
  std::string EditTransform(EditSink&);
  std::string EditVisibility(EditSink&);
  std::string EditRenderTag(EditSink&);
  std::string EditBinding(EditSink&);
  std::string EditMaterialValue(EditSink&);
  std::string EditMaterialGraph(EditSink&);
  std::string EditShape(EditSink&);
  std::string EditLight(EditSink&);
  std::string EditCamera(EditSink&);
  std::string EditInstances(EditSink&);
  std::string RemovePrim(EditSink&);
  std::string RestorePrim(EditSink&);
  std::string ChangeType(EditSink&);
  std::string SwitchCamera(EditSink&);
  std::string SwitchAovs(EditSink&);
  std::string Resize(EditSink&);
  std::string EditSetting(EditSink&);
  bool IsAnythingOff() const;
  std::string TellNothingNew(EditSink&);

  std::mt19937 random_;
  Scene scene_;
  std::map<std::string, ScenePrim> removed_;
  std::map<std::string, int> counts_;
  RenderControl control_ = RenderControl::Go;
};

}  // namespace delegate_test
