// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/delegate/edit_script.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace delegate_test {
namespace {

using delegate::PrimvarInput;
using wavefront::Float3;
using wavefront::Matrix4d;

// One sample. (A helper, not braces: GCC 12 breaks on nested ones here.)
template <typename T>
delegate::TimeSamples<T> Still(T value) {
  delegate::TimeSamples<T> samples(1);
  samples[0].value = std::move(value);
  return samples;
}

bool IsGprim(const ScenePrim& p) { return p.kind == PrimKind::Mesh || p.kind == PrimKind::Implicit; }

const std::vector<std::string> kMaterials{"/looks/plain", "/looks/wood", "/looks/lamp", "/looks/veil"};
constexpr uint32_t kNetworkVariants = 5;

}  // namespace

wavefront::TextureData SceneTexture(const std::string& resolvedPath) {
  wavefront::TextureData data;
  data.name = resolvedPath;
  data.width = data.height = 4;
  uint32_t state = 2166136261u;
  for (char c : resolvedPath) state = (state ^ static_cast<uint8_t>(c)) * 16777619u;
  for (uint32_t i = 0; i < 64; ++i) {
    state = state * 1664525u + 1013904223u;
    data.texels.push_back(i % 4 == 3 ? 255 : static_cast<uint8_t>(state >> 24));
  }
  return data;
}

EditScript::EditScript(uint32_t seed) : random_(seed) {
  BuildMaterials();
  BuildMeshes();
  BuildShapes();
  BuildInstancers();
  BuildLights();
  int32_t id = 100;
  for (auto& [path, prim] : scene_.prims)
    if (IsGprim(prim)) prim.gprim().primId = id += 7;
  scene_.camera = "/cameras/main";
  for (const char* path : {"/cameras/main", "/cameras/side"}) {
    ScenePrim& prim = scene_.prims[path];
    prim.kind = PrimKind::Camera;
    prim.type = "camera";
    prim.camera.params.emplace();
    prim.camera.params->clippingNear = 0.1f;
    prim.camera.params->focalLength = 28;  // everything is in the picture
    Matrix4d m;
    m.m[3] = {path == scene_.camera ? 0.0 : 1.5, 0.5, 9, 1};
    prim.camera.transforms = Still(m);
  }
  scene_.aovs = {"color", "depth", "primId", "normal"};
  scene_.settings = {{"samples", int64_t{2}}, {"maxBounces", int64_t{2}}, {"displacementTriangles", int64_t{200}}};
}

double EditScript::Number(double low, double high) { return low + (high - low) * Pick(65) / 64.0; }

std::string EditScript::AnyPath(const std::function<bool(const ScenePrim&)>& fits) {
  std::vector<std::string> paths;
  for (const auto& [path, prim] : scene_.prims)
    if (fits(prim)) paths.push_back(path);
  return paths.empty() ? "" : Any(paths);
}

Matrix4d EditScript::RandomTransform() {
  const double angle = Number(0, 6), c = std::cos(angle), s = std::sin(angle), k = Number(0.4, 1.2);
  Matrix4d m;
  m.m = {{{k * c, 0, k * -s, 0}, {0, k, 0, 0}, {k * s, 0, k * c, 0}, {Number(-2, 2), Number(-1, 2), Number(-2, 1), 1}}};
  if (Chance(4)) m.m[1][1] = -m.m[1][1];  // mirrored
  return m;
}

void EditScript::BuildMeshes() {
  const auto add = [&](const std::string& path, const std::string& material) -> delegate::MeshUpdate& {
    ScenePrim& prim = scene_.prims[path];
    prim.kind = PrimKind::Mesh;
    prim.type = "mesh";
    delegate::MeshUpdate& mesh = prim.mesh;
    mesh.topology.emplace();
    mesh.topology->scheme = "none";
    mesh.transforms = Still(RandomTransform());
    mesh.material = material;
    mesh.visible = true;
    mesh.renderTag = "geometry";
    mesh.doubleSided = true;
    mesh.instancer = "";
    mesh.prototype = 0;
    mesh.subsetMaterials.emplace();
    mesh.refineLevel = 0;
    mesh.primvars.emplace();
    return mesh;
  };
  delegate::MeshUpdate& floor = add("/world/floor", "/looks/plain");
  floor.topology->faceVertexCounts = {4};
  floor.topology->faceVertexIndices = {0, 1, 2, 3};
  floor.points = Still(std::vector<Float3>{{-6, -1.5f, 4}, {6, -1.5f, 4}, {6, -1.5f, -6}, {-6, -1.5f, -6}});
  floor.transforms = Still(Matrix4d{});
  floor.primvars = {{PrimvarInput{"st", "faceVarying", 2, {0, 0, 4, 0, 4, 4, 0, 4}, {}}}};
  // Boxes: one as it is, with a subset; one subdivided, with a crease.
  for (const char* path : {"/world/box", "/world/soft"}) {
    delegate::MeshUpdate& box = add(path, path == std::string("/world/box") ? "/looks/wood" : "/looks/plain");
    box.topology->faceVertexCounts = {4, 4, 4, 4, 4, 4};
    box.topology->faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    box.points = Still(std::vector<Float3>());
    for (int i = 0; i < 8; ++i) box.points->front().value.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
    PrimvarInput st{"st", "vertex", 2, {}, {}}, tint{"displayColor", "uniform", 3, {}, {}};
    for (int i = 0; i < 8; ++i) st.values.insert(st.values.end(), {i & 1 ? 1.f : 0.f, i & 2 ? 1.f : 0.f});
    for (int i = 0; i < 18; ++i) tint.values.push_back(0.05f * static_cast<float>(i));
    box.primvars = {{st, tint}};
  }
  delegate::MeshUpdate& box = scene_.prims["/world/box"].mesh;
  box.topology->subsets = {{"/world/box/lid", {1, 3}}};  // what the camera sees first
  Matrix4d near;
  near.m = {{{0.6, 0, -0.2, 0}, {0, 0.6, 0, 0}, {0.2, 0, 0.6, 0}, {-1.2, 0.4, 2, 1}}};
  box.transforms = Still(near);
  box.subsetMaterials = {"/looks/veil"};
  delegate::MeshUpdate& soft = scene_.prims["/world/soft"].mesh;
  soft.topology->scheme = "catmullClark";
  soft.topology->creaseIndices = {0, 1, 3};
  soft.topology->creaseLengths = {3};
  soft.topology->creaseSharpnesses = {2};
  soft.refineLevel = 2;
  delegate::MeshUpdate& lamp = add("/world/glow", "/looks/lamp");
  lamp.topology->faceVertexCounts = {3};
  lamp.topology->faceVertexIndices = {0, 1, 2};
  lamp.points = Still(std::vector<Float3>{{0, 0, 0}, {0.6f, 0, 0}, {0, 0.6f, 0}});
  delegate::MeshUpdate& leaf = add("/world/trees/twigs/leaf", "/looks/plain");
  leaf.topology->faceVertexCounts = {3};
  leaf.topology->faceVertexIndices = {0, 1, 2};
  leaf.points = Still(std::vector<Float3>{{0, 0, 0}, {0.7f, 0, 0}, {0, 0.9f, 0.1f}});
  leaf.transforms = Still(Matrix4d{});
  leaf.instancer = "/world/trees/twigs";
}

void EditScript::BuildShapes() {
  const auto add = [&](const std::string& path, const std::string& type, delegate::ImplicitShape shape) {
    ScenePrim& prim = scene_.prims[path];
    prim.kind = PrimKind::Implicit;
    prim.type = type;
    prim.implicit.shape.emplace();
    prim.implicit.shape->shape = shape;
    prim.implicit.shape->size = 0.8;
    prim.implicit.shape->radius = 0.5;
    prim.implicit.shape->height = 1;
    prim.implicit.transforms = Still(RandomTransform());
    prim.implicit.material = Any(kMaterials);
    prim.implicit.visible = true;
    prim.implicit.renderTag = "geometry";
    prim.implicit.doubleSided = false;
    prim.implicit.instancer = "";
    prim.implicit.prototype = 0;
    prim.implicit.primvars = {{PrimvarInput{"displayColor", "constant", 3, {0.9f, 0.3f, 0.2f}, {}}}};
  };
  add("/world/cube", "cube", delegate::ImplicitShape::Cube);
  add("/world/twin", "cube", delegate::ImplicitShape::Cube);  // equal: they share a mesh
  add("/world/cone", "cone", delegate::ImplicitShape::Cone);
  add("/world/trees/trunk", "cube", delegate::ImplicitShape::Cube);
  scene_.prims["/world/trees/trunk"].implicit.instancer = "/world/trees";
}

void EditScript::BuildInstancers() {
  const auto add = [&](const std::string& path, size_t count) -> delegate::InstancerUpdate& {
    ScenePrim& prim = scene_.prims[path];
    prim.kind = PrimKind::Instancer;
    prim.type = "instancer";
    delegate::InstancerUpdate& instancer = prim.instancer;
    instancer.transforms.emplace();
    instancer.positions = Still(std::vector<Float3>());
    for (size_t i = 0; i < count; ++i)
      instancer.positions->front().value.push_back({static_cast<float>(Number(-2, 2)), static_cast<float>(Number(0, 1)), static_cast<float>(Number(0, 2))});
    instancer.orientations.emplace();
    instancer.scales.emplace();
    instancer.protoIndices = std::vector<int32_t>(count, 0);
    instancer.ids.emplace();
    instancer.invisibleIds.emplace();
    instancer.transform = Still(Matrix4d{});
    instancer.primvars.emplace();
    instancer.visible = true;
    instancer.parent = "";
    instancer.parentPrototype = 0;
    return instancer;
  };
  add("/world/trees", 2).protoIndices->clear();  // every prototype everywhere
  delegate::InstancerUpdate& twigs = add("/world/trees/twigs", 3);
  twigs.parent = "/world/trees";
  twigs.primvars = {{PrimvarInput{"displayColor", "instance", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {}}}};
  add("/world/bulbs", 2);
}

void EditScript::BuildLights() {
  const auto add = [&](const std::string& path, const std::string& type, float intensity) -> delegate::LightUpdate& {
    ScenePrim& prim = scene_.prims[path];
    prim.kind = PrimKind::Light;
    prim.type = type;
    delegate::LightUpdate& light = prim.light;
    light.params.emplace();
    light.params->type = type;
    light.params->type[0] = static_cast<char>(type[0] - 'a' + 'A');
    light.params->intensity = intensity;
    Matrix4d m;
    m.m[3] = {Number(-2, 2), Number(2, 4), Number(-1, 4), 1};
    light.transforms = Still(m);
    light.visible = true;
    light.instancer = "";
    light.prototype = 0;
    return light;
  };
  add("/lights/rect", "rectLight", 12);
  add("/lights/ball", "sphereLight", 6);
  add("/lights/sun", "distantLight", 1);
  add("/lights/dome", "domeLight", 0.3f).params->texture = {"sky.png", "/textures/sky.png", ""};
  delegate::LightUpdate& bulb = add("/world/bulbs/bulb", "diskLight", 5);
  bulb.instancer = "/world/bulbs";
}

// Variants differ in topology: plain, textured, emissive, partly there, and one that nobody can render. One in three moves
// the points of what wears it: by a value, or by the texture.
delegate::MaterialUpdate EditScript::Network(const std::string& path, uint32_t variant) {
  materialgen::MaterialNetwork network;
  network.path = path;
  network.surfaceNode = path + "/surface";
  network.surfaceOutput = "surface";
  const auto tone = [&] { return static_cast<float>(Number(0.1, 0.9)); };
  std::map<std::string, materialgen::Value> values{{"diffuseColor", std::array<float, 3>{tone(), tone(), tone()}},
                                                   {"roughness", tone()}};
  if (variant == 2) values["emissiveColor"] = std::array<float, 3>{4 * tone(), 4 * tone(), 4 * tone()};
  if (variant == 3) values["opacity"] = tone();
  if (Chance(3)) {
    values["displacement"] = 0.2f * tone();
    network.displacementNode = network.surfaceNode;
    network.displacementOutput = "displacement";
  }
  network.nodes = {{network.surfaceNode, variant == 4 ? "NoSuchSurface" : "UsdPreviewSurface", values}};
  if (variant == 1) {
    const std::string file = "wood" + std::to_string(Pick(3)) + ".png", texture = path + "/texture", reader = path + "/reader";
    network.nodes.push_back({texture, "UsdUVTexture", {{"file", materialgen::AssetValue{file, "/textures/" + file, ""}}}});
    network.nodes.push_back({reader, "UsdPrimvarReader_float2", {{"varname", std::string("st")}}});
    network.connections.push_back({texture, "rgb", network.surfaceNode, "diffuseColor"});
    if (Chance(2)) network.connections.push_back({texture, "r", network.surfaceNode, "displacement"});
    network.connections.push_back({reader, "result", texture, "st"});
  }
  return {{{"", std::move(network)}}};
}

void EditScript::BuildMaterials() {
  for (uint32_t i = 0; i < kMaterials.size(); ++i) {
    ScenePrim& prim = scene_.prims[kMaterials[i]];
    prim.kind = PrimKind::Material;
    prim.type = "material";
    prim.material = Network(kMaterials[i], i);
  }
}

void EditScript::Populate(EditSink& sink) {
  std::vector<std::string> paths;
  for (const auto& [path, prim] : scene_.prims) paths.push_back(path);
  for (size_t i = paths.size(); i > 1; --i) std::swap(paths[i - 1], paths[Pick(static_cast<uint32_t>(i))]);
  for (const std::string& path : paths) sink.Insert(path, scene_.prims.at(path));
  sink.ChangeRender(scene_);
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
  const std::string path = AnyPath([](const ScenePrim& p) { return IsGprim(p); });
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
  if (IsGprim(prim) && Chance(10)) m.m[3][0] = std::nan("");  // not drawn until it moves again
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
  const std::string path = AnyPath([](const ScenePrim& p) { return IsGprim(p); });
  if (path.empty()) return "";
  auto& tag = scene_.prims[path].gprim().renderTag;
  tag = *tag == "geometry" ? "guide" : "geometry";
  return Tell(sink, path, kPartRenderTag, *tag);
}

std::string EditScript::EditBinding(EditSink& sink) {
  const bool subset = Chance(3);
  const std::string path = AnyPath([&](const ScenePrim& p) { return subset ? p.kind == PrimKind::Mesh && !p.mesh.subsetMaterials->empty() : IsGprim(p); });
  if (path.empty()) return "";
  ScenePrim& prim = scene_.prims[path];
  const std::string material = Chance(6) ? "" : Chance(8) ? "/looks/nowhere" : Any(kMaterials);
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
  const uint32_t variant = Pick(kNetworkVariants);
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
