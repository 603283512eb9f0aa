// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/products.h"

#include <pxr/base/tf/pathUtils.h>
#include <pxr/base/tf/stringUtils.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "delegate/render_vars.h"
#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/exr_writer.h"

namespace hydra {
namespace {

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
  framing.x = static_cast<int>(std::round(framing.part.left * std::max(product.resolution[0], 0)));
  framing.y = static_cast<int>(std::round((1 - framing.part.top) * std::max(product.resolution[1], 0)));
  if (product.pixelAspectRatio > 0) framing.pixelAspectRatio = product.pixelAspectRatio;
  return framing;
}

}  // namespace

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
    product.view.camera = source.cameraPath.GetString();
    product.view.framing = ToFraming(source);
    product.view.policy = ToPolicy(source.aspectRatioConformPolicy);
    product.view.depthOfField = !source.disableDepthOfField;
    product.fullWidth = static_cast<uint32_t>(std::max(source.resolution[0], 0));
    product.fullHeight = static_cast<uint32_t>(std::max(source.resolution[1], 0));
    for (const auto& [name, value] : source.namespacedSettings)
      if (IsOwnSetting(TfToken(name)))
        warn("render-product-setting", "a product's own " + name + " is not supported; the RenderSettings prim's counts");
    for (const auto& var : source.renderVars) {
      const std::string token = delegate::AovTokenOfVar(var.sourceName, var.sourceType.GetString());
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
  return result;
}

std::vector<Shot> ToShots(const std::vector<Product>& products) {
  std::vector<Shot> shots;
  for (const Product& product : products) {
    auto shot = std::find_if(shots.begin(), shots.end(), [&](const Shot& s) { return s.view == product.view; });
    if (shot == shots.end()) shot = shots.insert(shots.end(), Shot{product.view, {}});
    shot->products.push_back(product);
  }
  std::reverse(shots.begin(), shots.end());
  return shots;
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
    const auto names = delegate::AovChannels(token);
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
  if (product.fullWidth > 0 && product.fullHeight > 0) {
    exr.x = product.view.framing.x;
    exr.y = product.view.framing.y;
    exr.fullWidth = product.fullWidth;
    exr.fullHeight = product.fullHeight;
  }
  exr.pixelAspectRatio = static_cast<float>(product.view.framing.pixelAspectRatio);
  exr.text.emplace_back("software", "hdWavefront");
  exr.text.emplace_back("hdwavefront:camera", product.view.camera);
  const delegate::CameraMatrices matrices = core.cameraMatrices();
  exr.matrices.emplace_back("worldToCamera", matrices.worldToCamera);
  exr.matrices.emplace_back("worldToNDC", matrices.worldToNdc);
  return WriteExr(product.name, std::move(exr));
}

}  // namespace hydra
