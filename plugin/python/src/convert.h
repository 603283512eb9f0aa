// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Python values to the delegate's: arrays, time samples, dicts. All raise TypeError or ValueError that name the
// argument. Call with the GIL.
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "delegate/prims/gprim.h"
#include "delegate/settings.h"
#include "materialgen/network.h"

// Elements in row-major order, converted to T. `shape` is the array's.
template <typename T>
struct Numbers {
  std::vector<T> values;
  std::vector<size_t> shape;
};

// Anything with the buffer protocol or DLPack, else what numpy makes of it. T: float, double, int32_t, int64_t. Whole
// numbers beyond T's range become its limits.
template <typename T>
Numbers<T> ReadNumbers(nanobind::handle value, const std::string& name);
extern template Numbers<float> ReadNumbers<float>(nanobind::handle, const std::string&);
extern template Numbers<double> ReadNumbers<double>(nanobind::handle, const std::string&);
extern template Numbers<int32_t> ReadNumbers<int32_t>(nanobind::handle, const std::string&);
extern template Numbers<int64_t> ReadNumbers<int64_t>(nanobind::handle, const std::string&);

// (n, 3), (n, 4), (4, 4), (n, 4, 4); n may be 0, then the rest of the shape does not matter.
std::vector<wavefront::Float3> ReadFloat3s(nanobind::handle value, const std::string& name);
std::vector<wavefront::Float4> ReadFloat4s(nanobind::handle value, const std::string& name);
wavefront::Matrix4d ReadMatrix(nanobind::handle value, const std::string& name);
std::vector<wavefront::Matrix4d> ReadMatrices(nanobind::handle value, const std::string& name);

// A still value, or a list of (time, value), sorted by time. None: nothing.
template <typename Read>
auto ReadSamples(nanobind::handle value, const std::string& name, Read read)
    -> std::optional<delegate::TimeSamples<decltype(read(value, name))>>;

std::vector<delegate::PrimvarInput> ReadPrimvars(nanobind::handle value, const std::string& name);

bool ReadBool(nanobind::handle value, const std::string& name);
double ReadNumber(nanobind::handle value, const std::string& name);
int32_t ReadInt(nanobind::handle value, const std::string& name);
std::string ReadString(nanobind::handle value, const std::string& name);
std::vector<std::string> ReadStrings(nanobind::handle value, const std::string& name);
wavefront::Float3 ReadColor(nanobind::handle value, const std::string& name);
materialgen::AssetValue ReadAsset(nanobind::handle value, const std::string& name);
delegate::SettingValue ReadSetting(nanobind::handle value, const std::string& name);
nanobind::object WriteSetting(const delegate::SettingValue& value);

// Calls fn(key, value) for each item of a dict or another mapping.
template <typename Fn>
void ForItems(nanobind::handle mapping, const std::string& name, Fn fn);

// --- implementation of the templates

bool IsSampleList(nanobind::handle value);
void SortSamplesError(const std::string& name);

template <typename Read>
auto ReadSamples(nanobind::handle value, const std::string& name, Read read)
    -> std::optional<delegate::TimeSamples<decltype(read(value, name))>> {
  using Value = decltype(read(value, name));
  if (value.is_none()) return std::nullopt;
  delegate::TimeSamples<Value> samples;
  if (!IsSampleList(value)) {
    samples.push_back({0, read(value, name)});
    return samples;
  }
  for (nanobind::handle item : value) {
    const auto time = static_cast<float>(ReadNumber(item[0], name));
    if (!samples.empty() && !(time > samples.back().time)) SortSamplesError(name);
    samples.push_back({time, read(item[1], name)});
  }
  return samples;
}

template <typename Fn>
void ForItems(nanobind::handle mapping, const std::string& name, Fn fn) {
  if (!nanobind::hasattr(mapping, "items")) {
    PyErr_SetString(PyExc_TypeError, (name + " must be a dict").c_str());
    throw nanobind::python_error();
  }
  for (nanobind::handle item : mapping.attr("items")())
    fn(ReadString(item[0], name + "'s key"), nanobind::handle(nanobind::object(item[1])));
}
