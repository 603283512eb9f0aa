// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Measurements as text and as JSON, and pictures as files.
#pragma once

#include <string>
#include <vector>

#include "plugin/bench/measure.h"

namespace bench {

void PrintDevice(const wavefront::DeviceBandwidth& device);
void PrintScene(const SceneResult& scene, const wavefront::DeviceBandwidth& device);
// Of a scene that rays were cast through.
void PrintRays(const SceneResult& scene, const wavefront::DeviceBandwidth& device);
// The scenes of a sweep, a line each.
void PrintSweep(const std::vector<SceneResult>& scenes);

std::string Json(const wavefront::DeviceBandwidth& device, const std::vector<SceneResult>& scenes);
wavefront::Status WriteText(const std::string& text, const std::string& path);
// Colour without alpha as a portable float map (PFM), row 0 at the bottom as that format has it.
wavefront::Status WritePfm(const wavefront::AovImage& color, const std::string& path);

}  // namespace bench
