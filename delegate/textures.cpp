// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/textures.h"

#include <algorithm>
#include <cctype>

#include "delegate/photometric_profile.h"
#include "wavefront/base/check.h"

namespace delegate {
namespace {

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

TextureTable::TextureTable(wavefront::Renderer& renderer, wavefront::DiagnosticSink sink)
    : renderer_(renderer), sink_(std::move(sink)) {}

void TextureTable::ReportMissing(const Entry& entry, const std::string& location) const {
  const std::string& file =
      entry.request.texture.resolvedPath.empty() ? entry.request.authoredPath : entry.request.texture.resolvedPath;
  sink_({wavefront::Severity::Warning, "texture-missing", location,
         "The texture \"" + file + "\" cannot be used: " + entry.reason + " The fallback value is shown."});
}

void TextureTable::SetUnconvertedSpaces(const std::vector<std::string>& names) {
  std::lock_guard lock(mutex_);
  unconverted_ = {"raw"};
  for (const std::string& name : names) unconverted_.insert(Lower(name));
}

// One key for all that give the same texels whatever is in the file.
TextureKey TextureTable::Unified(TextureKey texture) const {
  const std::string space = Lower(texture.colorSpace);
  if (!texture.isColor || IsPhotometricProfile(texture.resolvedPath) || unconverted_.count(space)) {
    texture.colorSpace = "raw";
    texture.isColor = false;
  } else if (space == "auto") {
    texture.colorSpace.clear();
  }
  return texture;
}

uint32_t TextureTable::Acquire(const TextureKey& asked, const std::string& authoredPath, const std::string& location) {
  std::unique_lock lock(mutex_);
  const TextureKey texture = Unified(asked);
  auto [known, isNew] = keys_.try_emplace(texture, nextKey_);
  if (isNew) {
    Entry& entry = entries_[nextKey_];
    entry.request = {nextKey_, texture, authoredPath, location};
    if (texture.resolvedPath.empty()) {
      entry.missing = true;
      entry.reason = authoredPath.empty() ? "no file is named." : "the file was not found.";
    }
    ++nextKey_;
  }
  Entry& entry = entries_.at(known->second);
  ++entry.users;
  const uint32_t key = known->second;
  if (entry.missing) {
    const Entry copy = entry;
    lock.unlock();
    ReportMissing(copy, location);
  }
  return key;
}

void TextureTable::Release(uint32_t key) {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  WAVEFRONT_CHECK(found != entries_.end() && found->second.users > 0, "texture %u is not in use", key);
  --found->second.users;
}

std::vector<TextureLoadRequest> TextureTable::Pending() const {
  std::lock_guard lock(mutex_);
  std::vector<TextureLoadRequest> pending;
  for (const auto& [texture, key] : keys_) {
    const Entry& entry = entries_.at(key);
    if (entry.users > 0 && !entry.missing && (entry.id == wavefront::kInvalidId || entry.reload))
      pending.push_back(entry.request);
  }
  return pending;
}

void TextureTable::ReloadCoarse(uint64_t textureMemory) {
  std::lock_guard lock(mutex_);
  const std::vector<wavefront::TextureId> ids = renderer_.CoarseTextures(textureMemory);
  const std::set<wavefront::TextureId> coarse(ids.begin(), ids.end());
  const auto isCoarse = [&](wavefront::TextureId id) { return coarse.count(id) != 0; };
  for (auto& [key, entry] : entries_)
    entry.reload = isCoarse(entry.id) || std::any_of(entry.tiles.begin(), entry.tiles.end(), isCoarse);
}

namespace {
wavefront::Status Check(uint32_t key, const wavefront::TextureData& data) {
  const wavefront::TexelFormat format = data.format;
  const size_t texelBytes = format == wavefront::TexelFormat::Rgba8Unorm ? 4 : format == wavefront::TexelFormat::Rgba32Float ? 16 : 8;
  if (data.width == 0 || data.height == 0 || data.texels.size() != size_t{data.width} * data.height * texelBytes)
    return wavefront::Error{"Texture " + std::to_string(key) + " has " + std::to_string(data.texels.size()) +
                            " bytes, which is not what " + std::to_string(data.width) + " x " +
                            std::to_string(data.height) + " texels need."};
  return {};
}
}  // namespace

void TextureTable::Drop(Entry& entry) {
  if (entry.id != wavefront::kInvalidId) renderer_.DestroyTexture(entry.id);
  for (wavefront::TextureId tile : entry.tiles) renderer_.DestroyTexture(tile);
  entry.id = wavefront::kInvalidId;
  entry.tiles.clear();
}

wavefront::Status TextureTable::SetTiles(uint32_t key,
                                         std::vector<std::pair<uint32_t, wavefront::TextureData>> tiles) {
  for (const auto& [udim, data] : tiles) {
    if (udim < 1001 || udim > 9999) return wavefront::Error{"There is no tile " + std::to_string(udim) + "."};
    if (wavefront::Status status = Check(key, data); !status) return status;
  }
  if (tiles.empty()) return wavefront::Error{"Texture " + std::to_string(key) + " has no tiles."};
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return wavefront::Error{"Texture " + std::to_string(key) + " was not asked for."};
  Entry& entry = found->second;
  Drop(entry);
  std::vector<wavefront::TextureTile> set;
  for (auto& [udim, data] : tiles) {
    if (data.name.empty()) data.name = entry.request.texture.resolvedPath + " (" + std::to_string(udim) + ")";
    entry.tiles.push_back(renderer_.CreateTexture(std::move(data)));
    set.push_back({udim, entry.tiles.back()});
  }
  entry.id = renderer_.CreateTextureTiles(std::move(set));
  entry.missing = entry.reload = false;
  ++version_;
  uploads_ += tiles.size();
  return {};
}

wavefront::Status TextureTable::Set(uint32_t key, wavefront::TextureData data) {
  if (wavefront::Status status = Check(key, data); !status) return status;
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return wavefront::Error{"Texture " + std::to_string(key) + " was not asked for."};
  Entry& entry = found->second;
  if (data.name.empty()) data.name = entry.request.texture.resolvedPath;
  Drop(entry);
  entry.id = renderer_.CreateTexture(std::move(data));
  entry.missing = entry.reload = false;
  ++version_;
  ++uploads_;
  return {};
}

wavefront::Status TextureTable::SetMissing(uint32_t key, const std::string& reason) {
  Entry copy;
  {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end()) return wavefront::Error{"Texture " + std::to_string(key) + " was not asked for."};
    Entry& entry = found->second;
    if (entry.id != wavefront::kInvalidId) {
      Drop(entry);
      ++version_;
    }
    entry.missing = true;
    entry.reload = false;
    entry.reason = reason.empty() ? "it could not be read." : reason;
    copy = entry;
  }
  ReportMissing(copy, copy.request.location);
  return {};
}

wavefront::TextureId TextureTable::Id(uint32_t key) const {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  WAVEFRONT_CHECK(found != entries_.end(), "texture %u is not known", key);
  return found->second.id;
}

uint64_t TextureTable::version() const {
  std::lock_guard lock(mutex_);
  return version_;
}

uint64_t TextureTable::uploads() const {
  std::lock_guard lock(mutex_);
  return uploads_;
}

void TextureTable::Collect() {
  std::lock_guard lock(mutex_);
  for (auto i = entries_.begin(); i != entries_.end();) {
    if (i->second.users > 0) {
      ++i;
      continue;
    }
    Drop(i->second);
    keys_.erase(i->second.request.texture);
    i = entries_.erase(i);
  }
}

}  // namespace delegate
