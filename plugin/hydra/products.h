// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render products: the files that a RenderSettings prim asks for.
#pragma once

#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <pxr/imaging/hd/renderSettings.h>

#include "delegate/render_delegate.h"
#include "plugin/hydra/convert_camera.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

// What a product looks at.
struct ProductView {
  std::string camera;             // empty: the host's
  PassFraming framing;            // without pixels where the product says no resolution: the host's
  delegate::ConformPolicy policy = delegate::ConformPolicy::Fit;
  bool depthOfField = true;
  bool operator==(const ProductView&) const = default;
};

struct Product {
  SdfPath path;
  std::string name;               // the file
  std::vector<std::string> aovs;  // tokens, in the order of the product's vars
  ProductView view;
  uint32_t fullWidth = 0, fullHeight = 0;  // of the display window
};

// Products that look at the same: one render.
struct Shot {
  ProductView view;
  std::vector<Product> products;
};

// Messages are (path, code, text).
struct ConvertedProducts {
  std::vector<Product> products;
  std::vector<std::tuple<SdfPath, const char*, std::string>> messages;
};
ConvertedProducts ToProducts(const HdRenderSettings::RenderProducts& products);

// The first product's comes last: its picture is the one that stays in the host's buffers.
std::vector<Shot> ToShots(const std::vector<Product>& products);

// Writes what the core holds now as an EXR, a layer per AOV. The folder must exist; a half-written file is never seen.
wavefront::Status WriteProduct(delegate::RenderDelegate& core, const Product& product);

}  // namespace hydra
