// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// RenderDelegate: how it is made, what is rendered, settings, textures.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "plugin/python/src/bindings.h"
#include "plugin/python/src/convert.h"
#include "plugin/python/src/images.h"

namespace nb = nanobind;
using namespace nb::literals;
using delegate::RenderDelegate;

namespace {

// RenderDelegate can neither be copied nor moved, and making one may fail: Python gets it from a static function in
// __new__'s place.
RenderDelegate* MakeDelegate(const std::string& materialxLibraries, const std::string& device, bool validation,
                             uint64_t memoryBudget, uint32_t threads, bool captureOnly) {
  auto made = [&] {
    nb::gil_scoped_release release;
    return RenderDelegate::Create({device, validation, memoryBudget, threads, materialxLibraries, captureOnly});
  }();
  if (!made) RaiseRuntime(made.error().message);
  return std::move(made).value().release();
}

void SetRenderPass(RenderDelegate& self, std::optional<std::string> camera, nb::object width, nb::object height,
                   std::optional<double> pixelAspectRatio,
                   std::optional<std::tuple<double, double, double, double>> dataWindow,
                   std::optional<std::string> windowPolicy, std::optional<std::vector<std::string>> renderTags,
                   std::optional<std::vector<std::string>> aovs) {
  delegate::RenderPassUpdate update;
  // Negative and huge sizes get the same sentence as zero.
  const auto side = [](nb::handle value, const char* name) -> std::optional<uint32_t> {
    if (value.is_none()) return std::nullopt;
    const double number = ReadNumber(value, name);
    return number >= 0 && number <= 1e9 ? static_cast<uint32_t>(number) : 0;
  };
  update.camera = std::move(camera);
  update.width = side(width, "width");
  update.height = side(height, "height");
  update.pixelAspectRatio = pixelAspectRatio;
  if (dataWindow) {
    const auto [left, bottom, right, top] = *dataWindow;
    if (!(left < right && bottom < top)) RaiseValue("a data window is left, bottom, right, top");
    update.dataWindow = delegate::DataWindow{left, right, bottom, top};
  }
  if (windowPolicy) {
    update.windowPolicy = delegate::ParseConformPolicy(*windowPolicy);
    if (!update.windowPolicy) RaiseValue("there is no window policy \"" + *windowPolicy + "\"");
  }
  update.renderTags = std::move(renderTags);
  if (aovs) {
    auto selection = wavefront::SelectAovs(*aovs);
    if (!selection) RaiseValue(selection.error().message);
    update.aovs = std::move(selection.value().aovs);
    update.primvarAovs = std::move(selection.value().primvars);
  }
  if (auto status = self.SetRenderPass(update); !status) RaiseValue(status.error().message);
}

bool SetSetting(RenderDelegate& self, const std::string& token, nb::handle value) {
  auto changed = self.SetRenderSetting(token, ReadSetting(value, "setting " + token));
  if (!changed) RaiseValue(changed.error().message);
  return changed.value();
}

nb::object GetSetting(const RenderDelegate& self, const std::string& token) {
  auto value = self.GetRenderSetting(token);
  if (!value) RaiseValue(value.error().message);
  return WriteSetting(value.value());
}

void SetTexture(RenderDelegate& self, uint32_t key, nb::object pixels, bool bottomUp) {
  wavefront::TextureData data = ReadTexture(pixels, bottomUp);
  auto status = [&] {
    nb::gil_scoped_release release;
    return self.SetTexture(key, std::move(data));
  }();
  if (!status) RaiseValue(status.error().message);
}

void SetTextureTiles(RenderDelegate& self, uint32_t key, const std::vector<uint32_t>& numbers, nb::list pixels) {
  if (numbers.size() != nb::len(pixels)) RaiseValue("a number for each tile is wanted");
  std::vector<std::pair<uint32_t, wavefront::TextureData>> tiles;
  for (size_t i = 0; i < numbers.size(); ++i) tiles.emplace_back(numbers[i], ReadTexture(pixels[i], false));
  auto status = [&] {
    nb::gil_scoped_release release;
    return self.SetTextureTiles(key, std::move(tiles));
  }();
  if (!status) RaiseValue(status.error().message);
}

void SetTextureMissing(RenderDelegate& self, uint32_t key, const std::string& reason) {
  if (auto status = self.SetTextureMissing(key, reason); !status) RaiseValue(status.error().message);
}

}  // namespace

void BindDelegate(nb::module_& module) {
  DelegateClass type(module, "RenderDelegate");
  type.def(nb::new_(&MakeDelegate), nb::kw_only(), "materialx_libraries"_a, "device"_a = "", "validation"_a = false,
           "memory_budget"_a = 0, "threads"_a = 0, "capture_only"_a = false);
  const nb::object none = nb::none();
  type.def("set_render_pass", &SetRenderPass, nb::kw_only(), "camera"_a = none, "width"_a.none() = none,
           "height"_a.none() = none, "pixel_aspect_ratio"_a = none, "data_window"_a = none, "window_policy"_a = none,
           "render_tags"_a = none, "aovs"_a = none);
  type.def("set_setting", &SetSetting, "token"_a, "value"_a);
  type.def("setting", &GetSetting, "token"_a);
  type.def("set_unconverted_color_spaces", &RenderDelegate::SetUnconvertedColorSpaces, "names"_a);
  type.def("pending_textures", &RenderDelegate::PendingTextures, nb::call_guard<nb::gil_scoped_release>());
  type.def("count_decoded_image", &RenderDelegate::CountDecodedImage);
  type.def("set_texture", &SetTexture, "key"_a, "pixels"_a, nb::kw_only(), "bottom_up"_a = false);
  type.def("set_texture_tiles", &SetTextureTiles, "key"_a, "numbers"_a, "pixels"_a);
  type.def("set_texture_missing", &SetTextureMissing, "key"_a, "reason"_a);
  type.def("diagnostics", &RenderDelegate::diagnostics, "since"_a = 0);
  BindGprimSync(type);
  BindSprimSync(type);
  BindRender(type);
}
