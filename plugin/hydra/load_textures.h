// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Answers the requests for images of a core. Each file is decoded once for all that ask for it in a commit: colour
// spaces, patterns whose tile it is, plain paths. In parallel; a file's pixels go when what is made of them has been
// handed over.
#pragma once

#include <functional>
#include <string>

#include "delegate/render_delegate.h"
#include "plugin/hydra/texture_loader.h"

namespace hydra {

using TextureDecoder = std::function<wavefront::Result<TextureConverter>(const std::string& path)>;
using TextureReport = std::function<void(wavefront::Severity severity, const char* code, const std::string& location,
                                         const std::string& message)>;

// Every request is answered, by texels or by why there are none. Both functions are called from several threads.
void LoadTextures(delegate::RenderDelegate& core, const TextureDecoder& decode, const TextureReport& report);

}  // namespace hydra
