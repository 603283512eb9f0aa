// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// SPIR-V of generated kernels, kept on disk: a second run compiles no GLSL. Any number of processes may use one folder at
// once, and any of them may be ended at any moment.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace materialgen {

// Of all that is kept for the next run: $HDWAVEFRONT_CACHE_DIR ("off": nothing is kept, empty), else
// $XDG_CACHE_HOME/hdwavefront, else ~/.cache/hdwavefront.
std::string CacheFolder();

// Thread-safe. Trouble with the disk is never an error: an entry that cannot be read is compiled anew, one that cannot be
// written is not kept; `trouble` says so.
class SpirvCache {
 public:
  static constexpr uint64_t kDefaultBytes = 256ull << 20;

  // An empty folder: off. `maximumBytes`: when entries take more, the ones used least recently go.
  explicit SpirvCache(std::string folder, uint64_t maximumBytes = kDefaultBytes);
  // spirv/ in CacheFolder().
  static std::string DefaultFolder();

  const std::string& folder() const { return folder_; }
  // Of a source that CompileGlsl would take. Nothing: not there, damaged, or of another version of anything.
  std::optional<std::vector<uint32_t>> Load(std::string_view source);
  void Store(std::string_view source, const std::vector<uint32_t>& spirv);

  // The first thing that went wrong with the folder; empty: nothing.
  std::string trouble() const;
  uint64_t hits() const;
  uint64_t misses() const;

 private:
  std::string FileOf(std::string_view source) const;
  void Evict();
  void Trouble(const std::string& text);

  std::string folder_;
  uint64_t maximumBytes_;
  mutable std::mutex mutex_;
  std::string trouble_;
  uint64_t hits_ = 0, misses_ = 0;
  uint64_t writtenSinceCount_ = 0;
  bool counted_ = false;
};

// 32 hexadecimal digits.
std::string HashOf(std::string_view text);
// Part of every kernel's key and of every cache entry: raised when the same network yields other source.
std::string_view GeneratorVersion();

}  // namespace materialgen
