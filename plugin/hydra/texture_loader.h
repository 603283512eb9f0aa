// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Decodes images through OpenUSD's Hio.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "delegate/textures.h"
#include "plugin/hydra/hd_compat.h"
#include "wavefront/base/result.h"

namespace hydra {

// The texels that a conversion makes of a decoded file. It holds the file's pixels; any thread.
using TextureConverter = std::function<wavefront::Result<wavefront::TextureData>(const delegate::TextureKey&)>;

// Decodes the file, once for all conversions. Any thread. Errors, here and of the converter, say in one sentence why
// the image cannot be used.
wavefront::Result<TextureConverter> DecodeTexture(const std::string& path);

// A relative pattern of tiles that the host did not anchor to the layer that authors it, beside each layer that is loaded where
// tiles of it lie: one is the answer, several are a doubt. Sorted, each once.
std::vector<std::string> AnchoredPatterns(const std::string& pattern);

// Colour spaces whose values are taken as they are.
std::vector<std::string> UnconvertedSpaces();

}  // namespace hydra
