// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/hydra/scene_delegate.h"

#include <pxr/base/gf/camera.h>
#include <pxr/base/gf/quatf.h>
#include <pxr/base/gf/range1f.h>
#include <pxr/imaging/cameraUtil/conformWindow.h>
#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/imaging/hd/meshTopology.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <algorithm>

#include "plugin/hydra/convert_primvars.h"
#include "plugin/hydra/convert_value.h"
#include "tests/hydra/host_mesh.h"

namespace hydra_test {

using delegate_test::PrimKind;
using delegate_test::ScenePrim;

namespace {

VtIntArray Ints(const std::vector<int32_t>& v) { return VtIntArray(v.begin(), v.end()); }
VtFloatArray FloatArray(const std::vector<float>& v) { return VtFloatArray(v.begin(), v.end()); }

template <typename T>
VtValue Vectors(const std::vector<float>& values) {
  VtArray<T> array(values.size() / T::dimension);
  for (size_t i = 0; i < array.size() * T::dimension; ++i) array[i / T::dimension][i % T::dimension] = values[i];
  return VtValue(array);
}

VtValue PrimvarValue(const delegate::PrimvarInput& p) {
  switch (p.components) {
    case 2: return Vectors<GfVec2f>(p.values);
    case 3: return Vectors<GfVec3f>(p.values);
    case 4: return Vectors<GfVec4f>(p.values);
    default: return VtValue(FloatArray(p.values));
  }
}

VtValue Points(const std::vector<wavefront::Float3>& points) {
  VtVec3fArray array;
  for (const auto& p : points) array.push_back(GfVec3f(p.x, p.y, p.z));
  return VtValue(array);
}

GfMatrix4d Matrix(const wavefront::Matrix4d& m) {
  GfMatrix4d result;
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = 0; j < 4; ++j) result[static_cast<int>(i)][static_cast<int>(j)] = m.m[i][j];
  return result;
}

VtValue Parameter(const materialgen::Value& value) {
  return std::visit(
      [](const auto& v) -> VtValue {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, materialgen::AssetValue>)
          return VtValue(SdfAssetPath(v.authoredPath, v.resolvedPath));
        else if constexpr (std::is_same_v<T, std::array<float, 2>>) return VtValue(GfVec2f(v[0], v[1]));
        else if constexpr (std::is_same_v<T, std::array<float, 3>>) return VtValue(GfVec3f(v[0], v[1], v[2]));
        else if constexpr (std::is_same_v<T, std::array<float, 4>>) return VtValue(GfVec4f(v[0], v[1], v[2], v[3]));
        else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) return VtValue(v);
        else return VtValue();
      },
      value);
}

const char* InstancePrimvar(const TfToken& key) {
  if (key == HdInstancerTokens->instanceTranslations) return "positions";
  if (key == HdInstancerTokens->instanceRotations) return "orientations";
  if (key == HdInstancerTokens->instanceScales) return "scales";
  if (key == HdInstancerTokens->instanceTransforms) return "transforms";
  return nullptr;
}

VtValue InstanceArray(const delegate::InstancerUpdate& instancer, const TfToken& key) {
  const auto has = [](const auto& samples) { return samples && !samples->empty() && !samples->front().value.empty(); };
  if (key == HdInstancerTokens->instanceTranslations && has(instancer.positions))
    return Points(instancer.positions->front().value);
  if (key == HdInstancerTokens->instanceScales && has(instancer.scales)) return Points(instancer.scales->front().value);
  if (key == HdInstancerTokens->instanceRotations && has(instancer.orientations)) {
    VtArray<GfQuatf> array;
    for (const auto& q : instancer.orientations->front().value) array.push_back(GfQuatf(q.w, q.x, q.y, q.z));
    return VtValue(array);
  }
  if (key == HdInstancerTokens->instanceTransforms && has(instancer.transforms)) {
    VtMatrix4dArray array;
    for (const auto& m : instancer.transforms->front().value) array.push_back(Matrix(m));
    return VtValue(array);
  }
  return {};
}

}  // namespace

const ScenePrim* SceneDelegate::Find(const SdfPath& id) const {
  const auto found = prims.find(id.GetString());
  return found == prims.end() ? nullptr : &found->second;
}

const delegate::GprimUpdate* SceneDelegate::Gprim(const SdfPath& id) const {
  const ScenePrim* prim = Find(id);
  if (!prim) return nullptr;
  if (prim->kind == PrimKind::Mesh) return &prim->mesh;
  return prim->kind == PrimKind::Implicit ? &prim->implicit : nullptr;
}

const std::vector<delegate::PrimvarInput>& SceneDelegate::Primvars(const SdfPath& id) const {
  static const std::vector<delegate::PrimvarInput> none;
  const ScenePrim* prim = Find(id);
  if (!prim) return none;
  const auto& primvars = prim->kind == PrimKind::Instancer ? prim->instancer.primvars
                         : Gprim(id)                       ? Gprim(id)->primvars
                                                           : prim->mesh.primvars;
  return primvars ? *primvars : none;
}

HdMeshTopology SceneDelegate::GetMeshTopology(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  if (prim && prim->kind == PrimKind::Implicit && prim->implicit.shape)
    return MeshOfHost(*prim->implicit.shape).topology;
  if (!prim || !prim->mesh.topology) return {};
  const delegate::MeshTopology& t = *prim->mesh.topology;
  HdMeshTopology topology(TfToken(t.scheme), TfToken(t.orientation), Ints(t.faceVertexCounts),
                          Ints(t.faceVertexIndices), Ints(t.holeIndices));
  HdGeomSubsets subsets;
  for (size_t i = 0; i < t.subsets.size(); ++i) {
    const auto& materials = prim->mesh.subsetMaterials;
    const std::string material = materials && i < materials->size() ? (*materials)[i] : std::string();
    subsets.push_back({HdGeomSubset::TypeFaceSet, SdfPath(t.subsets[i].path), SdfPath(material),
                       Ints(t.subsets[i].indices)});
  }
  topology.SetGeomSubsets(subsets);
  topology.SetSubdivTags(GetSubdivTags(id));
  return topology;
}

PxOsdSubdivTags SceneDelegate::GetSubdivTags(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  if (!prim || !prim->mesh.topology) return {};
  const delegate::MeshTopology& t = *prim->mesh.topology;
  return PxOsdSubdivTags(TfToken(t.interpolateBoundary), TfToken(t.faceVaryingLinearInterpolation), TfToken(),
                         TfToken(t.triangleSubdivisionRule), Ints(t.creaseIndices), Ints(t.creaseLengths),
                         FloatArray(t.creaseSharpnesses), Ints(t.cornerIndices), FloatArray(t.cornerSharpnesses));
}

GfMatrix4d SceneDelegate::GetTransform(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  if (!prim) return GfMatrix4d(1);
  const auto& samples = prim->kind == PrimKind::Instancer ? prim->instancer.transform
                        : prim->kind == PrimKind::Light   ? prim->light.transforms
                        : prim->kind == PrimKind::Camera  ? prim->camera.transforms
                        : Gprim(id)                       ? Gprim(id)->transforms
                                                          : prim->mesh.transforms;
  return samples && !samples->empty() ? Matrix(samples->front().value) : GfMatrix4d(1);
}

bool SceneDelegate::GetVisible(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  if (!prim) return true;
  if (prim->kind == PrimKind::Instancer) return prim->instancer.visible.value_or(true);
  if (prim->kind == PrimKind::Light) return prim->light.visible.value_or(true);
  return !Gprim(id) || Gprim(id)->visible.value_or(true);
}

bool SceneDelegate::GetDoubleSided(const SdfPath& id) { return Gprim(id) && Gprim(id)->doubleSided.value_or(false); }

HdDisplayStyle SceneDelegate::GetDisplayStyle(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  return HdDisplayStyle(prim ? prim->mesh.refineLevel.value_or(0) : 0);
}

VtValue SceneDelegate::Get(const SdfPath& id, const TfToken& key) {
  const ScenePrim* prim = Find(id);
  if (!prim) return {};
  if (prim->kind == PrimKind::Mesh && key == HdTokens->points)
    return prim->mesh.points ? Points(prim->mesh.points->front().value) : VtValue();
  if (prim->kind == PrimKind::Instancer && InstancePrimvar(key)) return InstanceArray(prim->instancer, key);
  for (const auto& primvar : Primvars(id))
    if (primvar.name == key.GetString()) return PrimvarValue(primvar);
  if (prim->kind != PrimKind::Implicit || !prim->implicit.shape) return {};
  const delegate::ImplicitInput& s = *prim->implicit.shape;
  if (key == HdTokens->points) return VtValue(MeshOfHost(s).points);
  const std::map<std::string, double> sizes{{"size", s.size},     {"radius", s.radius}, {"height", s.height},
                                            {"width", s.width},   {"length", s.length}, {"radiusTop", s.radiusTop},
                                            {"radiusBottom", s.radiusBottom}};
  if (key == TfToken("axis")) return VtValue(TfToken(s.axis));
  const auto size = sizes.find(key.GetString());
  return size == sizes.end() ? VtValue() : VtValue(size->second);
}

VtValue SceneDelegate::GetIndexedPrimvar(const SdfPath& id, const TfToken& key, VtIntArray* indices) {
  for (const auto& primvar : Primvars(id))
    if (primvar.name == key.GetString() && indices) *indices = Ints(primvar.indices);
  return Get(id, key);
}

HdPrimvarDescriptorVector SceneDelegate::GetPrimvarDescriptors(const SdfPath& id, HdInterpolation interpolation) {
  HdPrimvarDescriptorVector result;
  const ScenePrim* prim = Find(id);
  if (!prim) return result;
  if (prim->kind == PrimKind::Mesh && interpolation == HdInterpolationVertex)
    result.emplace_back(HdTokens->points, interpolation, HdPrimvarRoleTokens->point);
  if (prim->kind == PrimKind::Instancer && interpolation == HdInterpolationInstance)
    for (const TfToken& key : {HdInstancerTokens->instanceTranslations, HdInstancerTokens->instanceRotations,
                               HdInstancerTokens->instanceScales, HdInstancerTokens->instanceTransforms})
      if (!InstanceArray(prim->instancer, key).IsEmpty()) result.emplace_back(key, interpolation);
  for (const auto& primvar : Primvars(id))
    if (primvar.interpolation == hydra::ToInterpolation(interpolation))
      result.emplace_back(TfToken(primvar.name), interpolation, HdPrimvarRoleTokens->none, !primvar.indices.empty());
  return result;
}

TfToken SceneDelegate::GetRenderTag(const SdfPath& id) {
  return TfToken(Gprim(id) ? Gprim(id)->renderTag.value_or("geometry") : std::string("geometry"));
}

SdfPath SceneDelegate::GetMaterialId(const SdfPath& id) {
  const std::string path = Gprim(id) ? Gprim(id)->material.value_or("") : std::string();
  return path.empty() ? SdfPath() : SdfPath(path);
}

VtValue SceneDelegate::GetMaterialResource(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  HdMaterialNetworkMap map;
  if (!prim || prim->material.contexts.empty()) return VtValue(map);
  const materialgen::MaterialNetwork& source = prim->material.contexts.front().second;
  HdMaterialNetwork network;
  for (const materialgen::Node& node : source.nodes) {
    HdMaterialNode converted{SdfPath(node.path), TfToken(node.identifier), {}};
    for (const auto& [name, value] : node.parameters) converted.parameters[TfToken(name)] = Parameter(value);
    network.nodes.push_back(std::move(converted));
  }
  const auto isSurface = [&](const HdMaterialNode& n) { return n.path.GetString() == source.surfaceNode; };
  std::stable_partition(network.nodes.begin(), network.nodes.end(), [&](const auto& n) { return !isSurface(n); });
  for (const materialgen::Connection& c : source.connections)
    network.relationships.push_back(
        {SdfPath(c.upstreamNode), TfToken(c.upstreamOutput), SdfPath(c.downstreamNode), TfToken(c.downstreamInput)});
  if (!network.nodes.empty() && isSurface(network.nodes.back())) {
    map.terminals.push_back(network.nodes.back().path);
    if (source.displacementNode == source.surfaceNode) map.map[HdMaterialTerminalTokens->displacement] = network;
    map.map[HdMaterialTerminalTokens->surface] = std::move(network);
  }
  return VtValue(map);
}

SdfPath SceneDelegate::GetInstancerId(const SdfPath& id) {
  const ScenePrim* prim = Find(id);
  std::string path;
  if (prim && prim->kind == PrimKind::Instancer) path = prim->instancer.parent.value_or("");
  else if (prim && prim->kind == PrimKind::Light) path = prim->light.instancer.value_or("");
  else if (Gprim(id)) path = Gprim(id)->instancer.value_or("");
  return path.empty() ? SdfPath() : SdfPath(path);
}

SdfPathVector SceneDelegate::GetInstancerPrototypes(const SdfPath& id) {
  SdfPathVector prototypes;
  for (const auto& [path, prim] : prims)
    if (GetInstancerId(SdfPath(path)) == id) prototypes.emplace_back(path);
  return prototypes;
}

VtIntArray SceneDelegate::GetInstanceIndices(const SdfPath& instancer, const SdfPath& prototype) {
  const ScenePrim* prim = Find(instancer);
  // Hd's instancers are not hidden themselves: hosts hand over no instances.
  if (!prim || !prim->instancer.visible.value_or(true)) return {};
  const ScenePrim* drawn = Find(prototype);
  const int32_t wanted = !drawn                               ? 0
                         : drawn->kind == PrimKind::Instancer ? drawn->instancer.parentPrototype.value_or(0)
                         : drawn->kind == PrimKind::Light     ? drawn->light.prototype.value_or(0)
                         : Gprim(prototype)                   ? Gprim(prototype)->prototype.value_or(0)
                                                              : 0;
  const delegate::InstancerUpdate& u = prim->instancer;
  const auto count = [](const auto& samples) {
    return samples && !samples->empty() ? samples->front().value.size() : size_t{0};
  };
  size_t instances = std::max(count(u.positions), count(u.transforms));
  if (u.protoIndices && !u.protoIndices->empty()) instances = std::min(instances, u.protoIndices->size());
  VtIntArray indices;
  for (size_t i = 0; i < instances; ++i) {
    if (u.protoIndices && !u.protoIndices->empty() && (*u.protoIndices)[i] != wanted) continue;
    const int64_t name = u.ids && i < u.ids->size() ? (*u.ids)[i] : static_cast<int64_t>(i);
    if (u.invisibleIds && std::count(u.invisibleIds->begin(), u.invisibleIds->end(), name)) continue;
    indices.push_back(static_cast<int>(i));
  }
  return indices;
}

VtValue SceneDelegate::GetLightParamValue(const SdfPath& id, const TfToken& name) {
  const ScenePrim* prim = Find(id);
  if (!prim || !prim->light.params) return {};
  const delegate::LightParams& p = *prim->light.params;
  std::map<std::string, VtValue> values{
      {"intensity", VtValue(p.intensity)}, {"exposure", VtValue(p.exposure)},
      {"color", VtValue(GfVec3f(p.color.x, p.color.y, p.color.z))}, {"normalize", VtValue(p.normalize)},
      {"enableColorTemperature", VtValue(p.enableColorTemperature)}, {"colorTemperature", VtValue(p.colorTemperature)},
      {"diffuse", VtValue(p.diffuse)}, {"specular", VtValue(p.specular)}, {"width", VtValue(p.width)},
      {"height", VtValue(p.height)}, {"radius", VtValue(p.radius)}, {"length", VtValue(p.length)},
      {"angle", VtValue(p.angle)}, {"treatAsPoint", VtValue(p.treatAsPoint)}, {"treatAsLine", VtValue(p.treatAsLine)},
      {"shadow:enable", VtValue(p.shadowEnable)}, {"texture:format", VtValue(TfToken(p.textureFormat))},
      {"visibility:camera", VtValue(p.visibleToCamera)}};
  if (!p.texture.authoredPath.empty())
    values["texture:file"] = VtValue(SdfAssetPath(p.texture.authoredPath, p.texture.resolvedPath));
  if (p.shaping) {
    values["shaping:cone:angle"] = VtValue(p.shaping->coneAngle);
    values["shaping:cone:softness"] = VtValue(p.shaping->coneSoftness);
    values["shaping:focus"] = VtValue(p.shaping->focus);
  }
  const auto found = values.find(name.GetString());
  return found == values.end() ? VtValue() : found->second;
}

VtValue SceneDelegate::GetCameraParamValue(const SdfPath& id, const TfToken& name) {
  const ScenePrim* prim = Find(id);
  if (!prim || !prim->camera.params) return {};
  const delegate::CameraParams& p = *prim->camera.params;
  // As UsdImaging hands them over.
  const auto scaled = [](float v) { return VtValue(static_cast<float>(v * GfCamera::APERTURE_UNIT)); };
  if (name == HdCameraTokens->projection)
    return VtValue(p.projection == "orthographic" ? HdCamera::Orthographic : HdCamera::Perspective);
  if (name == HdCameraTokens->horizontalAperture) return scaled(p.horizontalAperture);
  if (name == HdCameraTokens->verticalAperture) return scaled(p.verticalAperture);
  if (name == HdCameraTokens->horizontalApertureOffset) return scaled(p.horizontalApertureOffset);
  if (name == HdCameraTokens->verticalApertureOffset) return scaled(p.verticalApertureOffset);
  if (name == HdCameraTokens->focalLength) return scaled(p.focalLength);
  if (name == HdCameraTokens->clippingRange) return VtValue(GfRange1f(p.clippingNear, p.clippingFar));
  if (name == HdCameraTokens->fStop) return VtValue(p.fStop);
  if (name == HdCameraTokens->focusDistance) return VtValue(p.focusDistance);
  if (name == HdCameraTokens->exposure) return VtValue(p.exposure);
  if (name == HdCameraTokens->windowPolicy) return VtValue(CameraUtilFit);
  return {};
}

void HdSink::Insert(const std::string& path, const ScenePrim& prim) {
  scene_.prims[path] = prim;
  const SdfPath id(path);
  switch (prim.kind) {
    case PrimKind::Mesh: index_.InsertRprim(TfToken(prim.type), &scene_, id); break;
    case PrimKind::Implicit:
      index_.InsertRprim(scene_.implicitsAsMeshes ? HdPrimTypeTokens->mesh : TfToken(prim.type), &scene_, id);
      break;
    case PrimKind::Instancer: index_.InsertInstancer(&scene_, id); break;
    default: index_.InsertSprim(TfToken(prim.type), &scene_, id); break;
  }
}

void HdSink::Change(const std::string& path, const ScenePrim& prim, uint32_t parts) {
  using namespace delegate_test;
  scene_.prims[path] = prim;
  const SdfPath id(path);
  HdChangeTracker& tracker = index_.GetChangeTracker();
  HdDirtyBits bits = 0;
  const auto map = [&](uint32_t part, HdDirtyBits dirty) {
    if (parts & part) bits |= dirty;
  };
  switch (prim.kind) {
    case PrimKind::Light:
      map(kPartTransform, HdLight::DirtyTransform);
      map(kPartParams | kPartVisibility, HdLight::DirtyParams | HdLight::DirtyShadowParams);
      break;
    case PrimKind::Camera:
      map(kPartTransform, HdCamera::DirtyTransform);
      map(kPartParams, HdCamera::DirtyParams);
      break;
    case PrimKind::Material: map(kPartNetwork, HdMaterial::AllDirty); break;
    case PrimKind::Instancer:
      map(kPartTransform, HdChangeTracker::DirtyTransform);
      map(kPartPrimvars, HdChangeTracker::DirtyPrimvar);
      map(kPartInstances | kPartVisibility, HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyInstanceIndex);
      break;
    default:
      map(kPartTransform, HdChangeTracker::DirtyTransform);
      map(kPartVisibility, HdChangeTracker::DirtyVisibility);
      map(kPartMaterial, HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyTopology);
      map(kPartPoints, HdChangeTracker::DirtyPoints);
      map(kPartTopology, HdChangeTracker::DirtyTopology | HdChangeTracker::DirtySubdivTags);
      map(kPartPrimvars, HdChangeTracker::DirtyPrimvar);
      map(kPartShape, scene_.implicitsAsMeshes ? HdChangeTracker::DirtyPoints : HdChangeTracker::DirtyPrimvar);
      map(kPartRenderTag, HdChangeTracker::DirtyRenderTag);
      map(kPartSides, HdChangeTracker::DirtyDoubleSided);
      map(kPartRefine, HdChangeTracker::DirtyDisplayStyle);
      break;
  }
  if (bits == 0) return;
  if (prim.kind == PrimKind::Instancer) tracker.MarkInstancerDirty(id, bits);
  else if (prim.kind == PrimKind::Mesh || prim.kind == PrimKind::Implicit) tracker.MarkRprimDirty(id, bits);
  else tracker.MarkSprimDirty(id, bits);
}

void HdSink::Remove(const std::string& path, const ScenePrim& prim) {
  const SdfPath id(path);
  switch (prim.kind) {
    case PrimKind::Mesh:
    case PrimKind::Implicit: index_.RemoveRprim(id); break;
    case PrimKind::Instancer: index_.RemoveInstancer(id); break;
    default: index_.RemoveSprim(TfToken(prim.type), id); break;
  }
  scene_.prims.erase(path);
}

void HdSink::ChangeRender(const delegate_test::Scene& scene) {
  for (const auto& [token, value] : scene.settings)
    index_.GetRenderDelegate()->SetRenderSetting(TfToken("wavefront:" + token), hydra::FromSetting(value));
}

}  // namespace hydra_test
