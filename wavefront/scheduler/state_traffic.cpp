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
enum Op : uint32_t {
  kOpEntryPoint = 15, kOpConstantTrue = 41, kOpConstantFalse = 42, kOpSpecConstantTrue = 48, kOpSpecConstantFalse = 49, kOpFunction = 54, kOpFunctionEnd = 56,
  kOpFunctionCall = 57, kOpLoad = 61, kOpStore = 62, kOpAccessChain = 65, kOpDecorate = 71, kOpImageFetch = 95, kOpLoopMerge = 246, kOpLabel = 248, kOpBranch = 249,
  kOpBranchConditional = 250, kOpSwitch = 251
};
constexpr uint32_t kDecorationSpecId = 1, kDecorationBinding = 33;
constexpr uint32_t kChunkBytes = 16, kWordBytes = 4;
constexpr uint32_t kChunkChain = 6;  // words of an access chain to a chunk: the block's member, the chunk's index

struct Block {
  StateTraffic own;
  std::vector<uint32_t> calls;  // functions
  std::vector<uint32_t> next;   // labels
  uint32_t loopMerge = 0;       // of a loop's header: where it goes on behind the loop
};
struct Function {
  std::vector<Block> blocks;
  std::unordered_map<uint32_t, std::size_t> places;  // of labels
};

StateTraffic Sum(StateTraffic a, const StateTraffic& b) { return {a.bytesRead + b.bytesRead, a.bytesWritten + b.bytesWritten}; }
uint32_t Total(const StateTraffic& t) { return t.bytesRead + t.bytesWritten; }

class Module {
 public:
  Module(std::span<const uint32_t> spirv, std::span<const std::pair<uint32_t, uint32_t>> specialization)
      : specialization_(specialization.begin(), specialization.end()) {
    valid_ = Read(spirv);
  }
  StateTraffic OfEntryPoint() { return valid_ ? Of(entry_) : StateTraffic{}; }

 private:
  bool Read(std::span<const uint32_t> spirv);
  void Branch(std::span<const uint32_t> words);
  StateTraffic Of(uint32_t function);

  bool valid_ = false;
  uint32_t entry_ = 0;
  std::unordered_set<uint32_t> read_, written_, images_;  // variables of the two bindings; the first, loaded
  std::unordered_map<uint32_t, uint32_t> elements_;       // bytes behind pointers into the second
  std::unordered_map<uint32_t, uint32_t> specialization_, specIds_;  // values by constant_id; that by the constant
  std::unordered_map<uint32_t, bool> constants_;
  std::unordered_map<uint32_t, Function> functions_;
  std::unordered_map<uint32_t, StateTraffic> known_;
  Function* function_ = nullptr;
};

bool Module::Read(std::span<const uint32_t> spirv) {
  if (spirv.size() < kHeaderWords || spirv[0] != kMagic) return false;
  Block outside;  // of instructions in no block, which move nothing
  for (std::size_t at = kHeaderWords; at < spirv.size();) {
    const uint32_t count = spirv[at] >> 16, op = spirv[at] & 0xffffu;
    if (count == 0 || at + count > spirv.size()) return false;
    const std::span<const uint32_t> words = spirv.subspan(at, count);
    const auto word = [&](uint32_t i) { return i < count ? words[i] : 0u; };
    Block& block = function_ != nullptr && !function_->blocks.empty() ? function_->blocks.back() : outside;
    switch (op) {
      case kOpEntryPoint: entry_ = word(2); break;
      case kOpDecorate:
        if (word(2) == kDecorationSpecId) specIds_[word(1)] = word(3);
        if (word(2) != kDecorationBinding) break;
        if (word(3) == kPathStateRead) read_.insert(word(1));
        if (word(3) == kPathStateWrite) written_.insert(word(1));
        break;
      case kOpConstantTrue: case kOpConstantFalse: constants_[word(2)] = op == kOpConstantTrue; break;
      case kOpSpecConstantTrue: case kOpSpecConstantFalse: {
        const auto given = specialization_.find(specIds_.count(word(2)) ? specIds_[word(2)] : ~0u);
        constants_[word(2)] = given == specialization_.end() ? op == kOpSpecConstantTrue : given->second != 0;
        break;
      }
      case kOpFunction: function_ = &functions_[word(2)]; break;
      case kOpFunctionEnd: function_ = nullptr; break;
      case kOpLabel:
        if (function_ == nullptr) return false;
        function_->places[word(1)] = function_->blocks.size();
        function_->blocks.emplace_back();
        break;
      case kOpFunctionCall: block.calls.push_back(word(3)); break;
      case kOpLoad:
        if (read_.count(word(3))) images_.insert(word(2));
        if (auto from = elements_.find(word(3)); from != elements_.end()) block.own.bytesRead += from->second;
        break;
      case kOpImageFetch: block.own.bytesRead += images_.count(word(3)) ? kChunkBytes : 0; break;
      case kOpAccessChain: if (written_.count(word(3))) elements_[word(2)] = count > kChunkChain ? kWordBytes : kChunkBytes; break;
      case kOpStore: if (auto to = elements_.find(word(1)); to != elements_.end()) block.own.bytesWritten += to->second; break;
      case kOpLoopMerge: block.loopMerge = word(1); break;
      case kOpBranch: case kOpBranchConditional: case kOpSwitch:
        if (function_ != nullptr && !function_->blocks.empty()) Branch(words);
        break;
      default: break;
    }
    at += count;
  }
  return true;
}

// Where the last block goes on. Conditions that are constants are decided: GLSL's `if (kHas...)`.
void Module::Branch(std::span<const uint32_t> words) {
  const uint32_t op = words[0] & 0xffffu;
  std::vector<uint32_t>& next = function_->blocks.back().next;
  if (op == kOpBranch && words.size() > 1) next = {words[1]};
  if (op == kOpBranchConditional && words.size() > 3) {
    const auto decided = constants_.find(words[1]);
    if (decided == constants_.end()) next = {words[2], words[3]};
    else next = {decided->second ? words[2] : words[3]};
  }
  if (op == kOpSwitch) {
    for (std::size_t i = 2; i < words.size(); i += 2) next.push_back(words[i]);  // the default, then (literal, label)
  }
}

// The way through the function that moves most; loops are gone through once.
StateTraffic Module::Of(uint32_t id) {
  if (auto found = known_.find(id); found != known_.end()) return found->second;
  known_[id] = {};  // functions do not call themselves in SPIR-V for Vulkan; a broken module must end, too
  const auto found = functions_.find(id);
  if (found == functions_.end()) return {};
  const Function& f = found->second;
  std::vector<StateTraffic> most(f.blocks.size());
  // Blocks stand behind those that lead to them, but for the ends of loops, which go on behind the loop here.
  for (std::size_t b = f.blocks.size(); b-- > 0;) {
    const Block& block = f.blocks[b];
    StateTraffic rest;
    for (uint32_t label : block.next) {
      auto to = f.places.find(label);
      if (to != f.places.end() && to->second <= b) to = f.places.find(f.blocks[to->second].loopMerge);
      if (to == f.places.end() || to->second <= b) continue;
      if (Total(most[to->second]) > Total(rest)) rest = most[to->second];
    }
    StateTraffic own = block.own;
    for (uint32_t call : block.calls) own = Sum(own, Of(call));
    most[b] = Sum(own, rest);
  }
  return known_[id] = f.blocks.empty() ? StateTraffic{} : most[0];
}

}  // namespace

StateTraffic StateTrafficOf(std::span<const uint32_t> spirv, std::span<const std::pair<uint32_t, uint32_t>> specialization) {
  return Module(spirv, specialization).OfEntryPoint();
}

}  // namespace wavefront
