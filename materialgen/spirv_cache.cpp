// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/spirv_cache.h"

#include <spirv-tools/libspirv.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "materialgen/embedded_glsl.h"

namespace materialgen {
namespace {

namespace fs = std::filesystem;

// An entry: header, name of what it was made of, words.
struct Header {
  char magic[8];
  uint64_t checksum;  // of the words
  uint64_t words;
  char name[32];  // the hash that the file is called by
};
constexpr char kMagic[8] = {'h', 'd', 'W', 'S', 'p', 'v', '0', '1'};
constexpr uint64_t kMaximumWords = 64ull << 20;
// A file that a process which was cut off left behind is not touched before it is this old: it may be in the making.
constexpr auto kPartAge = std::chrono::hours(1);

uint64_t Checksum(const std::vector<uint32_t>& words) {  // FNV-1a
  uint64_t hash = 0xcbf29ce484222325ull;
  for (uint32_t word : words) hash = (hash ^ word) * 0x100000001b3ull;
  return hash;
}

// Everything but the source that the SPIR-V depends on.
const std::string& Version() {
  static const std::string version =
      std::string(GeneratorVersion()) + "\nglslang " HDWAVEFRONT_GLSLANG_VERSION "\n" + spvSoftwareVersionString() +
      "\n" HDWAVEFRONT_SPIRV_PASSES "\n" +
      HashOf(EmbeddedGlslText());
  return version;
}

}  // namespace

// Two 64-bit FNV-1a hashes with different offsets; 128 bits make a collision a matter for astronomers.
std::string HashOf(std::string_view text) {
  uint64_t a = 0xcbf29ce484222325ull, b = 0x9ae16a3b2f90404full;
  for (unsigned char c : text) {
    a = (a ^ c) * 0x100000001b3ull;
    b = (b ^ c) * 0x100000001b3ull + 0x632be59bd9b4e019ull;
  }
  char buffer[33];
  std::snprintf(buffer, sizeof(buffer), "%016llx%016llx", static_cast<unsigned long long>(a),
                static_cast<unsigned long long>(b));
  return buffer;
}

SpirvCache::SpirvCache(std::string folder, uint64_t maximumBytes)
    : folder_(std::move(folder)), maximumBytes_(maximumBytes) {}

std::string CacheFolder() {
  const auto environment = [](const char* name) {
    const char* text = std::getenv(name);
    return std::string(text != nullptr ? text : "");
  };
  const std::string own = environment("HDWAVEFRONT_CACHE_DIR");
  if (own == "off") return {};
  if (!own.empty()) return own;
  const std::string xdg = environment("XDG_CACHE_HOME"), home = environment("HOME");
  if (!xdg.empty()) return xdg + "/hdwavefront";
  return home.empty() ? std::string() : home + "/.cache/hdwavefront";
}

std::string SpirvCache::DefaultFolder() {
  const std::string folder = CacheFolder();
  return folder.empty() ? folder : folder + "/spirv";
}

std::string SpirvCache::FileOf(std::string_view source) const {
  return HashOf(Version() + "\n" + std::string(source));
}

std::optional<std::vector<uint32_t>> SpirvCache::Load(std::string_view source) {
  if (folder_.empty()) return std::nullopt;
  const std::string name = FileOf(source);
  const fs::path path = fs::path(folder_) / name;
  const auto read = [&]() -> std::optional<std::vector<uint32_t>> {
    std::ifstream file(path, std::ios::binary);
    Header header{};
    if (!file.read(reinterpret_cast<char*>(&header), sizeof(header))) return std::nullopt;
    if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0 || header.words == 0 || header.words > kMaximumWords ||
        std::memcmp(header.name, name.data(), sizeof(header.name)) != 0)
      return std::nullopt;
    std::error_code error;
    if (fs::file_size(path, error) != sizeof(header) + header.words * 4 || error) return std::nullopt;
    std::vector<uint32_t> words(header.words);
    if (!file.read(reinterpret_cast<char*>(words.data()), std::streamsize(words.size() * 4))) return std::nullopt;
    if (Checksum(words) != header.checksum) return std::nullopt;
    return words;
  };
  auto words = read();
  if (words) {
    std::error_code ignored;  // a folder that may only be read
    fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
  }
  const std::lock_guard lock(mutex_);
  ++(words ? hits_ : misses_);
  return words;
}

void SpirvCache::Store(std::string_view source, const std::vector<uint32_t>& spirv) {
  if (folder_.empty() || spirv.empty()) return;
  const std::string name = FileOf(source);
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) return Trouble("the folder " + folder_ + " cannot be made: " + error.message());
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  std::memcpy(header.name, name.data(), sizeof(header.name));
  header.checksum = Checksum(spirv);
  header.words = spirv.size();
  // Written beside and renamed: whoever reads sees all of it or nothing. mkstemp's name is nobody else's.
  std::string part = (fs::path(folder_) / (name + ".part-XXXXXX")).string();
  const int descriptor = mkstemp(part.data());
  if (descriptor < 0) return Trouble("nothing can be written to " + folder_ + ": " + std::strerror(errno));
  std::FILE* file = fdopen(descriptor, "wb");
  const bool isWritten = std::fwrite(&header, sizeof(header), 1, file) == 1 &&
                         std::fwrite(spirv.data(), 4, spirv.size(), file) == spirv.size();
  const bool isClosed = std::fclose(file) == 0;  // a full disk may say so only now
  if (isWritten && isClosed) fs::rename(part, fs::path(folder_) / name, error);
  if (!isWritten || !isClosed || error) {
    const std::string reason = error ? error.message() : std::strerror(errno);
    std::error_code ignored;
    fs::remove(part, ignored);
    return Trouble("an entry cannot be written to " + folder_ + ": " + reason);
  }
  bool isTimeToCount;
  {
    const std::lock_guard lock(mutex_);
    writtenSinceCount_ += sizeof(header) + spirv.size() * 4;
    // Counting reads the whole folder: at the first write, and then after each sixteenth part of what it may hold.
    isTimeToCount = !counted_ || writtenSinceCount_ > maximumBytes_ / 16;
    if (isTimeToCount) writtenSinceCount_ = 0;
    counted_ = true;
  }
  if (isTimeToCount) Evict();
}

void SpirvCache::Evict() {
  struct Entry {
    fs::file_time_type used;
    uint64_t bytes;
    fs::path path;
  };
  std::vector<Entry> entries;
  uint64_t total = 0;
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;  // another process may evict as well
    const auto used = at->last_write_time(gone);
    const uint64_t bytes = gone ? 0 : at->file_size(gone);
    if (gone) continue;
    if (at->path().filename().string().find(".part-") != std::string::npos) {
      if (now - used > kPartAge) fs::remove(at->path(), gone);
      continue;
    }
    entries.push_back({used, bytes, at->path()});
    total += bytes;
  }
  if (total <= maximumBytes_) return;
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : entries) {
    if (total <= maximumBytes_ / 8 * 7) break;  // room for the next ones
    std::error_code gone;
    fs::remove(entry.path, gone);
    total -= entry.bytes;
  }
}

void SpirvCache::Trouble(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (trouble_.empty()) trouble_ = text;
}

std::string SpirvCache::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}
uint64_t SpirvCache::hits() const {
  const std::lock_guard lock(mutex_);
  return hits_;
}
uint64_t SpirvCache::misses() const {
  const std::lock_guard lock(mutex_);
  return misses_;
}

}  // namespace materialgen
