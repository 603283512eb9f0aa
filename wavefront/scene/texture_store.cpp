// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/texture_store.h"

#include <algorithm>
#include <cstring>

#include "wavefront/scene/mip_chain.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {
using vulkan::MemoryKind;
using layout::kPageBlockBytes, layout::kPagePitch, layout::kPageSide;
constexpr uint32_t kPageTexels = kPagePitch * kPagePitch;
constexpr uint32_t kTailSide = kPageSide / 2;
static_assert(kPageSide == 1u << layout::kPageShift && kPagePitch == kPageSide + 1);
static_assert(kPageBlockBytes % 8 == 0 && kPageBlockBytes >= kPageTexels * TexelBytes(TexelFormat::Rgba8Unorm));
uint32_t Pages(uint32_t side) { return (side + kPageSide - 1) / kPageSide; }
uint32_t BlocksPerPage(TexelFormat format) { return TexelBytes(format) / TexelBytes(TexelFormat::Rgba8Unorm); }

// Copies a page's texels of a level into it, at (atX, atY), with the column and row after them.
void FillPage(const std::vector<uint8_t>& level, uint32_t width, uint32_t height, uint32_t bytes, uint32_t firstX, uint32_t firstY,
              uint32_t atX, uint32_t atY, std::vector<uint8_t>& page) {
  const uint32_t columns = std::min(kPageSide, width - firstX), rows = std::min(kPageSide, height - firstY);
  const uint32_t nextColumn = (firstX + columns) % width;
  for (uint32_t y = 0; y <= rows; ++y) {
    const uint8_t* line = &level[static_cast<std::size_t>((firstY + y) % height) * width * bytes];
    uint8_t* target = &page[(static_cast<std::size_t>(atY + y) * kPagePitch + atX) * bytes];
    std::memcpy(target, line + static_cast<std::size_t>(firstX) * bytes, static_cast<std::size_t>(columns) * bytes);
    std::memcpy(target + static_cast<std::size_t>(columns) * bytes, line + static_cast<std::size_t>(nextColumn) * bytes, bytes);
  }
}
}  // namespace

TextureStore::TextureStore(vulkan::Device& device)
    : records(device, "texture records", MemoryKind::Textures, 16 * layout::kTextureTexels),
      pageTable(device, "page table", MemoryKind::Textures, 4),
      pages(device, "texture pages", MemoryKind::Textures, kPageBlockBytes),
      maxBlocks_(std::min<uint64_t>(device.info().limits.maxTexelBufferElements * 8, device.memoryBudget() / 2) / kPageBlockBytes) {}

uint32_t TextureStore::FirstBlock(const Resident& r, uint32_t page) { return r.blocks.first + page * BlocksPerPage(r.format); }
uint32_t TextureStore::FirstTexel(const Resident& r, uint32_t page) { return FirstBlock(r, page) * (kPageBlockBytes / TexelBytes(r.format)); }

namespace {
// Blocks of all levels, an upper bound: what Layout will ask for.
uint64_t BlocksOf(const TextureData& texture) {
  uint64_t pages = 1;  // the mip tail
  for (uint32_t w = texture.width, h = texture.height; std::max(w, h) > kTailSide; w = std::max(1u, w / 2), h = std::max(1u, h / 2)) {
    pages += static_cast<uint64_t>(Pages(w)) * Pages(h);
  }
  return pages * BlocksPerPage(texture.format);
}
}  // namespace

// A scene with more texels than the device can address renders with coarser ones: the largest textures are halved
// until everything fits, and each is named. (Paths on hold while pages stream come with a later issue.)
void TextureStore::ReduceToFit(const DiagnosticSink& sink) {
  std::vector<std::pair<uint64_t, TextureId>> staged;  // blocks, id
  uint64_t blocks = 0;
  for (const auto& [id, r] : resident_) blocks += r.blocks.count;
  for (const auto& [id, texture] : staged_) {
    staged.emplace_back(BlocksOf(texture), id);
    blocks += staged.back().first;
  }
  while (blocks > maxBlocks_ && !staged.empty()) {
    auto largest = std::max_element(staged.begin(), staged.end());
    TextureData& texture = staged_[largest->second];
    if (std::max(texture.width, texture.height) <= kPageSide) break;
    texture.texels = HalveLevel(texture.texels, texture.width, texture.height, texture.format);
    texture.width = std::max(1u, texture.width / 2);
    texture.height = std::max(1u, texture.height / 2);
    blocks -= largest->first;
    largest->first = BlocksOf(texture);
    blocks += largest->first;
    if (sink) {
      sink({Severity::Warning, "texture-reduced", texture.name, "the textures together pass what this device can hold; this one is read at " +
            std::to_string(texture.width) + " x " + std::to_string(texture.height)});
    }
  }
}

TextureId TextureStore::Create(TextureData texture) {
  std::lock_guard lock(mutex_);
  staged_[next_] = std::move(texture);
  return next_++;
}
TextureId TextureStore::CreateTiles(std::vector<TextureTile> tiles) {
  std::lock_guard lock(mutex_);
  stagedTiles_[next_] = std::move(tiles);
  return next_++;
}
void TextureStore::Destroy(TextureId id) {
  std::lock_guard lock(mutex_);
  staged_.erase(id);
  stagedTiles_.erase(id);
  destroyed_.push_back(id);
}

// Where each level's pages stand. The table starts with one word per level; its entries follow. The tail's levels stand in
// one page: the first at its corner, the others in a column beside it, each with its own next column and row.
TextureStore::Resident TextureStore::Layout(const TextureData& texture) {
  Resident r;
  r.format = texture.format;
  uint32_t w = texture.width, h = texture.height, entries = 0, pageCount = 0, tail = 0, tailPage = 0;
  for (;;) {
    Level level{w, h, entries, pageCount, 0, 0};
    if (std::max(w, h) <= kTailSide) {
      if (tail == 0) tailPage = pageCount++;
      level.firstPage = tailPage;
      if (tail > 0) level.x = kTailSide + 1, level.y = kTailSide - (kPageSide >> tail) + tail - 1;
      ++tail;
      ++entries;
    } else {
      entries += Pages(w) * Pages(h);
      pageCount += Pages(w) * Pages(h);
    }
    r.levels.push_back(level);
    if (w == 1 && h == 1) break;
    w = std::max(1u, w / 2);
    h = std::max(1u, h / 2);
  }
  for (Level& level : r.levels) level.firstEntry += static_cast<uint32_t>(r.levels.size());
  r.blocks = pages.Allocate(static_cast<uint64_t>(pageCount) * BlocksPerPage(r.format));
  r.table = pageTable.Allocate(r.levels.size() + entries);
  return r;
}

Status TextureStore::Commit(const DiagnosticSink& sink, bool* changed) {
  std::lock_guard lock(mutex_);
  *changed = !staged_.empty() || !destroyed_.empty() || !stagedTiles_.empty();
  for (TextureId id : destroyed_) {
    if (auto tiles = residentTiles_.find(id); tiles != residentTiles_.end()) {
      pageTable.Free(tiles->second.table);
      residentTiles_.erase(tiles);
    }
    auto it = resident_.find(id);
    if (it == resident_.end()) continue;
    pages.Free(it->second.blocks);
    pageTable.Free(it->second.table);
    resident_.erase(it);
  }
  destroyed_.clear();
  for (auto& [id, texture] : staged_) {
    uint64_t need = static_cast<uint64_t>(texture.width) * texture.height * TexelBytes(texture.format);
    if (need == 0 || texture.texels.size() < need) {
      if (sink) sink({Severity::Warning, "texture-empty", texture.name, "the image has no pixels; it is shown in magenta"});
      texture.width = texture.height = 1;
      texture.format = TexelFormat::Rgba8Unorm;
      texture.texels = {255, 0, 255, 255};
    }
  }
  ReduceToFit(sink);
  for (auto& [id, texture] : staged_) resident_[id] = Layout(texture);
  for (const auto& [id, tiles] : stagedTiles_) residentTiles_[id] = LayoutTiles(tiles);
  // Texture ids are record indices.
  if (next_ > records.elements()) records.Allocate(next_ - records.elements());
  for (Stream* stream : {&records, &pageTable, &pages}) {
    if (Status s = stream->Fit(); !s) return s;
  }
  for (auto& [id, texture] : staged_) {
    if (Status s = Upload(id, texture); !s) return s;
    texture = {};
  }
  staged_.clear();
  for (const auto& [id, tiles] : stagedTiles_) {
    if (Status s = UploadTiles(id, tiles); !s) return s;
  }
  stagedTiles_.clear();
  return {};
}

TextureStore::TileTable TextureStore::LayoutTiles(const std::vector<TextureTile>& tiles) {
  TileTable t;
  for (const TextureTile& tile : tiles) {
    t.columns = std::max(t.columns, (tile.udim - 1001) % 10 + 1);
    t.rows = std::max(t.rows, (tile.udim - 1001) / 10 + 1);
  }
  t.table = pageTable.Allocate(static_cast<uint64_t>(t.columns) * t.rows);
  return t;
}

Status TextureStore::UploadTiles(TextureId id, const std::vector<TextureTile>& tiles) {
  const TileTable& t = residentTiles_[id];
  std::vector<uint32_t> table(static_cast<std::size_t>(t.columns) * t.rows, kInvalidId);
  for (const TextureTile& tile : tiles) {
    const uint32_t place = tile.udim - 1001;
    table[place / 10 * t.columns + place % 10] = tile.texture;
  }
  if (Status s = pageTable.Write<uint32_t>(t.table, table); !s) return s;
  const uint32_t record[4] = {t.columns, t.rows, 0, t.table.first};
  return records.Write<uint32_t>({id, 1}, record);
}

Status TextureStore::Upload(TextureId id, TextureData& texture) {
  Resident& r = resident_[id];
  const uint32_t bytes = TexelBytes(r.format);
  const uint32_t levelCount = static_cast<uint32_t>(r.levels.size());
  std::vector<uint32_t> table(r.table.count);
  std::vector<uint8_t> texels = std::move(texture.texels);
  std::vector<uint8_t> page(static_cast<std::size_t>(kPageTexels) * bytes), tailPage(page.size());
  for (uint32_t l = 0; l < levelCount; ++l) {
    const Level& level = r.levels[l];
    table[l] = r.table.first + level.firstEntry;
    if (std::max(level.width, level.height) <= kTailSide) {
      FillPage(texels, level.width, level.height, bytes, 0, 0, level.x, level.y, tailPage);
      table[level.firstEntry] = FirstTexel(r, level.firstPage) + level.y * kPagePitch + level.x;
    } else {
      const uint32_t across = Pages(level.width), count = across * Pages(level.height);
      for (uint32_t p = 0; p < count; ++p) {
        FillPage(texels, level.width, level.height, bytes, p % across * kPageSide, p / across * kPageSide, 0, 0, page);
        table[level.firstEntry + p] = FirstTexel(r, level.firstPage + p);
        if (Status s = pages.Write<uint8_t>({FirstBlock(r, level.firstPage + p), 1}, page); !s) return s;
      }
    }
    if (l + 1 < levelCount) texels = HalveLevel(texels, level.width, level.height, r.format);
  }
  // The 1 x 1 level always stands in the tail.
  if (Status s = pages.Write<uint8_t>({FirstBlock(r, r.levels.back().firstPage), 1}, tailPage); !s) return s;
  if (Status s = pageTable.Write<uint32_t>(r.table, table); !s) return s;
  const uint32_t record[4] = {r.levels[0].width, r.levels[0].height, levelCount | static_cast<uint32_t>(r.format) << 16, r.table.first};
  return records.Write<uint32_t>({id, 1}, record);
}

Result<FloatImage> TextureStore::ReadLevel(TextureId id, uint32_t maxSide) {
  auto it = resident_.find(id);
  if (it == resident_.end()) return Error{"no such texture"};
  const Resident& r = it->second;
  const uint32_t bytes = TexelBytes(r.format);
  for (const Level& level : r.levels) {
    if (std::max(level.width, level.height) > maxSide) continue;
    FloatImage image{level.width, level.height, std::vector<Float4>(static_cast<std::size_t>(level.width) * level.height)};
    std::vector<std::byte> page(static_cast<std::size_t>(kPageTexels) * bytes);
    for (uint32_t py = 0; py < Pages(level.height); ++py) {
      for (uint32_t px = 0; px < Pages(level.width); ++px) {
        if (Status s = pages.Read(FirstBlock(r, level.firstPage + py * Pages(level.width) + px), page); !s) return s.error();
        uint32_t columns = std::min(kPageSide, level.width - px * kPageSide), rows = std::min(kPageSide, level.height - py * kPageSide);
        for (uint32_t y = 0; y < rows; ++y) {
          for (uint32_t x = 0; x < columns; ++x) {
            const std::byte* texel = &page[(static_cast<std::size_t>(level.y + y) * kPagePitch + level.x + x) * bytes];
            image.texels[(static_cast<std::size_t>(py) * kPageSide + y) * level.width + px * kPageSide + x] = ReadTexel(reinterpret_cast<const uint8_t*>(texel), r.format);
          }
        }
      }
    }
    return image;
  }
  return Error{"the texture has no level that small"};
}

}  // namespace wavefront
