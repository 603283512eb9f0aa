// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>
#include <cmath>
#include <set>

#include "delegate/capture/captured_scene.h"

namespace delegate {
namespace {

using namespace wavefront;

constexpr uint32_t kMaxSide = 65536;
constexpr std::size_t kMaxItems = std::size_t{1} << 27;      // triangles of a mesh, instances of a scene: the core's own limit
constexpr uint32_t kMaxTextureId = 1u << 20;                 // ids left out are made and let go again when a scene is sent
constexpr uint32_t kMaxElements = 1u << 30;

bool Finite(const Float3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }
bool Finite(const Matrix4d& m) {
  return std::all_of(m.m.begin(), m.m.end(), [](const auto& row) { return std::all_of(row.begin(), row.end(), [](double v) { return std::isfinite(v); }); });
}
bool Finite(const std::vector<TimeSample<Matrix4d>>& samples) {
  return !samples.empty() && std::all_of(samples.begin(), samples.end(), [](const auto& s) { return std::isfinite(s.time) && Finite(s.value); });
}

// Elements that a primvar must have, where `own` says how many its kind of interpolation reads.
const char* PrimvarTrouble(const PrimvarData& p, std::size_t own) {
  if ((p.components < 1 || p.components > 4) && p.components != 16) return "a primvar of a size that there is not";
  std::size_t elements = own;
  if (!p.indices.empty()) {
    if (p.interpolation != Interpolation::FaceVarying) return "a primvar with indices that nothing reads";
    if (p.indices.size() != own) return "a primvar with too few or too many indices";
    const uint32_t last = *std::max_element(p.indices.begin(), p.indices.end());
    if (last >= kMaxElements) return "a primvar index that is out of range";
    elements = std::size_t{last} + 1;
  }
  return p.values.size() / p.components < elements || p.values.size() % p.components != 0 ? "a primvar with too few values" : nullptr;
}

const char* MeshTrouble(const MeshData& m) {
  const std::size_t points = m.positions.size(), triangles = m.triangles.size();
  if (triangles > kMaxItems) return "more triangles than a mesh may have";
  if (!std::all_of(m.positions.begin(), m.positions.end(), [](const Float3& p) { return Finite(p); })) return "a point that is not finite";
  for (const UInt3& t : m.triangles)
    if (t.x >= points || t.y >= points || t.z >= points) return "a triangle of points that it has not";
  if (!m.faceIds.empty() && m.faceIds.size() != triangles) return "face numbers that do not fit its triangles";
  if (!m.materialSlots.empty() && m.materialSlots.size() != triangles) return "material slots that do not fit its triangles";
  std::size_t faces = triangles;
  if (!m.faceIds.empty()) faces = std::size_t{*std::max_element(m.faceIds.begin(), m.faceIds.end())} + 1;
  for (const PrimvarData& p : m.primvars) {
    std::size_t own = 1;
    if (p.interpolation == Interpolation::Instance) return "a primvar of instances";
    if (p.interpolation == Interpolation::Uniform) own = faces;
    if (p.interpolation == Interpolation::Vertex) own = points;
    if (p.interpolation == Interpolation::FaceVarying) own = 3 * triangles;
    if (const char* trouble = PrimvarTrouble(p, own)) return trouble;
  }
  for (const auto& d : m.displacements)
    if (d && (!d->spirv || d->spirv->empty())) return "a displacement without a kernel";
  return nullptr;
}

const char* TextureTrouble(TextureId id, const TextureData& t) {
  if (id >= kMaxTextureId) return "a texture id that no renderer gives";
  if (t.width == 0 || t.height == 0 || t.width > kMaxSide || t.height > kMaxSide) return "a texture of a size that there is not";
  return t.texels.size() != std::size_t{t.width} * t.height * TexelBytes(t.format) ? "a texture whose texels do not fit its size" : nullptr;
}

const char* TextureSetTrouble(const CapturedScene& scene) {
  for (const auto& [id, texture] : scene.textures)
    if (const char* trouble = TextureTrouble(id, texture)) return trouble;
  for (const auto& [id, tiles] : scene.tiles) {
    if (id >= kMaxTextureId || scene.textures.count(id) != 0) return "a set of tiles with an id that is taken";
    for (const TextureTile& tile : tiles)
      if (tile.udim < 1001 || tile.udim > 9999 || tile.texture >= id || scene.textures.count(tile.texture) == 0)
        return "a tile that there is not";
  }
  return nullptr;
}

const char* InstanceTrouble(const CapturedScene& scene, const InstanceData& d) {
  if (scene.meshes.count(d.mesh) == 0) return "instances of a mesh that there is not";
  for (MaterialId id : d.materials)
    if (id != kInvalidId && scene.materials.count(id) == 0) return "instances with a material that there is not";
  for (const auto& samples : d.transforms)
    if (!Finite(samples)) return "an instance without a place";
  if (!d.instanceIds.empty() && d.instanceIds.size() != d.transforms.size()) return "instance numbers that do not fit";
  for (const PrimvarData& p : d.instancePrimvars) {
    const bool each = p.interpolation == Interpolation::Instance;
    if (!each && p.interpolation != Interpolation::Constant) return "a primvar that instances do not have";
    if (const char* trouble = PrimvarTrouble(p, each ? d.transforms.size() : 1)) return trouble;
  }
  return nullptr;
}

const char* MaterialTrouble(const CapturedScene& scene) {
  std::set<std::string> keys;
  for (const CapturedKernel& kernel : scene.kernels) {
    if (!keys.insert(kernel.key).second) return "two kernels of one key";
    if (kernel.glsl[0].empty()) return "a kernel without a surface";
    // A driver takes what begins like SPIR-V and is whole; the checksum has seen to that.
    for (const auto& spirv : kernel.spirv)
      if (!spirv.empty() && (spirv.size() < 5 || spirv[0] != 0x07230203u)) return "a kernel that is no SPIR-V";
  }
  for (const auto& [id, material] : scene.materials) {
    if (keys.count(material.kernelKey) == 0) return "a material of a kernel that there is not";
    if (material.mediumPriority > 31) return "a material of a priority that there is not";
  }
  if (scene.defaultMaterial != kInvalidId && scene.materials.count(scene.defaultMaterial) == 0) return "a default material that there is not";
  return nullptr;
}

const char* CameraTrouble(const CameraData& c) {
  if (!Finite(c.transforms)) return "a camera without a place";
  return c.clipPlanes.size() > CameraData::kMaxClipPlanes ? "more clipping planes than a camera has" : nullptr;
}

const char* SettingsTrouble(const RenderSettings& s) {
  if (s.width == 0 || s.height == 0 || s.width > kMaxSide || s.height > kMaxSide) return "an image of a size that there is not";
  std::set<Aov> aovs(s.aovs.begin(), s.aovs.end());
  if (aovs.size() != s.aovs.size() || s.primvarAovs.size() > kMaxPrimvarAovs) return "AOVs that no render has";
  return nullptr;
}

}  // namespace

Status CheckScene(const CapturedScene& scene) {
  const auto bad = [](const char* chunk, const std::string& path, const char* what) {
    return Error{std::string(chunk) + " makes no sense: it holds " + what + (path.empty() ? "." : " (" + path + ").")};
  };
  if (const char* what = MaterialTrouble(scene)) return bad("MATERIAL", "", what);
  if (const char* what = TextureSetTrouble(scene)) return bad("TEXTURES", "", what);
  for (const auto& [id, mesh] : scene.meshes)
    if (const char* what = MeshTrouble(mesh)) return bad("MESHES", mesh.path, what);
  std::size_t instances = 0;
  for (const auto& [id, data] : scene.instances) {
    if (const char* what = InstanceTrouble(scene, data)) return bad("INSTANCE", data.path, what);
    instances += data.transforms.size();
  }
  if (instances > kMaxItems) return bad("INSTANCE", "", "more instances than a scene may have");
  for (const auto& [id, light] : scene.lights) {
    if (!Finite(light.transforms)) return bad("LIGHTS", light.path, "a light without a place");
    if (light.texture != kInvalidId && scene.textures.count(light.texture) + scene.tiles.count(light.texture) == 0)
      return bad("LIGHTS", light.path, "a light with a texture that there is not");
  }
  if (const char* what = CameraTrouble(scene.camera)) return bad("CAMERA", "", what);
  if (const char* what = SettingsTrouble(scene.settings)) return bad("SETTINGS", "", what);
  return {};
}

}  // namespace delegate
