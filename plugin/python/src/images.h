// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <nanobind/nanobind.h>

#include <string>
#include <vector>

#include "wavefront/renderer.h"

// A numpy array that owns the image: (height, width, components), float32 or int32 by the AOV's format.
nanobind::object ImageToArray(wavefront::AovImage image);

// A numpy array that owns the values.
template <typename T>
nanobind::object VectorToArray(std::vector<T> values, std::vector<size_t> shape);

wavefront::TextureData ReadTexture(nanobind::handle pixels, bool bottomUp);
