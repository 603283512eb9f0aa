// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// sync_mesh, sync_implicit, sync_instancer. Argument names and shapes are documented in hdwavefront/_core.pyi.
#include <nanobind/stl/string.h>

#include "plugin/python/src/bindings.h"
#include "plugin/python/src/convert.h"

namespace nb = nanobind;
using namespace nb::literals;
using delegate::RenderDelegate;

namespace {

delegate::MeshTopology ReadTopology(nb::handle value) {
  delegate::MeshTopology t;
  ForItems(value, "topology", [&](const std::string& key, nb::handle item) {
    const std::string name = "topology's " + key;
    const auto whole = [&] { return ReadNumbers<int32_t>(item, name).values; };
    const auto real = [&] { return ReadNumbers<float>(item, name).values; };
    if (key == "scheme") t.scheme = ReadString(item, name);
    else if (key == "orientation") t.orientation = ReadString(item, name);
    else if (key == "faceVertexCounts") t.faceVertexCounts = whole();
    else if (key == "faceVertexIndices") t.faceVertexIndices = whole();
    else if (key == "holeIndices") t.holeIndices = whole();
    else if (key == "interpolateBoundary") t.interpolateBoundary = ReadString(item, name);
    else if (key == "faceVaryingLinearInterpolation") t.faceVaryingLinearInterpolation = ReadString(item, name);
    else if (key == "triangleSubdivisionRule") t.triangleSubdivisionRule = ReadString(item, name);
    else if (key == "cornerIndices") t.cornerIndices = whole();
    else if (key == "cornerSharpnesses") t.cornerSharpnesses = real();
    else if (key == "creaseIndices") t.creaseIndices = whole();
    else if (key == "creaseLengths") t.creaseLengths = whole();
    else if (key == "creaseSharpnesses") t.creaseSharpnesses = real();
    else if (key == "subsets") {
      for (nb::handle subset : item) {
        if (!nb::isinstance<nb::sequence>(subset) || nb::len(subset) != 2)
          RaiseValue(name + " must hold (path, indices)");
        t.subsets.push_back({ReadString(subset[0], name), ReadNumbers<int32_t>(subset[1], name).values});
      }
    } else RaiseValue("topology has no \"" + key + "\"");
  });
  return t;
}

delegate::ImplicitInput ReadShape(nb::handle value) {
  delegate::ImplicitInput shape;
  const std::pair<const char*, delegate::ImplicitShape> types[] = {
      {"Sphere", delegate::ImplicitShape::Sphere},     {"Cube", delegate::ImplicitShape::Cube},
      {"Cone", delegate::ImplicitShape::Cone},         {"Cylinder", delegate::ImplicitShape::Cylinder},
      {"Capsule", delegate::ImplicitShape::Capsule},   {"Plane", delegate::ImplicitShape::Plane}};
  bool hasType = false;
  const std::pair<const char*, double delegate::ImplicitInput::*> sizes[] = {
      {"size", &delegate::ImplicitInput::size},           {"radius", &delegate::ImplicitInput::radius},
      {"radiusTop", &delegate::ImplicitInput::radiusTop}, {"radiusBottom", &delegate::ImplicitInput::radiusBottom},
      {"height", &delegate::ImplicitInput::height},       {"width", &delegate::ImplicitInput::width},
      {"length", &delegate::ImplicitInput::length}};
  ForItems(value, "shape", [&](const std::string& key, nb::handle item) {
    const std::string name = "shape's " + key;
    if (key == "axis") {
      shape.axis = ReadString(item, name);
      return;
    }
    if (key == "type") {
      const std::string type = ReadString(item, name);
      for (const auto& [token, kind] : types)
        if (type == token) {
          shape.shape = kind;
          hasType = true;
        }
      if (!hasType) RaiseValue("there is no implicit shape \"" + type + "\"");
      return;
    }
    for (const auto& [token, member] : sizes)
      if (key == token) {
        shape.*member = ReadNumber(item, name);
        return;
      }
    RaiseValue("shape has no \"" + key + "\"");
  });
  if (!hasType) RaiseValue("shape needs a type");
  return shape;
}

// Fills the part that all Rprims share; false: the argument is not of that part.
bool ReadCommon(delegate::GprimUpdate& update, const std::string& key, nb::handle value) {
  if (key == "primvars") update.primvars = ReadPrimvars(value, key);
  else if (key == "transform") update.transforms = ReadSamples(value, key, ReadMatrix);
  else if (key == "material") update.material = ReadString(value, key);
  else if (key == "visible") update.visible = ReadBool(value, key);
  else if (key == "render_tag") update.renderTag = ReadString(value, key);
  else if (key == "double_sided") update.doubleSided = ReadBool(value, key);
  else if (key == "instancer") update.instancer = ReadString(value, key);
  else if (key == "prototype") update.prototype = ReadInt(value, key);
  else if (key == "prim_id") update.primId = ReadInt(value, key);
  else return false;
  return true;
}

// Calls fn(name, value) for each keyword argument that is not None.
template <typename Fn>
void ForArguments(const nb::kwargs& arguments, Fn fn) {
  for (auto [key, value] : arguments)
    if (!value.is_none()) fn(nb::cast<std::string>(key), value);
}

[[noreturn]] void UnknownArgument(const char* method, const std::string& key) {
  RaiseType(std::string(method) + " has no argument \"" + key + "\"");
}

template <typename Update>
void SyncReleased(RenderDelegate& self, const std::string& path, Update& update) {
  nb::gil_scoped_release release;
  self.Sync(path, std::move(update));
}

void SyncMesh(RenderDelegate& self, const std::string& path, const nb::kwargs& arguments) {
  delegate::MeshUpdate update;
  ForArguments(arguments, [&](const std::string& key, nb::handle value) {
    if (ReadCommon(update, key, value)) return;
    if (key == "topology") update.topology = ReadTopology(value);
    else if (key == "points") update.points = ReadSamples(value, key, ReadFloat3s);
    else if (key == "subset_materials") update.subsetMaterials = ReadStrings(value, key);
    else if (key == "refine_level") update.refineLevel = ReadInt(value, key);
    else UnknownArgument("sync_mesh", key);
  });
  SyncReleased(self, path, update);
}

void SyncImplicit(RenderDelegate& self, const std::string& path, const nb::kwargs& arguments) {
  delegate::ImplicitUpdate update;
  ForArguments(arguments, [&](const std::string& key, nb::handle value) {
    if (ReadCommon(update, key, value)) return;
    if (key == "shape") update.shape = ReadShape(value);
    else UnknownArgument("sync_implicit", key);
  });
  SyncReleased(self, path, update);
}

void SyncInstancer(RenderDelegate& self, const std::string& path, const nb::kwargs& arguments) {
  delegate::InstancerUpdate update;
  ForArguments(arguments, [&](const std::string& key, nb::handle value) {
    const auto hide = [&] {
      if (!update.invisibleIds) update.invisibleIds.emplace();
      for (int64_t id : ReadNumbers<int64_t>(value, key).values) update.invisibleIds->push_back(id);
    };
    if (key == "transforms") update.transforms = ReadSamples(value, key, ReadMatrices);
    else if (key == "positions") update.positions = ReadSamples(value, key, ReadFloat3s);
    else if (key == "orientations") update.orientations = ReadSamples(value, key, ReadFloat4s);
    else if (key == "scales") update.scales = ReadSamples(value, key, ReadFloat3s);
    else if (key == "proto_indices") update.protoIndices = ReadNumbers<int32_t>(value, key).values;
    else if (key == "ids") update.ids = ReadNumbers<int64_t>(value, key).values;
    else if (key == "invisible_ids" || key == "inactive_ids") hide();
    else if (key == "transform") update.transform = ReadSamples(value, key, ReadMatrix);
    else if (key == "primvars") update.primvars = ReadPrimvars(value, key);
    else if (key == "visible") update.visible = ReadBool(value, key);
    else if (key == "parent") update.parent = ReadString(value, key);
    else if (key == "parent_prototype") update.parentPrototype = ReadInt(value, key);
    else UnknownArgument("sync_instancer", key);
  });
  SyncReleased(self, path, update);
}

}  // namespace

void BindGprimSync(DelegateClass& type) {
  type.def("sync_mesh", &SyncMesh, "path"_a, "update"_a);
  type.def("sync_implicit", &SyncImplicit, "path"_a, "update"_a);
  type.def("sync_instancer", &SyncInstancer, "path"_a, "update"_a);
  const auto released = nb::call_guard<nb::gil_scoped_release>();
  type.def("destroy_rprim", &RenderDelegate::DestroyRprim, "path"_a, released);
  type.def("destroy_instancer", &RenderDelegate::DestroyInstancer, "path"_a, released);
}
