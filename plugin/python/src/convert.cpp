// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/python/src/convert.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "plugin/python/src/bindings.h"

namespace nb = nanobind;

void RaiseValue(const std::string& message) {
  PyErr_SetString(PyExc_ValueError, message.c_str());
  throw nb::python_error();
}
void RaiseType(const std::string& message) {
  PyErr_SetString(PyExc_TypeError, message.c_str());
  throw nb::python_error();
}
void RaiseRuntime(const std::string& message) {
  PyErr_SetString(PyExc_RuntimeError, message.c_str());
  throw nb::python_error();
}

namespace {

using Array = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;

std::string TypeName(nb::handle value) { return nb::cast<std::string>(value.type().attr("__name__")); }

float HalfToFloat(uint16_t half) {
  const uint32_t sign = static_cast<uint32_t>(half & 0x8000u) << 16;
  const uint32_t exponent = (half >> 10) & 31u, mantissa = half & 1023u;
  if (exponent == 31) return std::bit_cast<float>(sign | 0x7f800000u | (mantissa << 13));
  if (exponent != 0) return std::bit_cast<float>(sign | ((exponent + 112) << 23) | (mantissa << 13));
  const float value = std::ldexp(static_cast<float>(mantissa), -24);
  return sign ? -value : value;
}

// One element of any numeric type as T; whole numbers are held to T's range.
template <typename T, typename From>
T Convert(From value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    static_assert(std::is_integral_v<From>);
    if constexpr (sizeof(From) > sizeof(T) || (std::is_unsigned_v<From> && sizeof(From) == sizeof(T))) {
      if constexpr (std::is_unsigned_v<From>) {
        return value > static_cast<From>(std::numeric_limits<T>::max()) ? std::numeric_limits<T>::max()
                                                                         : static_cast<T>(value);
      } else {
        return static_cast<T>(std::clamp<From>(value, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
      }
    } else {
      return static_cast<T>(value);
    }
  }
}

template <typename T, typename From>
void CopyAs(const Array& array, std::vector<T>& out) {
  const auto* from = static_cast<const From*>(array.data());
  if constexpr (std::is_same_v<T, From>) {
    if (!out.empty()) std::memcpy(out.data(), from, out.size() * sizeof(T));
  } else {
    for (size_t i = 0; i < out.size(); ++i) out[i] = Convert<T>(from[i]);
  }
}

template <typename T>
bool CopyFloating(const Array& array, std::vector<T>& out) {
  if constexpr (std::is_floating_point_v<T>) {
    const nb::dlpack::dtype type = array.dtype();
    if (type == nb::dtype<float>()) return CopyAs<T, float>(array, out), true;
    if (type == nb::dtype<double>()) return CopyAs<T, double>(array, out), true;
    if (type.code == static_cast<uint8_t>(nb::dlpack::dtype_code::Float) && type.bits == 16) {
      const auto* from = static_cast<const uint16_t*>(array.data());
      for (size_t i = 0; i < out.size(); ++i) out[i] = static_cast<T>(HalfToFloat(from[i]));
      return true;
    }
  }
  return false;
}

template <typename T>
bool CopyWhole(const Array& array, std::vector<T>& out) {
  const nb::dlpack::dtype type = array.dtype();
  if (type == nb::dtype<int32_t>()) return CopyAs<T, int32_t>(array, out), true;
  if (type == nb::dtype<int64_t>()) return CopyAs<T, int64_t>(array, out), true;
  if (type == nb::dtype<uint32_t>()) return CopyAs<T, uint32_t>(array, out), true;
  if (type == nb::dtype<uint64_t>()) return CopyAs<T, uint64_t>(array, out), true;
  if (type == nb::dtype<int16_t>()) return CopyAs<T, int16_t>(array, out), true;
  if (type == nb::dtype<uint16_t>()) return CopyAs<T, uint16_t>(array, out), true;
  if (type == nb::dtype<int8_t>()) return CopyAs<T, int8_t>(array, out), true;
  if (type == nb::dtype<uint8_t>() || type == nb::dtype<bool>()) return CopyAs<T, uint8_t>(array, out), true;
  return false;
}

// The array behind a value; lists and what else numpy knows go through numpy.
Array ReadArray(nb::handle value, const std::string& name) {
  Array array;
  if (nb::try_cast(value, array)) return array;
  PyErr_Clear();
  try {
    nb::object converted = nb::module_::import_("numpy").attr("ascontiguousarray")(value);
    if (nb::try_cast(converted, array)) return array;
  } catch (nb::python_error&) {
  }
  PyErr_Clear();
  RaiseType(name + " must be an array of numbers, not " + TypeName(value));
}

// True for an empty array, whatever the rest of its shape; raises where the trailing shape is another.
template <typename T>
bool CheckShape(const Numbers<T>& numbers, const std::vector<size_t>& trailing, const std::string& name) {
  if (numbers.values.empty()) return true;
  const bool fits = numbers.shape.size() == trailing.size() + 1 &&
                    std::equal(trailing.begin(), trailing.end(), numbers.shape.begin() + 1);
  if (!fits) {
    std::string wanted = "(n", got = "(";
    for (size_t n : trailing) wanted += ", " + std::to_string(n);
    for (size_t i = 0; i < numbers.shape.size(); ++i) got += (i ? ", " : "") + std::to_string(numbers.shape[i]);
    RaiseValue(name + " must have the shape " + wanted + "), not " + got + ")");
  }
  return false;
}

template <typename T, size_t kComponents>
std::vector<T> ReadVectors(nb::handle value, const std::string& name) {
  const Numbers<float> numbers = ReadNumbers<float>(value, name);
  if (CheckShape(numbers, {kComponents}, name)) return {};
  static_assert(sizeof(T) == kComponents * sizeof(float));
  std::vector<T> result(numbers.shape[0]);
  std::memcpy(result.data(), numbers.values.data(), numbers.values.size() * sizeof(float));
  return result;
}

}  // namespace

template <typename T>
Numbers<T> ReadNumbers(nb::handle value, const std::string& name) {
  const Array array = ReadArray(value, name);
  Numbers<T> numbers;
  for (size_t i = 0; i < array.ndim(); ++i) numbers.shape.push_back(array.shape(i));
  numbers.values.resize(array.size());
  if (!CopyFloating(array, numbers.values) && !CopyWhole(array, numbers.values)) {
    // An empty Python list becomes an array of doubles: no numbers are also no indices.
    if (!numbers.values.empty())
      RaiseType(name + (std::is_floating_point_v<T> ? " must hold numbers" : " must hold whole numbers"));
  }
  return numbers;
}
template Numbers<float> ReadNumbers<float>(nb::handle, const std::string&);
template Numbers<double> ReadNumbers<double>(nb::handle, const std::string&);
template Numbers<int32_t> ReadNumbers<int32_t>(nb::handle, const std::string&);
template Numbers<int64_t> ReadNumbers<int64_t>(nb::handle, const std::string&);

std::vector<wavefront::Float3> ReadFloat3s(nb::handle value, const std::string& name) {
  return ReadVectors<wavefront::Float3, 3>(value, name);
}

std::vector<wavefront::Float4> ReadFloat4s(nb::handle value, const std::string& name) {
  return ReadVectors<wavefront::Float4, 4>(value, name);
}

wavefront::Matrix4d ReadMatrix(nb::handle value, const std::string& name) {
  const Numbers<double> numbers = ReadNumbers<double>(value, name);
  if (numbers.shape != std::vector<size_t>{4, 4}) RaiseValue(name + " must be a 4x4 matrix");
  wavefront::Matrix4d matrix;
  for (size_t i = 0; i < 16; ++i) matrix.m[i / 4][i % 4] = numbers.values[i];
  return matrix;
}

std::vector<wavefront::Matrix4d> ReadMatrices(nb::handle value, const std::string& name) {
  const Numbers<double> numbers = ReadNumbers<double>(value, name);
  if (CheckShape(numbers, {4, 4}, name)) return {};
  std::vector<wavefront::Matrix4d> result(numbers.shape[0]);
  static_assert(sizeof(wavefront::Matrix4d) == 16 * sizeof(double));
  std::memcpy(result.data(), numbers.values.data(), numbers.values.size() * sizeof(double));
  return result;
}

bool IsSampleList(nb::handle value) {
  if (!nb::isinstance<nb::list>(value) && !nb::isinstance<nb::tuple>(value)) return false;
  if (nb::len(value) == 0) return false;
  const nb::object first = value[0];
  if (!nb::isinstance<nb::tuple>(first) || nb::len(first) != 2) return false;
  const nb::object second = first[1];
  return PyNumber_Check(nb::object(first[0]).ptr()) && !PyFloat_Check(second.ptr()) && !PyLong_Check(second.ptr());
}

void SortSamplesError(const std::string& name) { RaiseValue(name + "'s time samples must be in rising order of time"); }

std::vector<delegate::PrimvarInput> ReadPrimvars(nb::handle value, const std::string& name) {
  std::vector<delegate::PrimvarInput> primvars;
  for (nb::handle item : value) {
    if (!nb::isinstance<nb::sequence>(item) || nb::len(item) != 4)
      RaiseValue(name + " must hold (name, interpolation, values, indices)");
    delegate::PrimvarInput primvar;
    primvar.name = ReadString(item[0], name);
    const std::string of = name + " \"" + primvar.name + "\"";
    primvar.interpolation = ReadString(item[1], of);
    Numbers<float> numbers = ReadNumbers<float>(item[2], of);
    size_t components = 1;
    for (size_t i = 1; i < numbers.shape.size(); ++i) components *= numbers.shape[i];
    if (!numbers.values.empty() && !((components >= 1 && components <= 4) || components == 16))
      RaiseValue(of + " must have 1 to 4 or 16 components, not " + std::to_string(components));
    primvar.components = numbers.values.empty() ? 1 : static_cast<uint32_t>(components);
    primvar.values = std::move(numbers.values);
    const nb::object indices = item[3];
    if (!indices.is_none()) primvar.indices = ReadNumbers<int32_t>(indices, of + "'s indices").values;
    primvars.push_back(std::move(primvar));
  }
  return primvars;
}

bool ReadBool(nb::handle value, const std::string& name) {
  const int truth = PyObject_IsTrue(value.ptr());
  if (truth < 0) {
    PyErr_Clear();
    RaiseType(name + " must be True or False");
  }
  return truth != 0;
}

double ReadNumber(nb::handle value, const std::string& name) {
  const double number = PyFloat_AsDouble(value.ptr());
  if (number == -1 && PyErr_Occurred()) {
    PyErr_Clear();
    RaiseType(name + " must be a number, not " + TypeName(value));
  }
  return number;
}

int32_t ReadInt(nb::handle value, const std::string& name) {
  const double number = ReadNumber(value, name);
  if (!(std::abs(number) <= std::numeric_limits<int32_t>::max()) || number != std::floor(number))
    RaiseValue(name + " must be a whole number of at most 31 bits");
  return static_cast<int32_t>(number);
}

std::string ReadString(nb::handle value, const std::string& name) {
  if (!PyUnicode_Check(value.ptr())) RaiseType(name + " must be a string, not " + TypeName(value));
  Py_ssize_t size = 0;
  const char* text = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
  if (!text) {  // lone surrogates: paths that are no UTF-8
    PyErr_Clear();
    RaiseValue(name + " is not valid Unicode");
  }
  return {text, static_cast<size_t>(size)};
}

std::vector<std::string> ReadStrings(nb::handle value, const std::string& name) {
  if (PyUnicode_Check(value.ptr())) RaiseType(name + " must be a list of strings, not one string");
  std::vector<std::string> strings;
  for (nb::handle item : value) strings.push_back(ReadString(item, name));
  return strings;
}

wavefront::Float3 ReadColor(nb::handle value, const std::string& name) {
  const Numbers<float> numbers = ReadNumbers<float>(value, name);
  if (numbers.values.size() != 3) RaiseValue(name + " must have three numbers");
  return {numbers.values[0], numbers.values[1], numbers.values[2]};
}

materialgen::AssetValue ReadAsset(nb::handle value, const std::string& name) {
  materialgen::AssetValue asset;
  ForItems(value, name, [&](const std::string& key, nb::handle item) {
    if (key == "authored") asset.authoredPath = ReadString(item, name);
    else if (key == "resolved") asset.resolvedPath = ReadString(item, name);
    else if (key == "colorSpace") asset.colorSpace = ReadString(item, name);
    else RaiseValue(name + ": an asset has no \"" + key + "\"");
  });
  return asset;
}

delegate::SettingValue ReadSetting(nb::handle value, const std::string& name) {
  if (PyBool_Check(value.ptr())) return ReadBool(value, name);
  if (PyLong_Check(value.ptr())) {
    int overflow = 0;
    const long long number = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
    if (overflow) RaiseValue(name + " is too large a number");
    return static_cast<int64_t>(number);
  }
  if (PyUnicode_Check(value.ptr())) return ReadString(value, name);
  return ReadNumber(value, name);
}

nb::object WriteSetting(const delegate::SettingValue& value) {
  return std::visit([](const auto& v) { return nb::cast(v); }, value);
}
