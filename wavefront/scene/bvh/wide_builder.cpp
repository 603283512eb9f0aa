// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Binned SAH (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007), wide nodes made
// directly: a node's range is split, then its largest part, until there are four. A part of the tree with many
// items is split by all threads together; parts below a size that depends on the input alone become tasks. Where the parts
// of the best split overlap, planes that cut items are looked at, too (spatial_split.h).
#include "wavefront/scene/bvh/wide_builder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/node_boxes.h"
#include "wavefront/scene/bvh/spatial_split.h"
#include "wavefront/scene/bvh/tree_cost.h"
#include "wavefront/scene/bvh/vector4.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront::bvh {
namespace {

constexpr uint32_t kIndexDisguise = 0x40000000u;  // exponent bits of 2.0f: below 2^29 every index is a normal float
constexpr uint32_t kMaxBins = 128;
constexpr uint32_t kMinTaskItems = 2048;
// Planes that cut items are looked at where the parts of the best other split overlap by this much of the whole tree's
// area, and where that split would cost less by this much without the overlap (resources/TRAVERSAL.md).
constexpr double kOverlapOfTree = 1e-4;
constexpr double kLeastGain = 0.1;
constexpr uint32_t kTasksPerTree = 128;           // parts below items / this many become tasks
constexpr uint32_t kBinChunk = 1u << 16;          // items that one thread bins at a time
constexpr uint32_t kTaskReference = 0x40000000u;  // child reference: number of a task, until its nodes are appended

struct Range {
  uint32_t begin = 0, end = 0;
  uint32_t limit = 0;  // [end, limit) is room for pieces of items that are cut
  Box4 bounds;     // of the boxes
  Box4 centroids;  // of lo + hi (twice the centre)
  bool isLeaf = false;
  uint32_t size() const { return end - begin; }
  uint32_t room() const { return limit - end; }
};

struct Bin {
  Vec4 lo, hi;
  uint32_t count;

  Box4 bounds() const { return {lo, hi}; }
};
// Most ranges are small and use few of the bins: only those are set to empty.
struct Bins {
  Bin axis[3][kMaxBins];

  explicit Bins(uint32_t used) {
    const Box4 empty;
    for (auto& row : axis) std::fill_n(row, used, Bin{empty.lo, empty.hi, 0});
  }
};

// Maps twice a centre to a bin of each axis.
struct BinMapping {
  Vec4 base, scale;
  uint32_t count;

  BinMapping(const Range& range) : base(range.centroids.lo) {
    count = std::min(kMaxBins, 4 + range.size() / 2);
    float k[4];
    const auto lo = Store(range.centroids.lo), hi = Store(range.centroids.hi);
    for (int i = 0; i < 3; ++i) {
      const float extent = hi[i] - lo[i];
      k[i] = extent > 0 ? static_cast<float>(count) * 0.9999f / extent : 0;
      if (!(k[i] <= std::numeric_limits<float>::max())) k[i] = 0;  // extent is a denormal
    }
    k[3] = 0;
    scale = Load(k);
  }
  std::array<int32_t, 4> Of(const BuildItem& item) const {
    return TruncateToInt(Mul(Sub(Add(Load(item.lo), Load(item.hi)), base), scale));
  }
};

struct Split {
  int axis = -1;
  uint32_t bin = 0;  // items in bins below this go left
  double cost = std::numeric_limits<double>::infinity();
  Box4 leftBounds, rightBounds;
  uint32_t leftCount = 0;
};

void FillBins(const BuildItem* items, uint32_t begin, uint32_t end, const BinMapping& mapping, Bins& bins) {
  const int32_t last = static_cast<int32_t>(mapping.count) - 1;
  for (uint32_t i = begin; i < end; ++i) {
    const auto at = mapping.Of(items[i]);
    const Vec4 lo = Load(items[i].lo), hi = Load(items[i].hi);
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = bins.axis[axis][std::clamp(at[axis], 0, last)];
      bin.lo = Min(bin.lo, lo);
      bin.hi = Max(bin.hi, hi);
      ++bin.count;
    }
  }
}

// The cheapest split over all axes and bins; ties go to the first axis, then the first bin.
Split BestSplit(const Bins& bins, uint32_t binCount) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    const Bin* row = bins.axis[axis];
    std::array<double, kMaxBins> areaRight;
    std::array<uint32_t, kMaxBins> countRight;
    Box4 box;
    uint32_t count = 0;
    for (uint32_t i = binCount; i-- > 1;) {
      box.Extend(row[i].bounds());
      count += row[i].count;
      areaRight[i] = box.HalfArea();
      countRight[i] = count;
    }
    box = Box4{};
    count = 0;
    for (uint32_t i = 1; i < binCount; ++i) {
      box.Extend(row[i - 1].bounds());
      count += row[i - 1].count;
      if (count == 0 || countRight[i] == 0) continue;
      const double cost = box.HalfArea() * count + areaRight[i] * countRight[i];
      if (cost < best.cost) best = {axis, i, cost, box, Box4{}, count};
    }
  }
  for (uint32_t i = best.bin; best.axis >= 0 && i < binCount; ++i) best.rightBounds.Extend(bins.axis[best.axis][i].bounds());
  return best;
}

// Nodes that a complete 4-ary tree over `items` needs from its root down.
uint32_t CompleteDepth(uint32_t items, uint32_t maxLeafItems) {
  uint32_t depth = 1;
  for (uint64_t capacity = 4ull * maxLeafItems; capacity < items; capacity *= 4) ++depth;
  return depth;
}

class Builder {
 public:
  Builder(std::vector<BuildItem>& items, const WideBuildSettings& settings) : items_(items), settings_(settings) {}

  std::vector<BvhNode4> Build() {
    const uint32_t count = static_cast<uint32_t>(items_.size());
    taskItems_ = std::max(kMinTaskItems, count / kTasksPerTree);
    Range root = WholeRange(0, count);
    if (settings_.cutter != nullptr) {
      root.limit = count + settings_.maxPieces;
      items_.resize(root.limit);
      rootArea_ = root.bounds.HalfArea();
    }
    std::vector<BvhNode4> nodes;
    nodes.reserve(count / 2 / settings_.maxLeafItems + 16);
    nodes.emplace_back();
    BuildNode(root, settings_.maxDepth, 0, nodes, true);
    std::vector<std::vector<BvhNode4>> parts(tasks_.size());
    ParallelFor(tasks_.size(), settings_.threads, [&](size_t i) {
      parts[i].emplace_back();
      BuildNode(tasks_[i].range, tasks_[i].depthLeft, 0, parts[i], false);
    });
    Append(nodes, parts);
    if (settings_.cutter != nullptr) CloseGaps(nodes);
    return nodes;
  }

 private:
  struct Task {
    Range range;
    uint32_t depthLeft;
  };

  Range WholeRange(uint32_t begin, uint32_t end) const {
    Range range{begin, end, end, {}, {}, false};
    for (uint32_t i = begin; i < end; ++i) {
      const Vec4 lo = Load(items_[i].lo), hi = Load(items_[i].hi), centre = Add(lo, hi);
      range.bounds.Extend({lo, hi});
      range.centroids.Extend({centre, centre});
    }
    return range;
  }

  // Makes the node over `range`, which has its place, and all below it. In the top part of the tree, large ranges are
  // split by all threads and small ones are left as tasks. Siblings stand side by side: rays that visit one often visit
  // the next, and meet fewer pages.
  void BuildNode(const Range& range, uint32_t depthLeft, uint32_t index, std::vector<BvhNode4>& nodes, bool isTop) {
    std::array<Range, 4> parts;
    const uint32_t partCount = Divide(range, depthLeft, parts);
    BvhNode4 node = MakeNode(parts, partCount);
    std::array<uint32_t, 4> below{};
    uint32_t belowCount = 0;
    for (uint32_t i = 0; i < partCount; ++i) {
      if (parts[i].isLeaf) {
        node.children[i] = LeafReference(parts[i]);
      } else if (isTop && parts[i].size() <= taskItems_) {
        node.children[i] = kTaskReference | static_cast<uint32_t>(tasks_.size());
        tasks_.push_back({parts[i], depthLeft - 1});
      } else {
        node.children[i] = static_cast<uint32_t>(nodes.size());
        nodes.emplace_back();
        below[belowCount++] = i;
      }
    }
    nodes[index] = node;
    for (uint32_t k = 0; k < belowCount; ++k) {
      BuildNode(parts[below[k]], depthLeft - 1, node.children[below[k]], nodes, isTop);
    }
  }

  uint32_t LeafReference(Range& range) {
    // Pieces of one item that met again.
    for (uint32_t i = range.begin + 1; settings_.cutter != nullptr && i < range.end;) {
      const auto isSame = [&](const BuildItem& other) { return ItemIndex(other) == ItemIndex(items_[i]); };
      if (std::any_of(items_.begin() + range.begin, items_.begin() + i, isSame)) {
        items_[i] = items_[--range.end];
      } else {
        ++i;
      }
    }
    const uint32_t first = settings_.leafIsItemIndex ? ItemIndex(items_[range.begin]) : range.begin;
    return layout::kBvhLeafBit | (range.size() - 1) << layout::kBvhLeafCountShift | first;
  }

  // Up to four parts of `range`, each either a leaf or small enough for the depth that is left to it.
  uint32_t Divide(const Range& range, uint32_t depthLeft, std::array<Range, 4>& parts) {
    if (range.size() == 0) return 0;
    const uint32_t needed = CompleteDepth(range.size(), settings_.maxLeafItems);
    WAVEFRONT_CHECK(needed <= depthLeft, "%u items, %u levels left", range.size(), depthLeft);
    // Without depth to spare, only equal parts are sure to fit.
    const bool equalParts = needed == depthLeft;
    parts[0] = range;
    uint32_t count = 1;
    while (count < 4) {
      uint32_t chosen = 4;
      double largest = -1;
      for (uint32_t i = 0; i < count; ++i) {
        if (parts[i].isLeaf) continue;
        const double size = equalParts ? parts[i].size() : parts[i].bounds.HalfArea();
        if (size > largest) chosen = i, largest = size;
      }
      if (chosen == 4) break;
      Range left, right;
      if (SplitRange(parts[chosen], equalParts, left, right)) {
        std::copy_backward(parts.begin() + chosen + 1, parts.begin() + count, parts.begin() + count + 1);
        parts[chosen] = left;
        parts[chosen + 1] = right;
        ++count;
      } else {
        parts[chosen].isLeaf = true;
      }
    }
    // Parts that the full node left unsplit: a small one is a leaf, or worth a node of its own.
    for (uint32_t i = 0; i < count; ++i) {
      if (!parts[i].isLeaf) parts[i].isLeaf = parts[i].size() <= settings_.maxLeafItems && (equalParts || !IsWorthNode(parts[i]));
    }
    return count;
  }

  bool IsWorthNode(const Range& range) const {
    if (range.size() == 1) return false;
    const BinMapping mapping(range);
    Bins bins(mapping.count);
    FillBins(items_.data(), range.begin, range.end, mapping, bins);
    const double area = range.bounds.HalfArea();
    return BestSplit(bins, mapping.count).cost + kNodeCost * area < area * range.size();
  }

  // False: the range is better left together as a leaf.
  bool SplitRange(const Range& range, bool equalParts, Range& left, Range& right) {
    const uint32_t count = range.size();
    if (count == 1) return false;
    const bool mayBeLeaf = count <= settings_.maxLeafItems;
    if (!equalParts || mayBeLeaf) {
      const BinMapping mapping(range);
      Bins bins(mapping.count);
      BinRange(range, mapping, bins);
      const Split split = BestSplit(bins, mapping.count);
      const SpatialSplit spatial = equalParts ? SpatialSplit{} : BestCut(range, split);
      // While the node has room, one more child is free: any gain is worth it.
      if (mayBeLeaf && !(std::min(split.cost, spatial.cost) < range.bounds.HalfArea() * count)) return false;
      if (spatial.cost < split.cost) {
        Cut(range, spatial, left, right);
        if (left.size() < count && right.size() < count && left.size() > 0 && right.size() > 0) {
          ShareRoom(range.limit, left, right);
          return true;
        }
        // Rounding put all on one side. The pieces are still all there.
        Range all = range;
        all.end = right.end;
        SplitAtMedian(all, left, right);
        return true;
      }
      if (split.axis >= 0) {
        Partition(range, mapping, split, left, right);
        ShareRoom(range.limit, left, right);
        return true;
      }
    }
    SplitAtMedian(range, left, right);
    return true;
  }

  // What the split would cost if its parts did not overlap along its axis: a plane that cuts can hardly do better.
  static double CostWithoutOverlap(const Split& split, const Box4& shared, uint32_t count) {
    const auto endOfLeft = Store(shared.lo), beginOfRight = Store(shared.hi);
    alignas(16) std::array<float, 4> hi = Store(split.leftBounds.hi), lo = Store(split.rightBounds.lo);
    hi[split.axis] = endOfLeft[split.axis];
    lo[split.axis] = beginOfRight[split.axis];
    const Box4 left = {split.leftBounds.lo, Load(hi.data())}, right = {Load(lo.data()), split.rightBounds.hi};
    return left.HalfArea() * split.leftCount + right.HalfArea() * (count - split.leftCount);
  }

  // The best plane that cuts items; costs infinity where none is worth looking at.
  SpatialSplit BestCut(const Range& range, const Split& split) const {
    if (range.room() == 0 || split.axis < 0) return {};
    const Box4 shared = {Max(split.leftBounds.lo, split.rightBounds.lo), Min(split.leftBounds.hi, split.rightBounds.hi)};
    const auto size = Store(Sub(shared.hi, shared.lo));
    if (size[0] < 0 || size[1] < 0 || size[2] < 0) return {};
    if (shared.HalfArea() <= kOverlapOfTree * rootArea_) return {};
    if (CostWithoutOverlap(split, shared, range.size()) > (1 - kLeastGain) * split.cost) return {};
    const Slabs slabs(range.bounds);
    SpatialBins bins;
    const auto fill = [&](size_t begin, size_t end, SpatialBins& into) {
      settings_.cutter->Fill({items_.data() + begin, end - begin}, slabs, into);
    };
    const size_t parts = std::min<size_t>(settings_.threads, range.size() / kBinChunk);
    if (parts < 2) {
      fill(range.begin, range.end, bins);
    } else {
      std::vector<SpatialBins> partial(parts);
      ParallelFor(parts, settings_.threads, [&](size_t part) {
        const auto cut = [&](size_t i) { return range.begin + size_t{range.size()} * i / parts; };
        fill(cut(part), cut(part + 1), partial[part]);
      });
      for (const SpatialBins& part : partial) {
        for (int axis = 0; axis < 3; ++axis) {
          for (uint32_t i = 0; i < kSpatialBins; ++i) {
            bins[axis][i].bounds.Extend(part[axis][i].bounds);
            bins[axis][i].begin += part[axis][i].begin;
            bins[axis][i].end += part[axis][i].end;
          }
        }
      }
    }
    return BestSpatialSplit(slabs, bins, range.size(), range.room());
  }

  // Parts the range at a plane. What lies across stands on both sides, as long as there is room.
  void Cut(const Range& range, const SpatialSplit& spatial, Range& left, Range& right) {
    left = right = Range{};
    const auto extend = [](Range& part, const BuildItem& item) {
      const Vec4 lo = Load(item.lo), hi = Load(item.hi), centre = Add(lo, hi);
      part.bounds.Extend({lo, hi});
      part.centroids.Extend({centre, centre});
    };
    const int axis = spatial.axis;
    uint32_t i = range.begin, j = range.end, end = range.end;
    while (i < j) {
      const BuildItem item = items_[i];
      bool goesLeft = item.hi[axis] <= spatial.plane;
      if (!goesLeft && item.lo[axis] < spatial.plane) {
        BuildItem leftPiece, rightPiece;
        if (end < range.limit && settings_.cutter->Cut(item, axis, spatial.plane, leftPiece, rightPiece)) {
          extend(left, leftPiece);
          extend(right, rightPiece);
          items_[i++] = leftPiece;
          items_[end++] = rightPiece;
          continue;
        }
        goesLeft = item.lo[axis] + item.hi[axis] < 2 * spatial.plane;
      }
      extend(goesLeft ? left : right, item);
      if (goesLeft) {
        ++i;
      } else {
        --j;
        items_[i] = items_[j];
        items_[j] = item;
      }
    }
    left.begin = range.begin;
    left.end = left.limit = right.begin = i;
    right.end = right.limit = end;
  }

  // Room goes to both parts by their sizes; the right one moves up behind the left one's.
  void ShareRoom(uint32_t limit, Range& left, Range& right) {
    const uint64_t room = limit - right.end, both = left.size() + right.size();
    const uint32_t shift = static_cast<uint32_t>(room * left.size() / both);
    const uint32_t moved = std::min(shift, right.size());
    std::copy_n(items_.begin() + right.begin, moved, items_.begin() + std::max(right.end, right.begin + shift));
    left.limit = left.end + shift;
    right.begin += shift;
    right.end += shift;
    right.limit = limit;
  }

  void BinRange(const Range& range, const BinMapping& mapping, Bins& bins) const {
    const uint32_t count = range.size();
    const uint32_t chunks = (count + kBinChunk - 1) / kBinChunk;
    if (settings_.threads == 1 || chunks < 2) {
      FillBins(items_.data(), range.begin, range.end, mapping, bins);
      return;
    }
    // Boxes and counts merge exactly, so how the work was cut does not show.
    std::vector<Bins> partial(std::min<size_t>(settings_.threads, chunks), Bins(mapping.count));
    ParallelFor(partial.size(), settings_.threads, [&](size_t part) {
      const auto cut = [&](size_t i) { return range.begin + static_cast<uint32_t>(count * i / partial.size()); };
      FillBins(items_.data(), cut(part), cut(part + 1), mapping, partial[part]);
    });
    for (const Bins& part : partial) {
      for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t i = 0; i < mapping.count; ++i) {
          Bin& bin = bins.axis[axis][i];
          const Bin& added = part.axis[axis][i];
          bin.lo = Min(bin.lo, added.lo);
          bin.hi = Max(bin.hi, added.hi);
          bin.count += added.count;
        }
      }
    }
  }

  void Partition(const Range& range, const BinMapping& mapping, const Split& split, Range& left, Range& right) {
    left.bounds = split.leftBounds;
    right.bounds = split.rightBounds;
    left.centroids = right.centroids = Box4{};
    const int32_t last = static_cast<int32_t>(mapping.count) - 1;
    const int32_t cut = static_cast<int32_t>(split.bin);
    uint32_t i = range.begin, j = range.end;
    while (i < j) {
      const BuildItem item = items_[i];
      const Vec4 centre = Add(Load(item.lo), Load(item.hi));
      if (std::clamp(mapping.Of(item)[split.axis], 0, last) < cut) {
        left.centroids.Extend({centre, centre});
        ++i;
      } else {
        right.centroids.Extend({centre, centre});
        --j;
        items_[i] = items_[j];
        items_[j] = item;
      }
    }
    left.begin = range.begin;
    left.end = right.begin = i;
    right.end = range.end;
  }

  // Halves by order along the widest axis, ties by index: always makes progress.
  void SplitAtMedian(const Range& range, Range& left, Range& right) {
    const auto lo = Store(range.centroids.lo), hi = Store(range.centroids.hi);
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (hi[i] - lo[i] > hi[axis] - lo[axis]) axis = i;
    }
    const uint32_t middle = range.begin + range.size() / 2;
    std::nth_element(items_.begin() + range.begin, items_.begin() + middle, items_.begin() + range.end,
                     [axis](const BuildItem& a, const BuildItem& b) {
                       const float ca = a.lo[axis] + a.hi[axis], cb = b.lo[axis] + b.hi[axis];
                       return ca != cb ? ca < cb : ItemIndex(a) < ItemIndex(b);
                     });
    left = WholeRange(range.begin, middle);
    right = WholeRange(middle, range.end);
    ShareRoom(range.limit, left, right);
  }

  static BvhNode4 MakeNode(const std::array<Range, 4>& parts, uint32_t count);

  // Puts the tasks' nodes behind the top part, in the order of the tasks, and resolves references to them.
  void Append(std::vector<BvhNode4>& nodes, std::vector<std::vector<BvhNode4>>& parts) const {
    std::vector<uint32_t> bases(parts.size());
    size_t total = nodes.size();
    for (size_t i = 0; i < parts.size(); ++i) {
      bases[i] = static_cast<uint32_t>(total);
      total += parts[i].size();
    }
    for (BvhNode4& node : nodes) {
      for (uint32_t c = 0; c < node.childCount; ++c) {
        if ((node.children[c] & layout::kBvhLeafBit) == 0 && (node.children[c] & kTaskReference) != 0) {
          node.children[c] = bases[node.children[c] & ~kTaskReference];
        }
      }
    }
    nodes.reserve(total);
    for (size_t i = 0; i < parts.size(); ++i) {
      for (BvhNode4 node : parts[i]) {
        for (uint32_t c = 0; c < node.childCount; ++c) {
          if ((node.children[c] & layout::kBvhLeafBit) == 0) node.children[c] += bases[i];
        }
        nodes.push_back(node);
      }
      parts[i] = {};
    }
    nodes.shrink_to_fit();
  }

  // Takes the room that was not needed out of the items.
  void CloseGaps(std::vector<BvhNode4>& nodes) {
    const auto forLeaves = [&](const auto& visit) {
      for (BvhNode4& node : nodes) {
        for (uint32_t c = 0; c < node.childCount; ++c) {
          if (node.children[c] & layout::kBvhLeafBit) visit(node.children[c]);
        }
      }
    };
    std::vector<uint32_t> places(items_.size());
    forLeaves([&](uint32_t leaf) {
      const uint32_t first = leaf & layout::kBvhLeafFirstMask;
      std::fill_n(places.begin() + first, (leaf >> layout::kBvhLeafCountShift & 7u) + 1, 1u);
    });
    uint32_t used = 0;
    for (uint32_t i = 0; i < items_.size(); ++i) {
      const bool isUsed = places[i] != 0;
      places[i] = used;
      if (isUsed) items_[used++] = items_[i];
    }
    items_.resize(used);
    forLeaves([&](uint32_t& leaf) { leaf = (leaf & ~layout::kBvhLeafFirstMask) | places[leaf & layout::kBvhLeafFirstMask]; });
  }

  std::vector<BuildItem>& items_;
  const WideBuildSettings settings_;
  double rootArea_ = 0;
  uint32_t taskItems_ = 0;
  std::vector<Task> tasks_;
};

BvhNode4 Builder::MakeNode(const std::array<Range, 4>& parts, uint32_t count) {
  BvhNode4 node{};
  node.childCount = static_cast<uint8_t>(count);
  std::fill(std::begin(node.children), std::end(node.children), layout::kBvhEmpty);
  std::array<Box4, 4> boxes;
  for (uint32_t i = 0; i < count; ++i) boxes[i] = parts[i].bounds;
  QuantiseBoxes(node, {boxes.data(), count});
  return node;
}

}  // namespace

BuildItem MakeItem(const Float3& lo, const Float3& hi, uint32_t index) {
  const uint32_t disguised = kIndexDisguise | index;
  BuildItem item{{lo.x, lo.y, lo.z, 0}, {hi.x, hi.y, hi.z, 0}};
  std::memcpy(&item.lo[3], &disguised, sizeof disguised);
  return item;
}

uint32_t ItemIndex(const BuildItem& item) {
  uint32_t bits = 0;
  std::memcpy(&bits, &item.lo[3], sizeof bits);
  return bits & ~kIndexDisguise;
}

std::vector<BvhNode4> BuildWide(std::vector<BuildItem>& items, const WideBuildSettings& settings) {
  WAVEFRONT_CHECK(items.size() <= kMaxTriangles, "%zu items", items.size());
  WAVEFRONT_CHECK(settings.maxLeafItems >= 1 && settings.maxLeafItems <= 8, "%u", settings.maxLeafItems);
  WAVEFRONT_CHECK(!settings.leafIsItemIndex || settings.maxLeafItems == 1, "%u", settings.maxLeafItems);
  WAVEFRONT_CHECK(settings.cutter != nullptr || settings.maxPieces == 0, "%u", settings.maxPieces);
  WAVEFRONT_CHECK(settings.maxPieces <= kMaxTriangles - items.size(), "%u", settings.maxPieces);
  return Builder(items, settings).Build();
}

}  // namespace wavefront::bvh
