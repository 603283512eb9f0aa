// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scene files: a header, then a chunk for each part of a scene, each with its length and checksum.
//
//   bytes 0..7    "HDWSCENE"
//   8..11         kSceneFileVersion
//   12..15        number of chunks
//   16..23        length of the whole file
//   24..31        signature of the fields (captured_fields.def and their types)
//   32..39        checksum of bytes 0..31
//   then for each chunk: name (8 bytes, zeros follow), length of its bytes (8), checksum of name, length and bytes (8), bytes
//
// Chunks stand in the order of CapturedScene. Numbers are little endian.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "delegate/capture/captured_scene.h"

namespace delegate {

constexpr uint32_t kSceneFileVersion = 1;

std::vector<std::byte> EncodeScene(const CapturedScene& scene);
// Errors name `file` and, where there is one, the chunk. What is returned passes CheckScene.
wavefront::Result<CapturedScene> DecodeScene(std::span<const std::byte> bytes, const std::string& file);

// Written beside and renamed: a file of that name is whole, or what it was before.
wavefront::Status WriteSceneFile(const CapturedScene& scene, const std::string& path);
wavefront::Result<CapturedScene> ReadSceneFile(const std::string& path);

// Of a file's bytes: any changed byte changes it.
uint64_t Checksum(std::span<const std::byte> bytes, uint64_t start = 0xcbf29ce484222325ull);

}  // namespace delegate
