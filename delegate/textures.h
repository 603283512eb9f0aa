// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Images that materials and lights ask for. Each colour space that converts its values makes an image of its own of a
// file; the core holds it as long as it is asked for.
//
// The host is given the requests of a commit at once and decodes each file once for all that are made of it: for
// several colour spaces, for patterns whose tiles it is, and for plain paths. A request that comes in a later commit
// decodes its file again: nobody keeps decoded pixels. Sharing a decode raises no peak: what is made of the files of a
// commit stands staged in the core until the commit, however often they are decoded, beside the pixels of the few files
// that are being decoded (a strip of each in the Python host). The setting textureMemory bounds what textures take on
// the device, not what is staged.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "wavefront/base/diagnostics.h"
#include "wavefront/renderer.h"

namespace delegate {

// What makes two requests the same image.
struct TextureKey {
  std::string resolvedPath;  // empty: the host's resolver found nothing; then authoredPath tells them apart
  std::string authoredPath;  // only where resolvedPath is empty
  // "raw": numbers as they are; "sRGB", or another colour space's name; empty ("auto" of whom acquires): the file decides.
  std::string colorSpace;
  bool isColor = true;       // false: data, never colour-managed
  auto operator<=>(const TextureKey&) const = default;
};

struct TextureLoadRequest {
  uint32_t key = 0;          // names the image in SetTexture and SetTextureMissing; never reused
  TextureKey texture;
  std::string authoredPath;
  std::string location;      // node or light that asked first, by path
};

// Thread-safe. Users (materials, lights) acquire and release by key; an image nobody uses any more is given back to the
// core at the next Collect.
class TextureTable {
 public:
  // Both must outlive the table.
  TextureTable(wavefront::Renderer& renderer, wavefront::DiagnosticSink sink);

  // Colour spaces from which the host converts nothing, whatever the case of their letters: "raw", and the names of the
  // rendering space. Images that are asked for in any of them, or as data, are one. To be set before the first Acquire.
  void SetUnconvertedSpaces(const std::vector<std::string>& names);
  // One more user, named for diagnostics. Returns the key; the image is pending until the host answers.
  uint32_t Acquire(const TextureKey& asked, const std::string& authoredPath, const std::string& location);
  void Release(uint32_t key);

  // Used, and neither loaded nor missing, or to be loaded again; sorted by texture key: those of a file stand together.
  // Images without a resolved path are never pending: they are missing, and their diagnostic is given when they are
  // acquired.
  std::vector<TextureLoadRequest> Pending() const;
  // What the core read coarser than it need be with this much memory becomes pending again, and stays as it is until it
  // comes.
  void ReloadCoarse(uint64_t textureMemory);
  // An error where the key is unknown or the data do not fit their size. A second image replaces the first.
  wavefront::Status Set(uint32_t key, wavefront::TextureData data);
  // The same for a file pattern with <UDIM> or <UVTILE>: tiles by UDIM number, 1001 to 9999.
  wavefront::Status SetTiles(uint32_t key, std::vector<std::pair<uint32_t, wavefront::TextureData>> tiles);
  wavefront::Status SetMissing(uint32_t key, const std::string& reason);

  wavefront::TextureId Id(uint32_t key) const;  // kInvalidId: not loaded or missing
  uint64_t version() const;                     // grows when an Id changes
  uint64_t uploads() const;
  void Collect();

 private:
  struct Entry {
    TextureLoadRequest request;
    uint32_t users = 0;
    wavefront::TextureId id = wavefront::kInvalidId;
    std::vector<wavefront::TextureId> tiles;  // of a set
    bool missing = false, reload = false;
    std::string reason;
  };
  TextureKey Unified(TextureKey texture) const;
  void Drop(Entry& entry);  // what the core holds of it
  void ReportMissing(const Entry& entry, const std::string& location) const;

  mutable std::mutex mutex_;
  wavefront::Renderer& renderer_;
  wavefront::DiagnosticSink sink_;
  std::set<std::string> unconverted_{"raw"};  // small letters
  std::map<TextureKey, uint32_t> keys_;
  std::map<uint32_t, Entry> entries_;
  uint32_t nextKey_ = 1;
  uint64_t version_ = 0, uploads_ = 0;
};

}  // namespace delegate
