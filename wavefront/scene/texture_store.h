// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Textures on the device: mip chains cut into 64 x 64 pages, a page table, one texel-buffer pool for all formats.
// See kernels/lib/textures.glsl for the reader and shared/scene_layout.h for the records.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"
#include "wavefront/scene/stream.h"

namespace wavefront {

// A level of a texture as floats, for importance maps.
struct FloatImage {
  uint32_t width = 0, height = 0;
  std::vector<Float4> texels;  // row 0 = bottom
};

class TextureStore {
 public:
  explicit TextureStore(vulkan::Device& device);

  // Staging; thread-safe. An image of zero size or with too few bytes becomes one magenta texel and a diagnostic at commit.
  TextureId Create(TextureData texture);
  void Destroy(TextureId id);
  TextureId CreateTiles(std::vector<TextureTile> tiles);
  // Bytes that all texels together may take on the device; 0: what the device offers. Counts from the next commit on.
  // What was read coarser stays so until it is created again: Coarse says for which it would help.
  void SetLimit(uint64_t bytes);
  // Textures on the device that would be finer under this limit, had all been created anew.
  std::vector<TextureId> Coarse(uint64_t limit);

  Status Commit(const DiagnosticSink& sink, bool* changed);
  uint64_t count() const { return resident_.size(); }
  // The first level whose larger side is at most `maxSide`. Waits for the device.
  Result<FloatImage> ReadLevel(TextureId id, uint32_t maxSide);
  bool Has(TextureId id) const { return resident_.count(id) != 0; }

  Stream records, pageTable, pages;

 private:
  // Entries of the page table and pages count from the texture's own first ones; x, y: where the tail's levels stand in
  // their page.
  struct Level { uint32_t width, height, firstEntry, firstPage, x, y; };
  struct Resident {
    std::string name;
    TexelFormat format;
    std::vector<Level> levels;
    Range table, blocks;
  };
  // Of a page: its first texel in the pool, in texels of the format, and its first block.
  static uint32_t FirstTexel(const Resident& r, uint32_t page);
  static uint32_t FirstBlock(const Resident& r, uint32_t page);
  Resident Layout(const TextureData& texture);
  uint64_t BlocksAllowed(uint64_t limit) const;
  struct Fitted;
  // The largest loses its finest level until `blocks`, the sum, is what the limit allows.
  static void Fit(std::vector<Fitted>& all, uint64_t allowed, uint64_t* blocks);
  Status ReduceToFit(const DiagnosticSink& sink, bool* changed);
  // A resident texture's level as the data of a texture of its own: its levels will be those that follow it now.
  Result<TextureData> ReadBack(const Resident& r, std::size_t level);
  void Forget(TextureId id);
  Status Compact();
  Status Upload(TextureId id, TextureData& texture);
  // A set's record: its columns and rows, and where its texture ids stand, row by row.
  struct TileTable { uint32_t columns = 0, rows = 0; Range table; };
  TileTable LayoutTiles(const std::vector<TextureTile>& tiles);
  Status UploadTiles(TextureId id, const std::vector<TextureTile>& tiles);

  const uint64_t maxBlocks_;  // what one texel-buffer view may hold, and half the memory budget

  std::mutex mutex_;
  std::map<TextureId, TextureData> staged_;
  std::vector<TextureId> destroyed_;
  std::map<TextureId, Resident> resident_;
  std::map<TextureId, std::pair<uint32_t, uint32_t>> full_;  // width and height as created
  std::map<TextureId, std::vector<TextureTile>> stagedTiles_;
  std::map<TextureId, TileTable> residentTiles_;
  TextureId next_ = 0;
  uint64_t limit_ = 0;
};

}  // namespace wavefront
