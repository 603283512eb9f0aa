// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/state_traffic.h"

#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace wavefront {
namespace {

enum BindingNumber : uint32_t {
#define WAVEFRONT_BINDING(Name, number, kind) k##Name = number,
#include "wavefront/shared/bindings.def"
#undef WAVEFRONT_BINDING
};

// Of the SPIR-V specification, section 3.
constexpr uint32_t kMagic = 0x07230203, kHeaderWords = 5;
constexpr uint32_t kOpEntryPoint = 15, kOpFunction = 54, kOpFunctionCall = 57, kOpLoad = 61, kOpStore = 62, kOpAccessChain = 65, kOpDecorate = 71;
constexpr uint32_t kDecorationBinding = 33;

struct Function {
  StateTraffic own;
  std::vector<uint32_t> calls;
};

// Functions do not call themselves in SPIR-V for Vulkan, so this ends; what was summed once is kept.
StateTraffic Sum(uint32_t id, const std::unordered_map<uint32_t, Function>& functions, std::unordered_map<uint32_t, StateTraffic>& known) {
  if (auto found = known.find(id); found != known.end()) return found->second;
  known[id] = {};
  auto function = functions.find(id);
  if (function == functions.end()) return {};
  StateTraffic sum = function->second.own;
  for (uint32_t call : function->second.calls) {
    const StateTraffic part = Sum(call, functions, known);
    sum.chunksRead += part.chunksRead;
    sum.chunksWritten += part.chunksWritten;
  }
  return known[id] = sum;
}

}  // namespace

StateTraffic StateTrafficOf(std::span<const uint32_t> spirv) {
  if (spirv.size() < kHeaderWords || spirv[0] != kMagic) return {};
  uint32_t entry = 0, current = 0;
  std::unordered_set<uint32_t> read, written, elements;  // variables of the two bindings; pointers into the second
  std::unordered_map<uint32_t, Function> functions;
  for (std::size_t at = kHeaderWords; at < spirv.size();) {
    const uint32_t words = spirv[at] >> 16, op = spirv[at] & 0xffffu;
    if (words == 0 || at + words > spirv.size()) return {};
    const auto word = [&](uint32_t i) { return i < words ? spirv[at + i] : 0u; };
    switch (op) {
      case kOpEntryPoint: entry = word(2); break;
      case kOpDecorate:
        if (word(2) != kDecorationBinding) break;
        if (word(3) == kPathStateRead) read.insert(word(1));
        if (word(3) == kPathStateWrite) written.insert(word(1));
        break;
      case kOpFunction: current = word(2); break;
      case kOpFunctionCall: functions[current].calls.push_back(word(3)); break;
      case kOpLoad: functions[current].own.chunksRead += static_cast<uint32_t>(read.count(word(3))); break;
      case kOpAccessChain: if (written.count(word(3))) elements.insert(word(2)); break;
      case kOpStore: functions[current].own.chunksWritten += static_cast<uint32_t>(elements.count(word(1))); break;
      default: break;
    }
    at += words;
  }
  std::unordered_map<uint32_t, StateTraffic> known;
  return Sum(entry, functions, known);
}

}  // namespace wavefront
