// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The scene of an edit script before its first edit.
#include "tests/delegate/edit_script.h"

#include <cmath>
#include <cstring>

namespace delegate_test {

using delegate::PrimvarInput;
using wavefront::Float3;
using wavefront::Matrix4d;

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
    if (prim.isGprim()) prim.gprim().primId = id += 7;
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
    prim.implicit.material = Any(kSceneMaterials);
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
  for (uint32_t i = 0; i < kSceneMaterials.size(); ++i) {
    ScenePrim& prim = scene_.prims[kSceneMaterials[i]];
    prim.kind = PrimKind::Material;
    prim.type = "material";
    prim.material = Network(kSceneMaterials[i], i);
  }
}

void EditScript::Populate(EditSink& sink) {
  std::vector<std::string> paths;
  for (const auto& [path, prim] : scene_.prims) paths.push_back(path);
  for (size_t i = paths.size(); i > 1; --i) std::swap(paths[i - 1], paths[Pick(static_cast<uint32_t>(i))]);
  for (const std::string& path : paths) sink.Insert(path, scene_.prims.at(path));
  sink.ChangeRender(scene_);
}

}  // namespace delegate_test
