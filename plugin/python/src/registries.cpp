// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What there is to choose from: devices, render settings, AOVs.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include "delegate/render_vars.h"
#include "plugin/python/src/bindings.h"
#include "plugin/python/src/convert.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::dict MeasureCopyBandwidth(const std::string& device) {
  auto measured = [&] {
    nb::gil_scoped_release release;
    return wavefront::MeasureCopyBandwidth(device);
  }();
  if (!measured) RaiseRuntime(measured.error().message);
  nb::dict d;
  d["name"] = measured.value().name;
  d["driver"] = measured.value().driver;
  d["type"] = measured.value().type;
  d["bytesPerSecond"] = measured.value().bytesPerSecond;
  return d;
}

nb::list ListDevices() {
  std::vector<wavefront::DeviceDescription> devices;
  {
    nb::gil_scoped_release release;
    devices = wavefront::ListDevices();
  }
  nb::list result;
  for (const wavefront::DeviceDescription& device : devices) {
    nb::dict entry;
    entry["name"] = device.name;
    entry["driver"] = device.driver;
    entry["type"] = device.type;
    entry["apiVersion"] = device.apiVersion;
    entry["heapBytes"] = device.heapBytes;
    entry["subgroupSize"] = device.subgroupSize;
    entry["usable"] = device.usable;
    entry["whyNot"] = device.whyNot;
    entry["details"] = device.details;
    result.append(entry);
  }
  return result;
}

const char* TypeName(delegate::SettingType type) {
  switch (type) {
    case delegate::SettingType::Int: return "int";
    case delegate::SettingType::Float: return "float";
    case delegate::SettingType::Bool: return "bool";
    case delegate::SettingType::Token: return "token";
  }
  return "";
}

// maxBounces -> --maxBounces: usdrecord spells its flags like this.
nb::list RenderSettings() {
  nb::list result;
  for (const delegate::SettingInfo& info : delegate::RenderSettingInfos()) {
    nb::dict entry;
    entry["token"] = info.token;
    entry["type"] = TypeName(info.type);
    entry["default"] = WriteSetting(info.defaultValue);
    entry["minimum"] = info.minimum;
    entry["maximum"] = info.maximum;
    entry["choices"] = delegate::ChoicesOf(info);
    entry["doc"] = info.doc;
    entry["flag"] = "--" + std::string(info.token);
    result.append(entry);
  }
  return result;
}

nb::list Aovs() {
  nb::list result;
  for (const wavefront::AovInfo& info : wavefront::Aovs()) {
    if (wavefront::IsPrimvarAov(info.aov) && info.aov != wavefront::Aov::Primvar0) continue;
    nb::dict entry;
    entry["token"] = wavefront::IsPrimvarAov(info.aov) ? std::string_view("primvars:<name>") : info.token;
    entry["components"] = info.components;
    entry["format"] = info.format == wavefront::AovFormat::Float32 ? "float32" : "int32";
    entry["clear"] = info.clear;
    entry["rule"] = info.rule == wavefront::AovRule::Mean ? "mean" : "firstSample";
    entry["doc"] = info.doc;
    result.append(entry);
  }
  return result;
}

}  // namespace

void BindRegistries(nb::module_& module) {
  module.def("list_devices", &ListDevices);
  module.def("measure_copy_bandwidth", &MeasureCopyBandwidth, "device"_a = "");
  module.def("render_settings", &RenderSettings);
  module.def("aovs", &Aovs);
  module.def("aov_of_render_var", &delegate::AovTokenOfVar, "source_name"_a, "source_type"_a = "raw");
  module.def("aov_channels", &delegate::AovChannels, "aov"_a);
}
