// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/products.h"

#include <pxr/base/tf/pathUtils.h>
#include <pxr/base/tf/stringUtils.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "plugin/hydra/exr_writer.h"

namespace hydra {
namespace {

// The channels of an AOV's layer, as `hdwavefront record` writes them.
std::vector<std::string> ChannelsOf(const std::string& token, uint32_t components, bool isInt) {
  if (token == "color") return {"R", "G", "B", "A"};
  if (token == "sampleCount") return {token + ".samples"};
  if (components == 1) return {token + (isInt ? ".id" : ".Z")};
  const std::string names = token == "albedo" ? "RGB" : "XYZW";
  std::vector<std::string> channels;
  for (uint32_t c = 0; c < components; ++c) channels.push_back(token + "." + names[c]);
  return channels;
}

delegate::ConformPolicy ToPolicy(const TfToken& token) {
  return delegate::ParseConformPolicy(token.GetString()).value_or(delegate::ConformPolicy::Fit);
}

PassFraming ToFraming(const HdRenderSettings::RenderProduct& product) {
  PassFraming framing;
  const GfRange2f& window = product.dataWindowNDC;
  if (!window.IsEmpty() && window.GetSize()[0] > 0 && window.GetSize()[1] > 0)
    framing.part = {window.GetMin()[0], window.GetMax()[0], window.GetMin()[1], window.GetMax()[1]};
  const auto pixels = [](int full, double part) {
    return static_cast<uint32_t>(std::max(0.0, std::round(std::max(full, 0) * part)));
  };
  framing.width = pixels(product.resolution[0], framing.part.right - framing.part.left);
  framing.height = pixels(product.resolution[1], framing.part.top - framing.part.bottom);
  if (product.pixelAspectRatio > 0) framing.pixelAspectRatio = product.pixelAspectRatio;
  return framing;
}

}  // namespace

std::string ToAovToken(const std::string& sourceName, const TfToken& sourceType) {
  static const std::map<std::string, std::string> names{
      {"ci", "color"},           {"rgba", "color"}, {"rgb", "color"},         {"beauty", "color"},
      {"lpe:c.*[lo]", "color"},  {"z", "cameraDepth"}, {"cameradepth", "cameraDepth"}, {"n", "normal"},
      {"neye", "Neye"},          {"primid", "primId"}, {"instanceid", "instanceId"},
      {"elementid", "elementId"}, {"samplecount", "sampleCount"}};
  const std::string prefix(wavefront::kPrimvarPrefix);
  if (TfStringStartsWith(sourceName, prefix)) return sourceName.size() > prefix.size() ? sourceName : std::string();
  if (sourceType == TfToken("primvar")) return sourceName.empty() ? sourceName : prefix + sourceName;
  std::string name = TfStringToLower(TfStringReplace(sourceName, " ", ""));
  const auto alias = names.find(name);
  if (alias != names.end()) return alias->second;
  return wavefront::FindAov(name) ? name : std::string();
}

ConvertedProducts ToProducts(const HdRenderSettings::RenderProducts& products) {
  ConvertedProducts result;
  for (const HdRenderSettings::RenderProduct& source : products) {
    const auto warn = [&](const char* code, const std::string& text) {
      result.messages.emplace_back(source.productPath, code, text);
    };
    if (source.type != TfToken("raster")) {
      warn("render-product-type",
           "products of type '" + source.type.GetString() + "' are not supported; it is ignored");
      continue;
    }
    Product product;
    product.path = source.productPath;
    product.name = source.name.GetString();
    product.camera = source.cameraPath.GetString();
    product.framing = ToFraming(source);
    product.policy = ToPolicy(source.aspectRatioConformPolicy);
    for (const auto& var : source.renderVars) {
      const std::string token = ToAovToken(var.sourceName, var.sourceType);
      if (token.empty())
        warn("render-var-unsupported",
             "the render var '" + var.sourceName + "' names no AOV of this renderer; it is left out");
      else if (std::find(product.aovs.begin(), product.aovs.end(), token) == product.aovs.end())
        product.aovs.push_back(token);
    }
    if (product.name.empty()) warn("render-product-name", "the product has no productName; it is ignored");
    else if (TfStringToLower(TfGetExtension(product.name)) != "exr")
      warn("render-product-format", "products are written as .exr; " + product.name + " is not written");
    else if (product.aovs.empty())
      warn("render-product-empty", "the product has no var that can be rendered; it is ignored");
    else result.products.push_back(std::move(product));
  }
  for (size_t i = 1; i < result.products.size(); ++i) {
    const Product &first = result.products.front(), &other = result.products[i];
    if (!(other.framing == first.framing) || other.camera != first.camera || other.policy != first.policy)
      result.messages.emplace_back(other.path, "render-product-override",
                                   "a product's own camera, resolution or window is not supported; the first's counts");
  }
  return result;
}

wavefront::Status WriteProduct(delegate::RenderDelegate& core, const Product& product) {
  ExrImage exr;
  for (const std::string& token : product.aovs) {
    const auto aov = core.FindAov(token);
    if (!aov) continue;  // told of when it was asked for
    auto image = core.Map(*aov);
    if (!image) return image.error();
    const bool isInt = wavefront::Aovs()[static_cast<size_t>(*aov)].format == wavefront::AovFormat::Int32;
    exr.width = image->width;
    exr.height = image->height;
    const auto names = ChannelsOf(token, image->components, isInt);
    const size_t pixels = size_t{image->width} * image->height;
    for (uint32_t c = 0; c < image->components; ++c) {
      std::vector<float> values(pixels);
      for (size_t i = 0; i < pixels; ++i) {
        const uint32_t bits = image->bits[i * image->components + c];
        values[i] = isInt ? static_cast<float>(static_cast<int32_t>(bits)) : std::bit_cast<float>(bits);
      }
      exr.channels.emplace_back(names[c], std::move(values));
    }
  }
  exr.pixelAspectRatio = static_cast<float>(product.framing.pixelAspectRatio);
  exr.text.emplace_back("software", "hdWavefront");
  exr.text.emplace_back("hdwavefront:camera", product.camera);
  const delegate::CameraMatrices matrices = core.cameraMatrices();
  exr.matrices.emplace_back("worldToCamera", matrices.worldToCamera);
  exr.matrices.emplace_back("worldToNDC", matrices.worldToNdc);
  return WriteExr(product.name, std::move(exr));
}

}  // namespace hydra
