// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Diagnostic, TextureRequest, Film, and images as numpy arrays.
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <cstring>

#include "plugin/python/src/bindings.h"
#include "plugin/python/src/convert.h"
#include "plugin/python/src/images.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

const char* SeverityName(wavefront::Severity severity) {
  switch (severity) {
    case wavefront::Severity::Info: return "info";
    case wavefront::Severity::Warning: return "warning";
    case wavefront::Severity::Error: return "error";
  }
  return "error";
}

wavefront::RawFilm MergeFilms(const wavefront::RawFilm& a, const wavefront::RawFilm& b) {
  auto merged = [&] {
    nb::gil_scoped_release release;
    return wavefront::MergeFilms(a, b);
  }();
  if (!merged) RaiseValue(merged.error().message);
  return std::move(merged).value();
}

nb::object ResolveFilm(const wavefront::RawFilm& film, const std::string& token) {
  const std::optional<wavefront::Aov> known = wavefront::FindAov(token, film.primvarAovs);
  if (!known) RaiseValue("the film does not hold the AOV \"" + token + "\"");
  const wavefront::Aov aov = *known;
  wavefront::AovImage image;
  {
    nb::gil_scoped_release release;
    image = wavefront::ResolveFilm(film, aov);
  }
  if (image.bits.empty()) RaiseValue("the film does not hold the AOV \"" + token + "\"");
  return ImageToArray(std::move(image));
}

}  // namespace

template <typename T>
nb::object VectorToArray(std::vector<T> values, std::vector<size_t> shape) {
  auto* owned = new std::vector<T>(std::move(values));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(owned->data(), shape.size(), shape.data(), owner));
}

nb::object ImageToArray(wavefront::AovImage image) {
  const std::vector<size_t> shape{image.height, image.width, image.components};
  const bool isFloat = wavefront::Aovs()[static_cast<size_t>(image.aov)].format == wavefront::AovFormat::Float32;
  auto* owned = new std::vector<uint32_t>(std::move(image.bits));
  nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<uint32_t>*>(p); });
  // The 32-bit values are one type or the other by the AOV's format; numpy reads them as such.
  void* data = owned->data();
  if (isFloat) return nb::cast(nb::ndarray<nb::numpy, float>(data, 3, shape.data(), owner));
  return nb::cast(nb::ndarray<nb::numpy, int32_t>(data, 3, shape.data(), owner));
}

wavefront::TextureData ReadTexture(nb::handle pixels, bool bottomUp) {
  nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu> array;
  if (!nb::try_cast(pixels, array)) RaiseType("pixels must be an array");
  const nb::dlpack::dtype type = array.dtype();
  const bool isHalf = type.code == static_cast<uint8_t>(nb::dlpack::dtype_code::Float) && type.bits == 16;
  wavefront::TextureData data;
  if (isHalf) data.format = wavefront::TexelFormat::Rgba16Float;
  else if (type == nb::dtype<uint8_t>()) data.format = wavefront::TexelFormat::Rgba8Unorm;
  else if (type == nb::dtype<uint16_t>()) data.format = wavefront::TexelFormat::Rgba16Unorm;
  else if (type == nb::dtype<float>()) data.format = wavefront::TexelFormat::Rgba32Float;
  else RaiseType("pixels must be uint8, uint16, float16 or float32");
  if (array.ndim() != 3 || array.shape(2) != 4 || array.shape(0) == 0 || array.shape(1) == 0)
    RaiseValue("pixels must have the shape (height, width, 4)");
  if (array.shape(0) > 65536 || array.shape(1) > 65536) RaiseValue("pixels must have at most 65536 a side");
  data.height = static_cast<uint32_t>(array.shape(0));
  data.width = static_cast<uint32_t>(array.shape(1));
  const size_t rowBytes = array.shape(1) * 4 * (type.bits / 8);
  const auto* from = static_cast<const uint8_t*>(array.data());
  nb::gil_scoped_release release;
  data.texels.resize(rowBytes * data.height);
  for (size_t row = 0; row < data.height; ++row)
    std::memcpy(&data.texels[row * rowBytes], from + (bottomUp ? row : data.height - 1 - row) * rowBytes, rowBytes);
  return data;
}

void BindValues(nb::module_& module) {
  nb::class_<wavefront::Diagnostic>(module, "Diagnostic")
      .def_prop_ro("severity", [](const wavefront::Diagnostic& d) { return SeverityName(d.severity); })
      .def_prop_ro("code", [](const wavefront::Diagnostic& d) { return d.code; })
      .def_prop_ro("location", [](const wavefront::Diagnostic& d) { return d.location; })
      .def_prop_ro("message", [](const wavefront::Diagnostic& d) { return d.message; })
      .def("__repr__", [](const wavefront::Diagnostic& d) {
        return std::string(SeverityName(d.severity)) + ": " + d.code + ": " + d.location + ": " + d.message;
      });
  using Request = delegate::TextureLoadRequest;
  nb::class_<Request>(module, "TextureRequest")
      .def_prop_ro("key", [](const Request& r) { return r.key; })
      .def_prop_ro("resolved_path", [](const Request& r) { return r.texture.resolvedPath; })
      .def_prop_ro("authored_path", [](const Request& r) { return r.authoredPath; })
      .def_prop_ro("color_space", [](const Request& r) { return r.texture.colorSpace; })
      .def_prop_ro("is_color", [](const Request& r) { return r.texture.isColor; })
      .def_prop_ro("location", [](const Request& r) { return r.location; });
  using wavefront::RawFilm;
  nb::class_<RawFilm>(module, "Film")
      .def_prop_ro("width", [](const RawFilm& f) { return f.width; })
      .def_prop_ro("height", [](const RawFilm& f) { return f.height; })
      .def_prop_ro("first_sample", [](const RawFilm& f) { return f.firstSample; })
      .def_prop_ro("samples", [](const RawFilm& f) { return f.samples; })
      .def_prop_ro("sums", [](const RawFilm& f) { return VectorToArray(f.sums, {f.sums.size()}); })
      .def_prop_ro("first", [](const RawFilm& f) { return VectorToArray(f.first, {f.first.size()}); })
      .def("merge", &MergeFilms, "other"_a)
      .def("resolve", &ResolveFilm, "aov"_a);
}

template nb::object VectorToArray<float>(std::vector<float>, std::vector<size_t>);
template nb::object VectorToArray<double>(std::vector<double>, std::vector<size_t>);
