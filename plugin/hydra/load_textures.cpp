// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/load_textures.h"

#include <pxr/base/tf/pathUtils.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/work/loops.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "delegate/texture_tiles.h"

namespace hydra {
namespace {

// The tiles of a request that have come.
struct Tiles {
  std::vector<std::pair<uint32_t, std::string>> files;
  std::mutex mutex;
  size_t left = 0;
  std::map<uint32_t, wavefront::TextureData> texels;
  std::map<uint32_t, std::string> reasons;
};

// What is made of a file: an image, or a tile of one.
struct Use {
  const delegate::TextureLoadRequest* request = nullptr;
  std::shared_ptr<Tiles> tiles;
  uint32_t number = 0;
};

struct File {
  std::string path;
  std::vector<Use> uses;
};

class Loading {
 public:
  Loading(delegate::RenderDelegate& core, const TextureDecoder& decode, const TextureReport& report)
      : core_(core), decode_(decode), report_(report) {}

  void Add(const delegate::TextureLoadRequest& request);
  void Run();

 private:
  void AddTiles(const delegate::TextureLoadRequest& request);
  void Load(const File& file);
  void TakeTile(const Use& use, wavefront::Result<wavefront::TextureData> texels);
  void HandOver(const delegate::TextureLoadRequest& request, Tiles& tiles);
  void Check(const wavefront::Status& status, const std::string& location) const {
    if (!status) report_(wavefront::Severity::Warning, "texture-failed", location, status.error().message);
  }

  delegate::RenderDelegate& core_;
  const TextureDecoder& decode_;
  const TextureReport& report_;
  std::map<std::string, File> files_;  // paths that lead to one file, by links or ".." inside, are one
};

std::string Identity(const std::string& path) {
  std::error_code error;
  const std::filesystem::path file = std::filesystem::weakly_canonical(path, error);
  return error ? path : file.string();
}

void Loading::Add(const delegate::TextureLoadRequest& request) {
  const std::string& path = request.texture.resolvedPath;
  if (delegate::IsTilePattern(path)) {
    AddTiles(request);
    return;
  }
  File& file = files_.try_emplace(Identity(path), File{path, {}}).first->second;
  file.uses.push_back({&request, nullptr, 0});
}

void Loading::AddTiles(const delegate::TextureLoadRequest& request) {
  // UsdImaging anchors some patterns to the layers that author them, others it hands over as they are authored.
  std::string pattern = request.texture.resolvedPath;
  std::vector<std::string> anchored;
  if (TfIsRelativePath(pattern)) anchored = AnchoredPatterns(pattern);
  if (anchored.size() == 1) {
    report_(wavefront::Severity::Info, "texture-anchored", request.location,
            "This host did not anchor \"" + pattern + "\" to its layer; taken is " + anchored[0] +
                ", the one beside a layer of the stage.");
    pattern = anchored[0];
  }
  const auto tiles = std::make_shared<Tiles>();
  if (anchored.size() <= 1) tiles->files = delegate::FindTiles(pattern);
  tiles->left = tiles->files.size();
  for (const auto& [number, path] : tiles->files) {
    File& file = files_.try_emplace(Identity(path), File{path, {}}).first->second;
    file.uses.push_back({&request, tiles, number});
  }
  if (!tiles->files.empty()) return;
  std::string why = "no tile of the pattern exists.";
  if (anchored.size() > 1)
    why = "its path is relative, this host did not anchor it to its layer, and tiles lie beside several: " +
          TfStringJoin(anchored, ", ") + ".";
  else if (TfIsRelativePath(pattern))
    why += " Its path is relative, and this host did not anchor it to its layer.";
  Check(core_.SetTextureMissing(request.key, why), request.location);
}

void Loading::Run() {
  std::vector<const File*> files;
  for (const auto& [identity, file] : files_) files.push_back(&file);
  WorkParallelForN(files.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) Load(*files[i]);
  });
}

void Loading::Load(const File& file) {
  core_.CountDecodedImage();
  const auto decoded = decode_(file.path);
  for (const Use& use : file.uses) {
    using Texels = wavefront::Result<wavefront::TextureData>;
    delegate::TextureKey key = use.request->texture;
    key.resolvedPath = file.path;
    Texels texels = decoded ? decoded.value()(key) : Texels(decoded.error());
    if (use.tiles) TakeTile(use, std::move(texels));
    else if (texels) Check(core_.SetTexture(use.request->key, std::move(texels).value()), use.request->location);
    else Check(core_.SetTextureMissing(use.request->key, texels.error().message), use.request->location);
  }
}

void Loading::TakeTile(const Use& use, wavefront::Result<wavefront::TextureData> texels) {
  Tiles& tiles = *use.tiles;
  std::lock_guard lock(tiles.mutex);
  if (texels) tiles.texels.emplace(use.number, std::move(texels).value());
  else tiles.reasons.emplace(use.number, texels.error().message);
  if (--tiles.left == 0) HandOver(*use.request, tiles);
}

void Loading::HandOver(const delegate::TextureLoadRequest& request, Tiles& tiles) {
  std::string reasons;
  for (const auto& [number, reason] : tiles.reasons)
    reasons += (reasons.empty() ? "" : "; ") + std::to_string(number) + ": " + reason;
  if (const std::string missing = delegate::MissingTiles(tiles.files); !missing.empty())
    reasons += (reasons.empty() ? "" : "; ") + ("there is no file for " + missing);
  if (tiles.texels.empty()) {
    Check(core_.SetTextureMissing(request.key, "no tile can be used (" + reasons + ")."), request.location);
    return;
  }
  if (!reasons.empty())
    report_(wavefront::Severity::Warning, "texture-tiles-missing", request.location,
            "Tiles of the texture \"" + request.texture.resolvedPath + "\" show the fallback value: " + reasons + ".");
  std::vector<std::pair<uint32_t, wavefront::TextureData>> set;
  for (auto& [number, texels] : tiles.texels) set.emplace_back(number, std::move(texels));
  Check(core_.SetTextureTiles(request.key, std::move(set)), request.location);
}

}  // namespace

void LoadTextures(delegate::RenderDelegate& core, const TextureDecoder& decode, const TextureReport& report) {
  const std::vector<delegate::TextureLoadRequest> requests = core.PendingTextures();
  Loading loading(core, decode, report);
  for (const delegate::TextureLoadRequest& request : requests) loading.Add(request);
  loading.Run();
}

}  // namespace hydra
