// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Hands out ranges of a growing stream; freed ranges are merged and used again, first fit.
#pragma once

#include <cstdint>
#include <map>

namespace wavefront {

struct Range {
  uint32_t first = 0, count = 0;
};

class RangeAllocator {
 public:
  // Elements of the stream that must exist, grown or not.
  uint32_t end() const { return end_; }

  Range Allocate(uint32_t count) {
    if (count == 0) return {};
    for (auto it = free_.begin(); it != free_.end(); ++it) {
      if (it->second < count) continue;
      Range range{it->first, count};
      uint32_t left = it->second - count;
      free_.erase(it);
      if (left != 0) free_[range.first + count] = left;
      return range;
    }
    Range range{end_, count};
    end_ += count;
    return range;
  }

  void Free(Range range) {
    if (range.count == 0) return;
    auto next = free_.lower_bound(range.first);
    if (next != free_.end() && range.first + range.count == next->first) {
      range.count += next->second;
      next = free_.erase(next);
    }
    if (next != free_.begin()) {
      auto previous = std::prev(next);
      if (previous->first + previous->second == range.first) {
        range = {previous->first, previous->second + range.count};
        free_.erase(previous);
      }
    }
    if (range.first + range.count == end_) end_ = range.first;
    else free_[range.first] = range.count;
  }

 private:
  std::map<uint32_t, uint32_t> free_;  // first -> count
  uint32_t end_ = 0;
};

}  // namespace wavefront
