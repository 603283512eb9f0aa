// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A hash that tells whether large arrays changed: fast, the same on every machine of one byte order, never stored.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

namespace wavefront {

// 16 bytes a step, each multiplied with what came before it to 128 bits and folded (the scheme of wyhash). Two arrays that
// differ agree by chance once in 2^64.
inline uint64_t HashBytes(std::span<const std::byte> bytes) {
  constexpr uint64_t kFirst = 0xa0761d6478bd642full, kSecond = 0xe7037ed1a0b428dbull;
  const auto fold = [](uint64_t a, uint64_t b) {
    const auto product = static_cast<unsigned __int128>(a) * b;
    return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64);
  };
  const auto word = [&](size_t at) {
    uint64_t value = 0;
    if (at < bytes.size()) std::memcpy(&value, bytes.data() + at, bytes.size() - at < 8 ? bytes.size() - at : 8);
    return value;
  };
  uint64_t hash = fold(bytes.size() ^ kFirst, kSecond);
  for (size_t at = 0; at < bytes.size(); at += 16) hash = fold(word(at) ^ kFirst, word(at + 8) ^ kSecond ^ hash);
  return fold(hash ^ kSecond, kFirst);
}

}  // namespace wavefront
