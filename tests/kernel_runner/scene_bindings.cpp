// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The tables that the scene commit writes, for tests in Python: lights and textures in, bytes of the streams out, so that
// the kernels' readers are tested against the very layout that C++ makes.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <stdexcept>

#include "wavefront/scene/interface_table.h"
#include "wavefront/scene/light_table.h"
#include "wavefront/scene/mip_chain.h"
#include "wavefront/scene/texture_store.h"
#include "wavefront/shared/scene_layout.h"

namespace nb = nanobind;

namespace {

using namespace wavefront;

void Check(const Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}

template <typename T>
nb::bytes ToBytes(const std::vector<T>& items) {
  return nb::bytes(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(T));
}

TexelFormat FormatOf(const std::string& name) {
  if (name == "rgba8") return TexelFormat::Rgba8Unorm;
  if (name == "rgba16f") return TexelFormat::Rgba16Float;
  if (name == "rgba16") return TexelFormat::Rgba16Unorm;
  if (name == "rgba32f") return TexelFormat::Rgba32Float;
  throw std::runtime_error("unknown texel format '" + name + "'");
}

nb::bytes StreamBytes(Stream& stream, uint64_t elementBytes) {
  std::vector<std::byte> bytes(stream.elements() * elementBytes);
  if (!bytes.empty()) Check(stream.Read(0, bytes));
  return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Float3 Triple(nb::handle value) {
  const auto v = nb::cast<std::vector<float>>(value);
  if (v.size() != 3) throw std::runtime_error("three numbers wanted");
  return {v[0], v[1], v[2]};
}

LightType TypeOf(const std::string& name) {
  static const std::map<std::string, LightType> types = {
      {"rect", LightType::Rect},         {"disk", LightType::Disk},       {"sphere", LightType::Sphere},
      {"cylinder", LightType::Cylinder}, {"distant", LightType::Distant}, {"dome", LightType::Dome}};
  const auto found = types.find(name);
  if (found == types.end()) throw std::runtime_error("unknown light type '" + name + "'");
  return found->second;
}

// Keys are the names of LightData's fields; "transform" holds 16 numbers, row vectors (p' = p M).
LightData LightOf(const nb::dict& from) {
  LightData light;
  for (auto [key, value] : from) {
    const std::string name = nb::cast<std::string>(key);
    if (name == "path") light.path = nb::cast<std::string>(value);
    else if (name == "type") light.type = TypeOf(nb::cast<std::string>(value));
    else if (name == "transform") {
      const auto m = nb::cast<std::vector<double>>(value);
      if (m.size() != 16) throw std::runtime_error("a transform has 16 numbers");
      TimeSample<Matrix4d> sample;
      for (int i = 0; i < 16; ++i) sample.value.m[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
      light.transforms = {sample};
    } else if (name == "castsShadows") light.castsShadows = nb::cast<bool>(value);
    else if (name == "radiance") light.radiance = Triple(value);
    else if (name == "focusTint") light.focusTint = Triple(value);
    else if (name == "width") light.width = nb::cast<float>(value);
    else if (name == "height") light.height = nb::cast<float>(value);
    else if (name == "radius") light.radius = nb::cast<float>(value);
    else if (name == "length") light.length = nb::cast<float>(value);
    else if (name == "angle") light.angle = nb::cast<float>(value);
    else if (name == "coneAngle") light.coneAngle = nb::cast<float>(value);
    else if (name == "coneSoftness") light.coneSoftness = nb::cast<float>(value);
    else if (name == "focus") light.focus = nb::cast<float>(value);
    else if (name == "texture") light.texture = nb::cast<uint32_t>(value);
    else if (name == "lightGroup") light.lightGroup = nb::cast<uint32_t>(value);
    else if (name == "visibleToCamera") light.visibleToCamera = nb::cast<bool>(value);
    else throw std::runtime_error("unknown field of a light: " + name);
  }
  return light;
}

// textures: (width, height, "rgba8", "rgba16f", "rgba16" or "rgba32f", bytes), row 0 at the bottom; the index is the texture id.
// tiles: sets of (UDIM number, texture id), whose ids follow those of the textures. names: of textures, for diagnostics.
// commits: (textures created by then, bytes that textures may take, 0: no limit), by commit. The first `gone` textures are
// destroyed before the last one. again: the bytes that textures may take from then on; what is coarse is created anew.
// emissive: (instance, records, areas, corners) as EmissiveTriangles, corners as floats. light_sampling: as the setting.
// memoryBudget: bytes, 0: the device's.
nb::dict SceneTables(const std::vector<nb::dict>& lights, const std::vector<std::tuple<uint32_t, uint32_t, std::string, nb::bytes>>& textures,
                     const std::vector<std::tuple<uint32_t, std::vector<uint32_t>, std::vector<float>, std::vector<float>>>& emissive, double sceneRadius,
                     uint64_t memoryBudget, const std::string& lightSampling, const std::vector<std::vector<std::pair<uint32_t, uint32_t>>>& tiles,
                     const std::vector<std::string>& names, std::vector<std::pair<std::size_t, uint64_t>> commits,
                     uint32_t gone, std::optional<uint64_t> again) {
  vulkan::DeviceOptions options;
  options.memoryBudgetBytes = memoryBudget;
  auto device = vulkan::Device::Create(options);
  if (!device) throw std::runtime_error(device.error().message);
  nb::dict out;
  nb::list diagnostics;
  const DiagnosticSink sink = [&](const Diagnostic& d) { diagnostics.append(nb::make_tuple(d.code, d.location, d.message)); };
  TextureStore store(*device.value());
  std::size_t index = 0;
  if (commits.empty()) commits.emplace_back(textures.size(), 0);
  const auto create = [&](std::size_t i) {
    const auto& [width, height, format, bytes] = textures.at(i);
    TextureData data;
    data.name = i < names.size() ? names[i] : "texture " + std::to_string(i);
    data.width = width;
    data.height = height;
    data.format = FormatOf(format);
    const auto* first = reinterpret_cast<const uint8_t*>(bytes.c_str());
    data.texels.assign(first, first + bytes.size());
    store.Create(std::move(data));
  };
  for (const auto& [count, limit] : commits) {
    for (; index < count; ++index) create(index);
    if (&limit == &commits.back().second) {
      for (uint32_t id = 0; id < gone; ++id) store.Destroy(id);
      for (const auto& set : tiles) {
        std::vector<TextureTile> all;
        for (const auto& [udim, id] : set) all.push_back({udim, id});
        store.CreateTiles(std::move(all));
      }
    }
    bool changed = false;
    store.SetLimit(limit);
    Check(store.Commit(sink, &changed));
  }
  if (again) {
    const std::vector<TextureId> coarse = store.Coarse(*again);
    for (TextureId id : coarse) {
      store.Destroy(id);
      create(id);
    }
    bool changed = false;
    store.SetLimit(*again);
    Check(store.Commit(sink, &changed));
    out["coarse"] = coarse;
    out["stillCoarse"] = store.Coarse(*again);
  }
  std::vector<LightData> all;
  for (const nb::dict& light : lights) all.push_back(LightOf(light));
  std::vector<EmissiveTriangles> triangles;
  for (const auto& [instance, records, areas, corners] : emissive) {
    std::vector<Float3> points;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) points.push_back({corners[i], corners[i + 1], corners[i + 2]});
    triangles.push_back({instance, records, areas, points, 0});
  }
  const LightSampling sampling = lightSampling == "tree" ? LightSampling::Tree : lightSampling == "power" ? LightSampling::Power : LightSampling::Auto;
  const LightTable table = BuildLightTable(std::move(all), triangles, store, {}, sceneRadius, sampling, true, sink);
  nb::list shapes;
  for (const LightShape& s : table.shapes) {
    std::vector<double> m;
    for (const auto& row : s.transform.m) m.insert(m.end(), row.begin(), row.end());
    shapes.append(nb::make_tuple(s.kind, s.light, m));
  }
  nb::list itemBases;
  for (const EmissiveTriangles& e : triangles) itemBases.append(e.itemBase);
  out["lightRecords"] = ToBytes(table.records);
  out["lightItems"] = ToBytes(table.items);
  out["lightDistribution"] = ToBytes(table.distribution);
  out["lightCount"] = table.lightCount;
  out["infiniteCount"] = table.infiniteCount;
  out["itemCount"] = table.itemCount;
  out["lightTree"] = table.tree;
  out["shapes"] = shapes;
  out["itemBases"] = itemBases;
  out["textureRecords"] = StreamBytes(store.records, 16 * layout::kTextureTexels);
  out["pageTable"] = StreamBytes(store.pageTable, 4);
  out["texturePages"] = StreamBytes(store.pages, layout::kPageBlockBytes);
  out["diagnostics"] = diagnostics;
  out["poolBytes"] = store.pages.buffer()->size();
  return out;
}

}  // namespace

void bindScene(nb::module_& module) {
  module.def("scene_tables", &SceneTables, nb::arg("lights"), nb::arg("textures"), nb::arg("emissive"), nb::arg("scene_radius"),
             nb::arg("memory_budget") = 0, nb::arg("light_sampling") = "auto", nb::arg("tiles") = std::vector<std::vector<std::pair<uint32_t, uint32_t>>>(),
             nb::arg("names") = std::vector<std::string>(),
             nb::arg("commits") = std::vector<std::pair<std::size_t, uint64_t>>(), nb::arg("gone") = 0, nb::arg("again") = nb::none());
  module.def("interface_table", [] { return ToBytes(InterfaceTableTexels()); });
  module.def("halve_level", [](const nb::bytes& texels, uint32_t width, uint32_t height, const std::string& format) {
    const auto* first = reinterpret_cast<const uint8_t*>(texels.c_str());
    return ToBytes(HalveLevel({first, first + texels.size()}, width, height, FormatOf(format)));
  });
}
