// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// sync_light, sync_camera, sync_material. Argument names are documented in hdwavefront/_core.pyi.
#include <nanobind/stl/string.h>

#include <limits>

#include "plugin/python/src/bindings.h"
#include "plugin/python/src/convert.h"

namespace nb = nanobind;
using namespace nb::literals;
using delegate::RenderDelegate;

namespace {

float ReadFloat(nb::handle value, const std::string& name) { return static_cast<float>(ReadNumber(value, name)); }

bool ReadShaping(delegate::LightShaping& shaping, const std::string& key, nb::handle value) {
  if (key == "shaping:cone:angle") shaping.coneAngle = ReadFloat(value, key);
  else if (key == "shaping:cone:softness") shaping.coneSoftness = ReadFloat(value, key);
  else if (key == "shaping:focus") shaping.focus = ReadFloat(value, key);
  else if (key == "shaping:focusTint") shaping.focusTint = ReadColor(value, key);
  else if (key == "shaping:ies:file") shaping.iesFile = ReadString(value, key);
  else return false;
  return true;
}

delegate::LightParams ReadLight(nb::handle value) {
  using delegate::LightParams;
  LightParams p;
  const std::pair<const char*, float LightParams::*> floats[] = {
      {"intensity", &LightParams::intensity}, {"exposure", &LightParams::exposure},
      {"colorTemperature", &LightParams::colorTemperature}, {"diffuse", &LightParams::diffuse},
      {"specular", &LightParams::specular}, {"width", &LightParams::width}, {"height", &LightParams::height},
      {"radius", &LightParams::radius}, {"length", &LightParams::length}, {"angle", &LightParams::angle}};
  const std::pair<const char*, bool LightParams::*> bools[] = {
      {"enableColorTemperature", &LightParams::enableColorTemperature}, {"normalize", &LightParams::normalize},
      {"treatAsPoint", &LightParams::treatAsPoint}, {"treatAsLine", &LightParams::treatAsLine},
      {"shadow:enable", &LightParams::shadowEnable}, {"visibleToCamera", &LightParams::visibleToCamera}};
  ForItems(value, "params", [&](const std::string& key, nb::handle item) {
    for (const auto& [token, member] : floats)
      if (key == token) {
        p.*member = ReadFloat(item, key);
        return;
      }
    for (const auto& [token, member] : bools)
      if (key == token) {
        p.*member = ReadBool(item, key);
        return;
      }
    if (key == "type") p.type = ReadString(item, key);
    else if (key == "color") p.color = ReadColor(item, key);
    else if (key == "texture:file") p.texture = ReadAsset(item, key);
    else if (key == "texture:format") p.textureFormat = ReadString(item, key);
    else if (key == "poleAxis") p.poleAxis = ReadString(item, key);
    else {
      delegate::LightShaping shaping = p.shaping.value_or(delegate::LightShaping());
      if (!ReadShaping(shaping, key, item)) RaiseValue("lights have no input \"" + key + "\"");
      p.shaping = shaping;
    }
  });
  return p;
}

delegate::CameraParams ReadCamera(nb::handle value) {
  using delegate::CameraParams;
  CameraParams p;
  const std::pair<const char*, float CameraParams::*> floats[] = {
      {"horizontalAperture", &CameraParams::horizontalAperture}, {"verticalAperture", &CameraParams::verticalAperture},
      {"horizontalApertureOffset", &CameraParams::horizontalApertureOffset},
      {"verticalApertureOffset", &CameraParams::verticalApertureOffset}, {"focalLength", &CameraParams::focalLength},
      {"fStop", &CameraParams::fStop}, {"focusDistance", &CameraParams::focusDistance},
      {"exposure", &CameraParams::exposure}, {"exposure:time", &CameraParams::exposureTime},
      {"exposure:iso", &CameraParams::exposureIso}, {"exposure:fStop", &CameraParams::exposureFStop},
      {"exposure:responsivity", &CameraParams::exposureResponsivity}};
  ForItems(value, "params", [&](const std::string& key, nb::handle item) {
    for (const auto& [token, member] : floats)
      if (key == token) {
        p.*member = ReadFloat(item, key);
        return;
      }
    if (key == "projection") p.projection = ReadString(item, key);
    else if (key == "apertureUnit") p.apertureUnit = ReadNumber(item, key);
    else if (key == "shutter:open") p.shutterOpen = ReadNumber(item, key);
    else if (key == "shutter:close") p.shutterClose = ReadNumber(item, key);
    else if (key == "clippingRange") {
      const auto range = ReadNumbers<float>(item, key).values;
      if (range.size() != 2) RaiseValue("clippingRange must have two numbers");
      p.clippingNear = range[0];
      p.clippingFar = range[1];
    } else if (key == "clippingPlanes") {
      const auto numbers = ReadNumbers<float>(item, key).values;
      if (numbers.size() % 4 != 0) RaiseValue("clippingPlanes must have four numbers each");
      for (std::size_t i = 0; i < numbers.size(); i += 4)
        p.clippingPlanes.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
    } else RaiseValue("cameras have no attribute \"" + key + "\"");
  });
  return p;
}

template <size_t N>
materialgen::Value FloatArray(const std::vector<float>& values) {
  std::array<float, N> array;
  std::copy(values.begin(), values.end(), array.begin());
  return array;
}

materialgen::Value ReadValue(nb::handle value, const std::string& name) {
  PyObject* object = value.ptr();
  if (value.is_none()) return std::monostate();
  if (PyBool_Check(object)) return ReadBool(value, name);
  if (PyLong_Check(object)) {
    int overflow = 0;
    const long number = PyLong_AsLongAndOverflow(object, &overflow);
    if (overflow || number < std::numeric_limits<int32_t>::min() || number > std::numeric_limits<int32_t>::max())
      RaiseValue(name + " is too large a whole number");
    return static_cast<int32_t>(number);
  }
  if (PyFloat_Check(object)) return ReadFloat(value, name);
  if (PyUnicode_Check(object)) return ReadString(value, name);
  if (PyDict_Check(object)) return ReadAsset(value, name);
  const std::vector<float> values = ReadNumbers<float>(value, name).values;
  switch (values.size()) {
    case 1: return values[0];
    case 2: return FloatArray<2>(values);
    case 3: return FloatArray<3>(values);
    case 4: return FloatArray<4>(values);
    case 9: return FloatArray<9>(values);
    case 16: return FloatArray<16>(values);
    default: break;
  }
  RaiseValue(name + " must have 2, 3, 4, 9 or 16 numbers, not " + std::to_string(values.size()));
}

materialgen::Node ReadNode(nb::handle value) {
  materialgen::Node node;
  ForItems(value, "node", [&](const std::string& key, nb::handle item) {
    if (key == "path") node.path = ReadString(item, "a node's path");
    else if (key == "identifier") node.identifier = ReadString(item, "a node's identifier");
    else if (key == "parameters")
      ForItems(item, "parameters", [&](const std::string& name, nb::handle parameter) {
        node.parameters[name] = ReadValue(parameter, "parameter \"" + name + "\"");
      });
    else RaiseValue("a node has no \"" + key + "\"");
  });
  return node;
}

materialgen::MaterialNetwork ReadNetwork(const std::string& path, nb::handle value) {
  materialgen::MaterialNetwork network;
  network.path = path;
  ForItems(value, "network", [&](const std::string& key, nb::handle item) {
    if (key == "nodes") {
      for (nb::handle node : item) network.nodes.push_back(ReadNode(node));
    } else if (key == "connections") {
      for (nb::handle connection : item) {
        const std::vector<std::string> ends = ReadStrings(connection, "a connection");
        if (ends.size() != 4) RaiseValue("a connection must have four names");
        network.connections.push_back({ends[0], ends[1], ends[2], ends[3]});
      }
    } else if (key == "surface" || key == "displacement") {
      if (item.is_none()) return;
      const std::vector<std::string> terminal = ReadStrings(item, key.c_str());
      if (terminal.size() != 2) RaiseValue(key + " must be (node, output)");
      const bool isSurface = key == "surface";
      (isSurface ? network.surfaceNode : network.displacementNode) = terminal[0];
      (isSurface ? network.surfaceOutput : network.displacementOutput) = terminal[1];
    } else {
      RaiseValue("a network has no \"" + key + "\"");
    }
  });
  return network;
}

void SyncLight(RenderDelegate& self, const std::string& path, nb::object params, nb::object transform,
               nb::object visible, nb::object instancer, nb::object prototype) {
  delegate::LightUpdate update;
  if (!params.is_none()) update.params = ReadLight(params);
  update.transforms = ReadSamples(transform, "transform", ReadMatrix);
  if (!visible.is_none()) update.visible = ReadBool(visible, "visible");
  if (!instancer.is_none()) update.instancer = ReadString(instancer, "instancer");
  if (!prototype.is_none()) update.prototype = ReadInt(prototype, "prototype");
  nb::gil_scoped_release release;
  self.Sync(path, std::move(update));
}

void SyncCamera(RenderDelegate& self, const std::string& path, nb::object params, nb::object transform) {
  delegate::CameraUpdate update;
  if (!params.is_none()) update.params = ReadCamera(params);
  update.transforms = ReadSamples(transform, "transform", ReadMatrix);
  nb::gil_scoped_release release;
  self.Sync(path, std::move(update));
}

void SyncMaterial(RenderDelegate& self, const std::string& path, nb::object contexts) {
  delegate::MaterialUpdate update;
  ForItems(contexts, "contexts", [&](const std::string& context, nb::handle network) {
    update.contexts.emplace_back(context, ReadNetwork(path, network));
  });
  nb::gil_scoped_release release;
  self.Sync(path, std::move(update));
}

}  // namespace

void BindSprimSync(DelegateClass& type) {
  const nb::object none = nb::none();
  type.def("sync_light", &SyncLight, "path"_a, nb::kw_only(), "params"_a.none() = none,
           "transform"_a.none() = none, "visible"_a.none() = none, "instancer"_a.none() = none,
           "prototype"_a.none() = none);
  type.def("sync_camera", &SyncCamera, "path"_a, nb::kw_only(), "params"_a.none() = none,
           "transform"_a.none() = none);
  type.def("sync_material", &SyncMaterial, "path"_a, "contexts"_a);
  type.def("destroy_sprim", &RenderDelegate::DestroySprim, "path"_a, nb::call_guard<nb::gil_scoped_release>());
}
