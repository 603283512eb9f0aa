// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// How large a program is to a driver, which inlines every call before it does anything else.
#include <algorithm>
#include <unordered_map>

#include "materialgen/materialgen.h"

namespace materialgen {
namespace {

// SPIR-V specification 1.6, section 3: opcodes.
constexpr uint32_t kEntryPoint = 15, kFunction = 54, kFunctionEnd = 56, kFunctionCall = 57;
constexpr size_t kHeaderWords = 5;
constexpr uint64_t kMost = uint64_t(1) << 62;

struct Function {
  uint64_t own = 0, inlined = 0;  // inlined: 0 until known
  std::vector<uint32_t> calls;
};

}  // namespace

uint64_t InlinedInstructions(const std::vector<uint32_t>& spirv) {
  std::unordered_map<uint32_t, Function> functions;
  uint32_t entry = 0, current = 0;
  for (size_t at = kHeaderWords; at < spirv.size();) {
    const uint32_t words = spirv[at] >> 16, opcode = spirv[at] & 0xffff;
    if (words == 0 || at + words > spirv.size()) break;
    if (opcode == kEntryPoint && words > 2) entry = spirv[at + 2];
    if (opcode == kFunction && words > 2) current = spirv[at + 2];
    if (current) {
      ++functions[current].own;
      if (opcode == kFunctionCall && words > 3) functions[current].calls.push_back(spirv[at + 3]);
    }
    if (opcode == kFunctionEnd) current = 0;
    at += words;
  }
  // Callees first, without recursion; a cycle, which GLSL does not allow, would count what is known of it.
  std::vector<std::pair<uint32_t, size_t>> stack{{entry, 0}};
  while (!stack.empty()) {
    auto& [id, next] = stack.back();
    Function& function = functions[id];
    if (next == 0) function.inlined = function.own;
    if (next < function.calls.size()) {
      const uint32_t callee = function.calls[next++];
      if (functions[callee].inlined == 0) stack.emplace_back(callee, 0);
      continue;
    }
    for (uint32_t callee : function.calls) function.inlined = std::min(function.inlined + functions[callee].inlined, kMost);
    stack.pop_back();
  }
  return functions[entry].inlined;
}

}  // namespace materialgen
