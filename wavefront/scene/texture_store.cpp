// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/texture_store.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "wavefront/scene/mip_chain.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {
using vulkan::MemoryKind;
using layout::kPageBlockBytes, layout::kPagePitch, layout::kPageSide;
constexpr uint32_t kPageTexels = kPagePitch * kPagePitch;
constexpr uint32_t kTailSide = kPageSide / 2;
static_assert(kPageSide == 1u << layout::kPageShift && kPagePitch == kPageSide + 1);
static_assert(kPageBlockBytes % 16 == 0 && kPageBlockBytes >= kPageTexels * TexelBytes(TexelFormat::Rgba8Unorm));
static_assert(layout::kTexelBytes == static_cast<uint32_t>(TexelFormat::Rgba8Unorm) && layout::kTexelHalfs == static_cast<uint32_t>(TexelFormat::Rgba16Float) &&
              layout::kTexelWords == static_cast<uint32_t>(TexelFormat::Rgba16Unorm) && layout::kTexelFloats == static_cast<uint32_t>(TexelFormat::Rgba32Float));
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
      maxBlocks_(std::min<uint64_t>(device.info().limits.maxTexelBufferElements * 16, device.memoryBudget() / 2) / kPageBlockBytes) {}

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

void TextureStore::SetLimit(uint64_t bytes) {
  std::lock_guard lock(mutex_);
  limit_ = bytes;
}

uint64_t TextureStore::BlocksAllowed(uint64_t limit) const {
  return limit == 0 ? maxBlocks_ : std::min(maxBlocks_, limit / kPageBlockBytes);
}

Result<TextureData> TextureStore::ReadBack(const Resident& r, std::size_t index) {
  const Level& level = r.levels[index];
  const uint32_t bytes = TexelBytes(r.format), across = Pages(level.width);
  TextureData data{r.name, level.width, level.height, r.format, {}};
  data.texels.resize(static_cast<std::size_t>(level.width) * level.height * bytes);
  std::vector<std::byte> page(static_cast<std::size_t>(kPageTexels) * bytes);
  for (uint32_t p = 0; p < across * Pages(level.height); ++p) {
    if (Status s = pages.Read(FirstBlock(r, level.firstPage + p), page); !s) return s.error();
    const uint32_t x0 = p % across * kPageSide, y0 = p / across * kPageSide;
    const uint32_t columns = std::min(kPageSide, level.width - x0), rows = std::min(kPageSide, level.height - y0);
    for (uint32_t y = 0; y < rows; ++y) {
      const std::byte* from = &page[(static_cast<std::size_t>(level.y + y) * kPagePitch + level.x) * bytes];
      std::memcpy(&data.texels[(static_cast<std::size_t>(y0 + y) * level.width + x0) * bytes], from,
                  static_cast<std::size_t>(columns) * bytes);
    }
  }
  return data;
}

void TextureStore::Forget(TextureId id) {
  const auto it = resident_.find(id);
  if (it == resident_.end()) return;
  pages.Free(it->second.blocks);
  pageTable.Free(it->second.table);
  resident_.erase(it);
}

// A texture while it is decided at which size it is read.
struct TextureStore::Fitted {
  Fitted(TextureId textureId, std::string textureName, uint32_t width, uint32_t height, TexelFormat format)
      : id(textureId), name(std::move(textureName)), size{{}, width, height, format, {}}, blocks(BlocksOf(size)) {}
  TextureId id;
  std::string name;
  TextureData size;  // without texels
  uint64_t blocks;
  std::size_t drops = 0;
};

// Textures that together pass what they may take are read coarser: the largest loses its finest level until all fit,
// of equals the first by name, so that the order in which they came never shows. No texture goes below one page: from
// there on its memory hardly falls, and its picture does.
void TextureStore::Fit(std::vector<Fitted>& all, uint64_t allowed, uint64_t* blocks) {
  const auto before = [](const Fitted& a, const Fitted& b) {
    return std::tie(a.blocks, b.name, b.id) < std::tie(b.blocks, a.name, a.id);
  };
  *blocks = 0;
  for (const Fitted& f : all) *blocks += f.blocks;
  while (*blocks > allowed && !all.empty()) {
    Fitted& largest = *std::max_element(all.begin(), all.end(), before);
    TextureData& size = largest.size;
    if (std::max(size.width, size.height) <= kPageSide) break;
    size.width = std::max(1u, size.width / 2);
    size.height = std::max(1u, size.height / 2);
    ++largest.drops;
    *blocks -= largest.blocks;
    largest.blocks = BlocksOf(size);
    *blocks += largest.blocks;
  }
}

// From the sizes as created on, which gives at most what a commit makes of them and what is on the device: so what is
// created anew because it stands here does not stand here again.
std::vector<TextureId> TextureStore::Coarse(uint64_t limit) {
  std::lock_guard lock(mutex_);
  std::vector<Fitted> all;
  for (const auto& [id, r] : resident_) {
    if (std::count(destroyed_.begin(), destroyed_.end(), id) == 0)
      all.emplace_back(id, r.name, full_.at(id).first, full_.at(id).second, r.format);
  }
  uint64_t blocks = 0;
  Fit(all, BlocksAllowed(limit), &blocks);
  std::vector<TextureId> coarse;
  for (const Fitted& f : all) {
    const Level& held = resident_.at(f.id).levels[0];
    if (f.size.width > held.width || f.size.height > held.height) coarse.push_back(f.id);
  }
  return coarse;
}

// Those on the device take part.
Status TextureStore::ReduceToFit(const DiagnosticSink& sink, bool* changed) {
  std::vector<Fitted> all;
  uint64_t blocks = 0;
  const uint64_t allowedBlocks = BlocksAllowed(limit_);
  for (const auto& [id, r] : resident_) all.emplace_back(id, r.name, r.levels[0].width, r.levels[0].height, r.format);
  for (const auto& [id, t] : staged_) all.emplace_back(id, t.name, t.width, t.height, t.format);
  Fit(all, allowedBlocks, &blocks);
  std::sort(all.begin(), all.end(), [](const Fitted& a, const Fitted& b) { return std::tie(a.name, a.id) < std::tie(b.name, b.id); });
  const auto megabytes = [](uint64_t count) { return std::to_string((count * kPageBlockBytes + (1 << 20) - 1) >> 20) + " MB"; };
  const std::string allowed = megabytes(allowedBlocks) + (allowedBlocks < maxBlocks_ ? ", the setting textureMemory" : ", what this device can hold");
  for (const Fitted& c : all) {
    if (c.drops == 0) continue;
    *changed = true;
    if (const auto staged = staged_.find(c.id); staged != staged_.end()) {
      TextureData& t = staged->second;
      for (std::size_t i = 0; i < c.drops; ++i) {
        t.texels = HalveLevel(t.texels, t.width, t.height, t.format);
        t.width = std::max(1u, t.width / 2);
        t.height = std::max(1u, t.height / 2);
      }
    } else {
      Result<TextureData> coarser = ReadBack(resident_.at(c.id), c.drops);
      if (!coarser) return coarser.error();
      Forget(c.id);
      staged_[c.id] = std::move(coarser).value();
    }
    if (sink) {
      sink({Severity::Warning, "texture-reduced", c.name, "the textures together pass what they may take (" + allowed +
            "); this one is read at " + std::to_string(c.size.width) + " x " + std::to_string(c.size.height)});
    }
  }
  if (blocks > allowedBlocks && sink && *changed) {
    sink({Severity::Warning, "texture-memory", "", std::to_string(all.size()) + " textures of at most " + std::to_string(kPageSide) +
          " texels a side take " + megabytes(blocks) + ", which is more than they may take (" + allowed + ")"});
  }
  return {};
}

// Holes between textures must not make the pool larger than what textures may take: all are laid out anew, in buffers
// that hold just them.
Status TextureStore::Compact() {
  for (const auto& [id, r] : resident_) {
    if (staged_.count(id) != 0) continue;
    Result<TextureData> data = ReadBack(r, 0);
    if (!data) return data.error();
    staged_[id] = std::move(data).value();
  }
  for (const auto& [id, texture] : staged_) Forget(id);
  pages.Release();
  for (const auto& [id, texture] : staged_) resident_[id] = Layout(texture);
  return {};
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
  r.name = texture.name;
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
    Forget(id);
    full_.erase(id);
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
    full_.try_emplace(id, texture.width, texture.height);
  }
  if (Status s = ReduceToFit(sink, changed); !s) return s;
  for (auto& [id, texture] : staged_) resident_[id] = Layout(texture);
  uint64_t used = 0;
  for (const auto& [id, r] : resident_) used += r.blocks.count;
  const uint64_t held = std::max<uint64_t>(pages.elements(), pages.buffer() ? pages.buffer()->size() / kPageBlockBytes : 0);
  if (held > std::max(used, BlocksAllowed(limit_))) {
    if (Status s = Compact(); !s) return s;
  }
  for (const auto& [id, tiles] : stagedTiles_) residentTiles_[id] = LayoutTiles(tiles);
  // Texture ids are record indices.
  if (next_ > records.elements()) records.Allocate(next_ - records.elements());
  for (Stream* stream : {&records, &pageTable}) {
    if (Status s = stream->Fit(); !s) return s;
  }
  if (Status s = pages.Fit(BlocksAllowed(limit_)); !s) return s;
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
  for (std::size_t l = 0; l < r.levels.size(); ++l) {
    if (std::max(r.levels[l].width, r.levels[l].height) > maxSide) continue;
    const Result<TextureData> data = ReadBack(r, l);
    if (!data) return data.error();
    const TextureData& level = data.value();
    FloatImage image{level.width, level.height, std::vector<Float4>(static_cast<std::size_t>(level.width) * level.height)};
    for (std::size_t i = 0; i < image.texels.size(); ++i) image.texels[i] = ReadTexel(&level.texels[i * TexelBytes(r.format)], r.format);
    return image;
  }
  return Error{"the texture has no level that small"};
}

}  // namespace wavefront
