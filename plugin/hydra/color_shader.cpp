// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Everything that touches OpenColorIO. The names mean what they mean to the Python host (hdwavefront/color/manager.py).
#include "plugin/hydra/color_output.h"

#ifdef HDWAVEFRONT_OPENCOLORIO

#include <OpenColorIO/OpenColorIO.h>

#include <cstdlib>
#include <functional>

namespace ocio = OCIO_NAMESPACE;

namespace hydra {
namespace {

using wavefront::Error;
using wavefront::Result;

// The Python host's default, and what stands for it in a library that does not have it yet.
constexpr const char* kDefaultConfig = "cg-config-v2.2.0_aces-v1.3_ocio-v2.4";
constexpr const char* kOlderDefaultConfig = "ocio://default";

bool IsBuiltin(const std::string& name) {
  const ocio::BuiltinConfigRegistry& registry = ocio::BuiltinConfigRegistry::Get();
  for (size_t i = 0; i < registry.getNumBuiltinConfigs(); ++i)
    if (name == registry.getBuiltinConfigName(i)) return true;
  return false;
}

ocio::ConstConfigRcPtr DefaultConfig() {
  if (IsBuiltin(kDefaultConfig)) return ocio::Config::CreateFromBuiltinConfig(kDefaultConfig);
  return ocio::Config::CreateFromFile(kOlderDefaultConfig);
}

Result<ocio::ConstConfigRcPtr> Load(std::string source) {
  const char* named = "by a render setting";
  if (source == "1" || source == "default") {
    const char* environment = std::getenv("OCIO");
    source = environment ? environment : "";
    named = "by $OCIO";
  }
  try {
    if (source.empty()) return DefaultConfig();
    if (IsBuiltin(source)) return ocio::Config::CreateFromBuiltinConfig(source.c_str());
    return ocio::Config::CreateFromFile(source.c_str());
  } catch (const std::exception& error) {
    return Error{"The OpenColorIO configuration " + source + " (named " + named + ") cannot be read: " + error.what()};
  }
}

std::string Join(int count, const std::function<const char*(int)>& name, bool* found, const std::string& wished) {
  std::string all;
  for (int i = 0; i < count; ++i) {
    all += (i ? ", " : "") + std::string(name(i));
    if (wished == name(i)) *found = true;
  }
  return all;
}

wavefront::Status FindDisplayAndView(const ocio::Config& config, std::string& display, std::string& view) {
  bool found = false;
  if (display.empty()) display = config.getDefaultDisplay();
  const std::string displays =
      Join(config.getNumDisplays(), [&](int i) { return config.getDisplay(i); }, &found, display);
  if (!found)
    return Error{"There is no display '" + display + "' in the OpenColorIO configuration. It has: " + displays + "."};
  found = false;
  if (view.empty()) view = config.getDefaultView(display.c_str());
  const std::string views = Join(
      config.getNumViews(display.c_str()), [&](int i) { return config.getView(display.c_str(), i); }, &found, view);
  if (!found) return Error{"The display '" + display + "' has no view '" + view + "'. It has: " + views + "."};
  return {};
}

// Empty: the configuration has no such space. USD says lin_rec709_scene where older configurations say lin_rec709.
std::string FindSpace(const ocio::Config& config, const std::string& name) {
  constexpr std::string_view suffix = "_scene";
  if (const auto space = config.getColorSpace(name.c_str())) return space->getName();
  if (!name.ends_with(suffix)) return {};
  const auto space = config.getColorSpace(name.substr(0, name.size() - suffix.size()).c_str());
  return space ? space->getName() : std::string();
}

ocio::ConstTransformRcPtr DisplayView(const std::string& source, const std::string& display, const std::string& view) {
  const auto transform = ocio::DisplayViewTransform::Create();
  transform->setSrc(source.c_str());
  transform->setDisplay(display.c_str());
  transform->setView(view.c_str());
  return transform;
}

Result<ocio::ConstProcessorRcPtr> MakeProcessor(const ocio::ConstConfigRcPtr& config, const ColorSettings& settings) {
  std::string display = settings.display, view = settings.view;
  if (const wavefront::Status found = FindDisplayAndView(*config, display, view); !found) return found.error();
  if (const std::string space = FindSpace(*config, settings.renderingSpace); !space.empty())
    return config->getProcessor(DisplayView(space, display, view));
  // The configuration does not know the rendering space: the built-in one takes it to the scene_linear role.
  const ocio::ConstConfigRcPtr builtin = DefaultConfig();
  const std::string space = FindSpace(*builtin, settings.renderingSpace);
  if (space.empty())
    return Error{"The rendering colour space '" + settings.renderingSpace +
                 "' is neither in the OpenColorIO configuration nor in the built-in one."};
  const char* linear = config->getRoleColorSpace(ocio::ROLE_SCENE_LINEAR);
  if (!linear || !*linear) return Error{"The OpenColorIO configuration has no scene_linear role."};
  const auto between = ocio::Config::GetProcessorFromConfigs(builtin, space.c_str(), config, linear);
  const auto group = between->createGroupTransform();
  group->appendTransform(DisplayView(linear, display, view)->createEditableCopy());
  return config->getProcessor(ocio::ConstTransformRcPtr(group));
}

std::vector<wavefront::Renderer::ColorLut> ReadLuts(const ocio::GpuShaderDesc& description) {
  std::vector<wavefront::Renderer::ColorLut> luts;
  const auto add = [&](const char* sampler, uint32_t dimension, uint32_t width, uint32_t height, uint32_t depth,
                       uint32_t components, ocio::Interpolation interpolation, const float* values) {
    const size_t count = size_t{width} * height * depth * components;
    luts.push_back({sampler, dimension, width, height, depth, components, interpolation != ocio::INTERP_NEAREST,
                    std::vector<float>(values, values + count), 0});
  };
  const char *texture = nullptr, *sampler = nullptr;
  const float* values = nullptr;
  ocio::Interpolation interpolation{};
  for (unsigned i = 0; i < description.getNumTextures(); ++i) {
    unsigned width = 0, height = 0;
    ocio::GpuShaderDesc::TextureType channels{};
    ocio::GpuShaderDesc::TextureDimensions dimensions{};
    description.getTexture(i, texture, sampler, width, height, channels, dimensions, interpolation);
    description.getTextureValues(i, values);
    const uint32_t components = channels == ocio::GpuShaderDesc::TEXTURE_RED_CHANNEL ? 1 : 3;
    add(sampler, dimensions == ocio::GpuShaderDesc::TEXTURE_1D ? 1 : 2, width, height, 1, components, interpolation,
        values);
  }
  for (unsigned i = 0; i < description.getNum3DTextures(); ++i) {
    unsigned edge = 0;
    description.get3DTexture(i, texture, sampler, edge, interpolation);
    description.get3DTextureValues(i, values);
    add(sampler, 3, edge, edge, edge, 3, interpolation, values);
  }
  return luts;
}

#if OCIO_VERSION_HEX >= 0x02050000
constexpr ocio::GpuLanguage kLanguage = ocio::GPU_LANGUAGE_GLSL_VK_4_6;
wavefront::Status BindSamplers(delegate::ColorShader&) { return {}; }
#else
// Before 2.5 the library writes no Vulkan GLSL: OpenGL's differs in the samplers, which say no binding.
constexpr ocio::GpuLanguage kLanguage = ocio::GPU_LANGUAGE_GLSL_4_0;
wavefront::Status BindSamplers(delegate::ColorShader& shader) {
  uint32_t binding = 1;
  for (const auto& lut : shader.luts) {
    const std::string declaration =
        "uniform sampler" + std::to_string(lut.dimension) + "D " + lut.sampler + ";";
    const size_t at = shader.glsl.find(declaration);
    if (at == std::string::npos) return Error{"OpenColorIO's shader declares no sampler \"" + lut.sampler + "\"."};
    shader.glsl.insert(at, "layout(set = 0, binding = " + std::to_string(binding++) + ") ");
  }
  return {};
}
#endif

}  // namespace

Result<delegate::ColorShader> MakeColorShader(const ColorSettings& settings) {
  const auto config = Load(settings.config);
  if (!config) return config.error();
  try {
    const auto processor = MakeProcessor(config.value(), settings);
    if (!processor) return processor.error();
    delegate::ColorShader shader;
    shader.function = "hdwavefrontColor";
    ocio::GpuShaderDescRcPtr description = ocio::GpuShaderDesc::CreateShaderDesc();
    description->setLanguage(kLanguage);
    description->setFunctionName(shader.function.c_str());
    processor.value()->getDefaultGPUProcessor()->extractGpuShaderInfo(description);
    shader.glsl = description->getShaderText();
    shader.luts = ReadLuts(*description);
    if (const wavefront::Status bound = BindSamplers(shader); !bound) return bound.error();
    return shader;
  } catch (const std::exception& error) {
    return Error{std::string("OpenColorIO: ") + error.what()};
  }
}

}  // namespace hydra

#else

namespace hydra {

wavefront::Result<delegate::ColorShader> MakeColorShader(const ColorSettings&) {
  return wavefront::Error{"This plugin was built without OpenColorIO: wavefront:ocio does nothing."};
}

}  // namespace hydra

#endif
