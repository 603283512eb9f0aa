// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/delegate/edit_script.h"

#include <algorithm>
#include <cmath>

namespace delegate_test {

using delegate::PrimvarInput;
using wavefront::Float3;
using wavefront::Matrix4d;

double EditScript::Number(double low, double high) { return low + (high - low) * Pick(65) / 64.0; }

std::string EditScript::AnyPath(const std::function<bool(const ScenePrim&)>& fits) {
  std::vector<std::string> paths;
  for (const auto& [path, prim] : scene_.prims)
    if (fits(prim)) paths.push_back(path);
  return paths.empty() ? "" : Any(paths);
}

const std::vector<EditScript::Edit>& EditScript::Edits() {
  using S = EditScript;
  static const std::vector<Edit> edits{
      {"points", 4, &S::EditPoints},         {"topology", 2, &S::EditTopology},   {"primvars", 4, &S::EditPrimvars},
      {"transform", 4, &S::EditTransform},   {"visibility", 3, &S::EditVisibility}, {"render tag", 1, &S::EditRenderTag},
      {"binding", 5, &S::EditBinding},       {"material value", 4, &S::EditMaterialValue}, {"material graph", 2, &S::EditMaterialGraph},
      {"shape", 2, &S::EditShape},           {"light", 6, &S::EditLight},         {"camera", 3, &S::EditCamera},
      {"instances", 6, &S::EditInstances},   {"removal", 4, &S::RemovePrim},      {"re-creation", 4, &S::RestorePrim},
      {"type", 2, &S::ChangeType},           {"camera switch", 1, &S::SwitchCamera}, {"AOVs", 2, &S::SwitchAovs},
      {"size", 1, &S::Resize},               {"setting", 4, &S::EditSetting},     {"nothing new", 1, &S::TellNothingNew}};
  return edits;
}

std::string EditScript::Step(EditSink& sink) {
  int total = 0;
  for (const Edit& edit : Edits()) total += edit.weight;
  for (;;) {
    int left = static_cast<int>(Pick(static_cast<uint32_t>(total)));
    const Edit* chosen = nullptr;
    for (const Edit& edit : Edits()) {
      chosen = &edit;
      if ((left -= edit.weight) < 0) break;
    }
    const std::string done = (this->*chosen->run)(sink);
    if (done.empty()) continue;  // nothing of that kind is left: another edit
    ++counts_[chosen->name];
    const uint32_t how = Pick(12);
    control_ = how < 4 ? static_cast<RenderControl>(how + 1) : RenderControl::Go;
    return std::string(chosen->name) + " of " + done;
  }
}

std::string EditScript::Tell(EditSink& sink, const std::string& path, uint32_t parts, const std::string& what) {
  const bool everything = Chance(5);
  sink.Change(path, scene_.prims.at(path), everything ? static_cast<uint32_t>(kPartAll) : parts);
  return path + (what.empty() ? "" : " (" + what + ")") + (everything ? ", told in full" : "");
}

std::string EditScript::EditPoints(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Mesh && !p.mesh.points->front().value.empty(); });
  if (path.empty()) return "";
  auto& points = scene_.prims[path].mesh.points->front().value;
  Float3& p = points[Pick(static_cast<uint32_t>(points.size()))];
  p.x += static_cast<float>(Number(-0.3, 0.3));
  p.y += static_cast<float>(Number(-0.3, 0.3));
  return Tell(sink, path, kPartPoints, "");
}

std::string EditScript::EditTopology(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Mesh; });
  if (path.empty()) return "";
  delegate::MeshUpdate& mesh = scene_.prims[path].mesh;
  auto& indices = mesh.topology->faceVertexIndices;
  switch (Pick(5)) {
    case 0:  // broken, and mended the next time
      indices[0] = indices[0] == 99 ? 0 : 99;
      return Tell(sink, path, kPartTopology, indices[0] == 99 ? "broken" : "mended");
    case 1:
      mesh.topology->orientation = mesh.topology->orientation == "leftHanded" ? "rightHanded" : "leftHanded";
      return Tell(sink, path, kPartTopology, mesh.topology->orientation);
    case 2:
      mesh.refineLevel = static_cast<int>(Pick(3));
      return Tell(sink, path, kPartRefine, "level " + std::to_string(*mesh.refineLevel));
    case 3:
      if (mesh.topology->faceVertexCounts.size() < 2) return "";
      mesh.topology->holeIndices = {static_cast<int32_t>(Pick(static_cast<uint32_t>(mesh.topology->faceVertexCounts.size())))};
      return Tell(sink, path, kPartTopology, "a hole");
    default:
      mesh.doubleSided = !*mesh.doubleSided;
      return Tell(sink, path, kPartSides, "");
  }
}

std::string EditScript::EditPrimvars(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.isGprim(); });
  if (path.empty()) return "";
  auto& primvars = *scene_.prims[path].gprim().primvars;
  const auto color = [&] { return static_cast<float>(Number(0, 1)); };
  const auto found = std::find_if(primvars.begin(), primvars.end(), [](const PrimvarInput& p) { return p.name == "displayColor"; });
  if (found != primvars.end() && Chance(4)) {
    primvars.erase(found);
    return Tell(sink, path, kPartPrimvars, "no displayColor");
  }
  if (found != primvars.end()) primvars.erase(found);
  primvars.push_back({"displayColor", "constant", 3, {color(), color(), color()}, {}});
  if (Chance(3)) primvars.push_back({"displayOpacity" + std::string(Chance(2) ? "" : "Unused"), "constant", 1, {color()}, {}});
  if (primvars.size() > 3) primvars.erase(primvars.begin());
  return Tell(sink, path, kPartPrimvars, "displayColor");
}

std::string EditScript::EditTransform(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind != PrimKind::Material; });
  if (path.empty()) return "";
  ScenePrim& prim = scene_.prims[path];
  Matrix4d m = RandomTransform();
  if (prim.kind == PrimKind::Light) m.m[3][1] += 2;
  if (prim.kind == PrimKind::Camera) {
    m = Matrix4d{};
    m.m[3] = {Number(-1, 1), Number(-1, 1), Number(8, 10), 1};
  }
  if (prim.isGprim() && Chance(10)) m.m[3][0] = std::nan("");  // not drawn until it moves again
  if (prim.kind == PrimKind::Instancer) prim.instancer.transform = Still(m);
  else if (prim.kind == PrimKind::Light) prim.light.transforms = Still(m);
  else if (prim.kind == PrimKind::Camera) prim.camera.transforms = Still(m);
  else prim.gprim().transforms = Still(m);
  return Tell(sink, path, kPartTransform, "");
}

std::string EditScript::EditVisibility(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind != PrimKind::Material && p.kind != PrimKind::Camera; });
  if (path.empty()) return "";
  ScenePrim& prim = scene_.prims[path];
  auto& visible = prim.kind == PrimKind::Instancer ? prim.instancer.visible : prim.kind == PrimKind::Light ? prim.light.visible : prim.gprim().visible;
  visible = !*visible;
  return Tell(sink, path, kPartVisibility, *visible ? "shown" : "hidden");
}

std::string EditScript::EditRenderTag(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.isGprim(); });
  if (path.empty()) return "";
  auto& tag = scene_.prims[path].gprim().renderTag;
  tag = *tag == "geometry" ? "guide" : "geometry";
  return Tell(sink, path, kPartRenderTag, *tag);
}

std::string EditScript::EditBinding(EditSink& sink) {
  const bool subset = Chance(3);
  const std::string path = AnyPath([&](const ScenePrim& p) { return subset ? p.kind == PrimKind::Mesh && !p.mesh.subsetMaterials->empty() : p.isGprim(); });
  if (path.empty()) return "";
  ScenePrim& prim = scene_.prims[path];
  const std::string material = Chance(6) ? "" : Chance(8) ? "/looks/nowhere" : Any(kSceneMaterials);
  if (subset) prim.mesh.subsetMaterials->front() = material;
  else prim.gprim().material = material;
  return Tell(sink, path, kPartMaterial, material.empty() ? "none" : material);
}

std::string EditScript::EditMaterialValue(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Material; });
  if (path.empty()) return "";
  auto& values = scene_.prims[path].material.contexts.front().second.nodes.front().parameters;
  if (values.count("displacement") && Chance(2)) {
    values["displacement"] = static_cast<float>(Chance(4) ? 0.0 : Number(-0.1, 0.2));
    return Tell(sink, path, kPartNetwork, "displacement");
  }
  values["diffuseColor"] = std::array<float, 3>{static_cast<float>(Number(0, 1)), 0.5f, static_cast<float>(Number(0, 1))};
  return Tell(sink, path, kPartNetwork, "");
}

std::string EditScript::EditMaterialGraph(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Material; });
  if (path.empty()) return "";
  const uint32_t variant = Pick(kSceneNetworks);
  scene_.prims[path].material = Network(path, variant);
  return Tell(sink, path, kPartNetwork, "variant " + std::to_string(variant));
}

std::string EditScript::EditShape(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Implicit; });
  if (path.empty()) return "";
  auto& shape = *scene_.prims[path].implicit.shape;
  shape.size = Chance(12) ? 0 : 0.25 * (1 + Pick(4));  // 0: cannot be drawn
  shape.radius = shape.size / 2;
  return Tell(sink, path, kPartShape, "size " + std::to_string(shape.size));
}

std::string EditScript::EditLight(EditSink& sink) {
  const bool dome = Chance(3);
  const std::string path = AnyPath([&](const ScenePrim& p) { return p.kind == PrimKind::Light && (p.type == "domeLight") == dome; });
  if (path.empty()) return "";
  delegate::LightParams& params = *scene_.prims[path].light.params;
  switch (dome && Chance(2) ? 5 : Pick(6)) {
    case 0: params.intensity = static_cast<float>(Number(0, 8)); break;
    case 1: params.color = {static_cast<float>(Number(0, 1)), 1, static_cast<float>(Number(0, 1))}; break;
    case 2: params.radius = params.width = static_cast<float>(Number(0.125, 1)); break;
    case 3: params.normalize = !params.normalize; break;
    case 4:
      if (params.shaping) params.shaping.reset();
      else params.shaping.emplace().coneAngle = 40;
      break;
    default:
      if (!dome) params.shadowEnable = !params.shadowEnable;
      else if (params.texture.resolvedPath.empty()) params.texture = {"sky2.png", "/textures/sky2.png", ""};
      else params.texture = {};
  }
  return Tell(sink, path, kPartParams, "");
}

std::string EditScript::EditCamera(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Camera; });
  if (path.empty()) return "";
  delegate::CameraParams& params = *scene_.prims[path].camera.params;
  switch (Pick(4)) {
    case 0: params.focalLength = static_cast<float>(Number(20, 40)); break;
    case 1: params.exposure = static_cast<float>(Number(-1, 1)); break;
    case 2: params.horizontalApertureOffset = static_cast<float>(Number(-2, 2)); break;
    default:
      params.fStop = params.fStop > 0 ? 0.0f : 1.0f;
      params.focusDistance = 8;
  }
  return Tell(sink, path, kPartParams, "");
}

std::string EditScript::EditInstances(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Instancer; });
  if (path.empty()) return "";
  delegate::InstancerUpdate& instancer = scene_.prims[path].instancer;
  auto& positions = instancer.positions->front().value;
  const auto count = static_cast<uint32_t>(positions.size());
  switch (Pick(5)) {
    case 0:
      positions.push_back({static_cast<float>(Number(-2, 2)), 1, 0});
      if (!instancer.protoIndices->empty()) instancer.protoIndices->push_back(0);
      for (PrimvarInput& p : *instancer.primvars) p.values.insert(p.values.end(), p.components, 0.5f);
      break;
    case 1:
      if (count < 2) return "";
      positions.pop_back();
      if (!instancer.protoIndices->empty()) instancer.protoIndices->pop_back();
      for (PrimvarInput& p : *instancer.primvars) p.values.resize(p.values.size() - p.components);
      break;
    case 2: positions[Pick(count)].y += 0.25f; break;
    case 3: instancer.invisibleIds = std::vector<int64_t>(Pick(2), Pick(count)); break;
    default:
      if (instancer.protoIndices->empty()) return "";
      (*instancer.protoIndices)[Pick(static_cast<uint32_t>(instancer.protoIndices->size()))] ^= 1;  // 1: draws nothing
  }
  return Tell(sink, path, kPartInstances | kPartPrimvars, std::to_string(positions.size()));
}

std::string EditScript::RemovePrim(EditSink& sink) {
  std::vector<std::string> paths;
  const bool material = Chance(3);
  for (const auto& [path, prim] : scene_.prims)
    if (path != scene_.camera && (prim.kind == PrimKind::Material) == material) paths.push_back(path);
  if (paths.size() < (material ? 2 : 9)) return "";
  const std::string path = Any(paths);
  sink.Remove(path, scene_.prims.at(path));
  removed_[path] = scene_.prims.at(path);
  scene_.prims.erase(path);
  return path;
}

std::string EditScript::RestorePrim(EditSink& sink) {
  if (removed_.empty()) return "";
  std::vector<std::string> paths;
  for (const auto& [path, prim] : removed_) paths.push_back(path);
  const std::string path = Any(paths);
  scene_.prims[path] = removed_.at(path);
  removed_.erase(path);
  sink.Insert(path, scene_.prims.at(path));
  return path;
}

// A prim of another type at the same path: removed and inserted, as Hydra does it.
std::string EditScript::ChangeType(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) {
    return p.kind == PrimKind::Implicit || (p.kind == PrimKind::Mesh && p.implicit.shape) || (p.kind == PrimKind::Light && p.type != "domeLight" && p.type != "distantLight");
  });
  if (path.empty()) return "";
  ScenePrim& prim = scene_.prims[path];
  sink.Remove(path, prim);
  if (prim.kind == PrimKind::Light) {
    prim.type = Any(std::vector<std::string>{"rectLight", "diskLight", "sphereLight", "cylinderLight"});
    prim.light.params->type = prim.type;
    prim.light.params->type[0] = static_cast<char>(prim.type[0] - 'a' + 'A');
  } else if (prim.kind == PrimKind::Mesh) {  // back to the shape that it was
    static_cast<delegate::GprimUpdate&>(prim.implicit) = prim.mesh;
    prim.kind = PrimKind::Implicit;
    prim.type = prim.implicit.shape->shape == delegate::ImplicitShape::Cube ? "cube" : "cone";
  } else if (Chance(2)) {  // a mesh in the place of the shape
    delegate::MeshUpdate mesh = scene_.prims.count("/world/floor") ? scene_.prims["/world/floor"].mesh : delegate::MeshUpdate();
    if (!mesh.topology) {
      sink.Insert(path, prim);
      return path + " (the same)";
    }
    static_cast<delegate::GprimUpdate&>(mesh) = prim.implicit;
    mesh.points = Still(std::vector<Float3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
    prim.kind = PrimKind::Mesh;
    prim.type = "mesh";
    prim.mesh = mesh;
  } else {
    const bool cube = prim.type != "cube";
    prim.type = cube ? "cube" : "cone";
    prim.implicit.shape->shape = cube ? delegate::ImplicitShape::Cube : delegate::ImplicitShape::Cone;
  }
  sink.Insert(path, prim);
  return path + " (now " + prim.type + ")";
}

std::string EditScript::SwitchCamera(EditSink& sink) {
  const std::string path = AnyPath([](const ScenePrim& p) { return p.kind == PrimKind::Camera; });
  if (path == scene_.camera) return "";
  scene_.camera = path;
  sink.ChangeRender(scene_);
  return path;
}

std::string EditScript::SwitchAovs(EditSink& sink) {
  scene_.aovs = {"color"};
  for (const char* token : {"primId", "instanceId", "elementId", "depth", "cameraDepth", "normal", "Neye", "albedo", "primvars:st", "primvars:displayColor"})
    if (Chance(2)) scene_.aovs.push_back(token);
  sink.ChangeRender(scene_);
  std::string all;
  for (const std::string& token : scene_.aovs) all += token + " ";
  return all;
}

std::string EditScript::Resize(EditSink& sink) {
  scene_.width = 8 + 4 * Pick(6);
  scene_.height = 8 + 3 * Pick(5);
  sink.ChangeRender(scene_);
  return std::to_string(scene_.width) + " x " + std::to_string(scene_.height);
}

bool EditScript::IsAnythingOff() const {
  for (const auto& [token, value] : scene_.settings)
    if (std::holds_alternative<bool>(value) && !std::get<bool>(value)) return true;
  return false;
}

std::string EditScript::EditSetting(EditSink& sink) {
  const char* const switches[] = {"enableShadows", "enableSceneMaterials", "enableSceneLights", "domeLightCameraVisibility"};
  std::string token;
  switch (IsAnythingOff() ? 3 : Pick(5)) {
    case 0: scene_.settings[token = "samples"] = int64_t{1} + Pick(3); break;
    case 1: scene_.settings[token = "maxBounces"] = int64_t{Pick(4)}; break;
    case 2: scene_.settings[token = "seed"] = int64_t{Pick(1000)}; break;
    default:  // one switch is off at a time, and soon on again: in the dark nothing shows
      for (const char* off : switches)
        if (const auto held = scene_.settings.find(off); held != scene_.settings.end() && !std::get<bool>(held->second)) token = off;
      if (!token.empty()) scene_.settings[token] = true;
      else scene_.settings[token = switches[Pick(4)]] = false;
  }
  sink.ChangeRender(scene_);
  return token;
}

std::string EditScript::TellNothingNew(EditSink& sink) {
  for (const auto& [path, prim] : scene_.prims) sink.Change(path, prim, kPartAll);
  sink.ChangeRender(scene_);
  return "everything";
}

}  // namespace delegate_test
