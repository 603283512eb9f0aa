// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Decodes the images that materials and lights ask for, through OpenUSD's Hio.
#pragma once

#include <string>
#include <vector>

#include "delegate/textures.h"
#include "plugin/hydra/hd_compat.h"
#include "wavefront/base/result.h"

namespace hydra {

// Any thread. An error says in one sentence why the image cannot be used.
wavefront::Result<wavefront::TextureData> LoadTexture(const delegate::TextureKey& texture);

// A relative pattern of tiles that the host did not anchor to the layer that authors it, beside each layer that is loaded where
// tiles of it lie: one is the answer, several are a doubt. Sorted, each once.
std::vector<std::string> AnchoredPatterns(const std::string& pattern);

// Colour spaces whose values LoadTexture takes as they are.
std::vector<std::string> UnconvertedSpaces();

}  // namespace hydra
