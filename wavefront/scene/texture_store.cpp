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
constexpr uint32_t kPageSide = 1u << layout::kPageShift;
constexpr uint32_t kPageTexels = kPageSide * kPageSide;
constexpr uint32_t kTailSide = kPageSide / 2;
uint32_t Pages(uint32_t side) { return (side + kPageSide - 1) / kPageSide; }
}  // namespace

TextureStore::TextureStore(vulkan::Device& device)
    : records(device, "texture records", MemoryKind::Textures, 16 * layout::kTextureTexels),
      pageTable(device, "page table", MemoryKind::Textures, 4),
      pagesRgba8(device, "8-bit texture pages", MemoryKind::Textures, 4 * kPageTexels),
      pagesRgba16f(device, "half texture pages", MemoryKind::Textures, 8 * kPageTexels),
      maxPages_(std::min<uint64_t>(device.info().limits.maxTexelBufferElements / kPageTexels,
                                   device.memoryBudget() / 2 / (8 * kPageTexels))) {}

namespace {
// Pages of all levels, an upper bound: what Layout will ask for.
uint64_t PagesOf(const TextureData& texture) {
  uint64_t pages = 1;  // the mip tail
  for (uint32_t w = texture.width, h = texture.height; std::max(w, h) > kTailSide; w = std::max(1u, w / 2), h = std::max(1u, h / 2)) {
    pages += static_cast<uint64_t>(Pages(w)) * Pages(h);
  }
  return pages;
}
}  // namespace

// A scene with more texels than the device can address renders with coarser ones: the largest textures are halved
// until everything fits, and each is named. (Paths on hold while pages stream come with a later issue.)
void TextureStore::ReduceToFit(const DiagnosticSink& sink) {
  for (TexelFormat format : {TexelFormat::Rgba8Unorm, TexelFormat::Rgba16Float}) {
    std::vector<std::pair<uint64_t, TextureId>> staged;  // pages, id
    uint64_t pages = 0;
    for (const auto& [id, r] : resident_) if (r.format == format) pages += r.pages.count;
    for (const auto& [id, texture] : staged_) {
      if (texture.format != format) continue;
      staged.emplace_back(PagesOf(texture), id);
      pages += staged.back().first;
    }
    while (pages > maxPages_ && !staged.empty()) {
      auto largest = std::max_element(staged.begin(), staged.end());
      TextureData& texture = staged_[largest->second];
      if (std::max(texture.width, texture.height) <= kPageSide) break;
      texture.texels = HalveLevel(texture.texels, texture.width, texture.height, format);
      texture.width = std::max(1u, texture.width / 2);
      texture.height = std::max(1u, texture.height / 2);
      pages -= largest->first;
      largest->first = PagesOf(texture);
      pages += largest->first;
      if (sink) {
        sink({Severity::Warning, "texture-reduced", texture.name, "the textures together pass what this device can hold; this one is read at " +
              std::to_string(texture.width) + " x " + std::to_string(texture.height)});
      }
    }
  }
}

TextureId TextureStore::Create(TextureData texture) {
  std::lock_guard lock(mutex_);
  staged_[next_] = std::move(texture);
  return next_++;
}
void TextureStore::Destroy(TextureId id) {
  std::lock_guard lock(mutex_);
  staged_.erase(id);
  destroyed_.push_back(id);
}

// Where each level's pages stand. The table starts with one word per level: the offset of its first entry.
TextureStore::Resident TextureStore::Layout(const TextureData& texture) {
  Resident r;
  r.format = texture.format;
  uint32_t w = texture.width, h = texture.height;
  std::vector<Level> levels;
  uint32_t entries = 0, tail = 0;
  uint32_t tailEntry = 0;
  for (;;) {
    Level level{w, h, entries, 0};
    if (std::max(w, h) <= kTailSide) {
      if (tail == 0) tailEntry = entries++;
      level.firstEntry = tailEntry;
      level.tailOffset = kPageSide - (kPageSide >> tail);
      ++tail;
    } else {
      entries += Pages(w) * Pages(h);
    }
    levels.push_back(level);
    if (w == 1 && h == 1) break;
    w = std::max(1u, w / 2);
    h = std::max(1u, h / 2);
  }
  for (Level& level : levels) level.firstEntry += static_cast<uint32_t>(levels.size());
  r.levels = std::move(levels);
  r.pages = Pool(r.format).Allocate(entries);
  r.table = pageTable.Allocate(r.levels.size() + entries);
  return r;
}

Status TextureStore::Commit(const DiagnosticSink& sink, bool* changed) {
  std::lock_guard lock(mutex_);
  *changed = !staged_.empty() || !destroyed_.empty();
  for (TextureId id : destroyed_) {
    auto it = resident_.find(id);
    if (it == resident_.end()) continue;
    Pool(it->second.format).Free(it->second.pages);
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
  // Texture ids are record indices.
  if (next_ > records.elements()) records.Allocate(next_ - records.elements());
  for (Stream* stream : {&records, &pageTable, &pagesRgba8, &pagesRgba16f}) {
    if (Status s = stream->Fit(); !s) return s;
  }
  for (auto& [id, texture] : staged_) {
    if (Status s = Upload(id, texture); !s) return s;
    texture = {};
  }
  staged_.clear();
  return {};
}

Status TextureStore::Upload(TextureId id, TextureData& texture) {
  Resident& r = resident_[id];
  Stream& pool = Pool(r.format);
  const uint32_t bytes = TexelBytes(r.format);
  const uint32_t levelCount = static_cast<uint32_t>(r.levels.size());
  std::vector<uint32_t> table(r.table.count);
  std::vector<uint8_t> texels = std::move(texture.texels);
  std::vector<uint8_t> page(static_cast<std::size_t>(kPageTexels) * bytes), tailPage(page.size());
  uint32_t tailEntry = 0;
  for (uint32_t l = 0; l < levelCount; ++l) {
    const Level& level = r.levels[l];
    table[l] = level.firstEntry;
    const bool tail = std::max(level.width, level.height) <= kTailSide;
    for (uint32_t py = 0; py < Pages(level.height); ++py) {
      for (uint32_t px = 0; px < Pages(level.width); ++px) {
        std::vector<uint8_t>& target = tail ? tailPage : page;
        uint32_t columns = std::min(kPageSide, level.width - px * kPageSide), rows = std::min(kPageSide, level.height - py * kPageSide);
        for (uint32_t y = 0; y < rows; ++y) {
          std::memcpy(&target[(static_cast<std::size_t>(y) * kPageSide + level.tailOffset) * bytes],
                      &texels[((static_cast<std::size_t>(py) * kPageSide + y) * level.width + px * kPageSide) * bytes], static_cast<std::size_t>(columns) * bytes);
        }
        uint32_t entry = level.firstEntry + py * Pages(level.width) + px;
        uint32_t pageIndex = r.pages.first + entry - levelCount;
        table[entry] = pageIndex;
        if (tail) { tailEntry = pageIndex; continue; }
        if (Status s = pool.Write<uint8_t>({pageIndex, 1}, page); !s) return s;
      }
    }
    if (l + 1 < levelCount) texels = HalveLevel(texels, level.width, level.height, r.format);
  }
  // The 1 x 1 level always stands in the tail.
  if (Status s = pool.Write<uint8_t>({tailEntry, 1}, tailPage); !s) return s;
  if (Status s = pageTable.Write<uint32_t>(r.table, table); !s) return s;
  const uint32_t record[8] = {r.levels[0].width, r.levels[0].height, levelCount, static_cast<uint32_t>(r.format), r.table.first, 0, 0, 0};
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
        uint32_t index = r.pages.first + level.firstEntry - static_cast<uint32_t>(r.levels.size()) + py * Pages(level.width) + px;
        if (Status s = Pool(r.format).Read(index, page); !s) return s.error();
        uint32_t columns = std::min(kPageSide, level.width - px * kPageSide), rows = std::min(kPageSide, level.height - py * kPageSide);
        for (uint32_t y = 0; y < rows; ++y) {
          for (uint32_t x = 0; x < columns; ++x) {
            const std::byte* texel = &page[(static_cast<std::size_t>(y) * kPageSide + level.tailOffset + x) * bytes];
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
