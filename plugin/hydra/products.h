// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render products: the files that a RenderSettings prim asks for.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <pxr/imaging/hd/renderSettings.h>

#include "delegate/render_delegate.h"
#include "plugin/hydra/convert_camera.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

struct Product {
  SdfPath path;
  std::string name;               // the file
  std::vector<std::string> aovs;  // tokens, in the order of the product's vars
  std::string camera;
  PassFraming framing;            // without pixels where the product says no resolution
  delegate::ConformPolicy policy = delegate::ConformPolicy::Fit;
};

// The AOV that a render var asks for, by the names of other renderers and of USD's documentation too; empty: none.
std::string ToAovToken(const std::string& sourceName, const TfToken& sourceType);

// The first product frames all; messages are (path, code, text).
struct ConvertedProducts {
  std::vector<Product> products;
  std::vector<std::tuple<SdfPath, const char*, std::string>> messages;
};
ConvertedProducts ToProducts(const HdRenderSettings::RenderProducts& products);

// Writes what the core holds now as an EXR, a layer per AOV. The folder must exist; a half-written file is never seen.
wavefront::Status WriteProduct(delegate::RenderDelegate& core, const Product& product);

}  // namespace hydra
