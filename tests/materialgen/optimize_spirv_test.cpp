// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "materialgen/materialgen.h"

namespace materialgen {
namespace {

constexpr uint32_t kFunctionCall = 57, kFMul = 133;

std::multiset<uint32_t> Opcodes(const std::vector<uint32_t>& spirv) {
  std::multiset<uint32_t> found;
  for (size_t at = 5; at < spirv.size(); at += std::max(1u, spirv[at] >> 16)) found.insert(spirv[at] & 0xffff);
  return found;
}
std::vector<uint32_t> Compile(const std::string& body) {
  std::string error;
  auto spirv = CompileGlsl("#version 460\nlayout(local_size_x = 1) in;\nlayout(binding = 0) buffer B { float b[]; };\n" + body, "test", &error);
  EXPECT_FALSE(spirv.empty()) << error;
  return spirv;
}

TEST(OptimizeSpirv, InlinesCalls) {
  const auto spirv = Compile("float f(float x) { for (int i = 0; i < 9; ++i) if (x > b[i]) return x; return 2 * x; }\n"
                             "void main() { b[0] = f(b[1]) + f(b[2]); }\n");
  ASSERT_EQ(Opcodes(spirv).count(kFunctionCall), 2u);
  EXPECT_EQ(Opcodes(OptimizeSpirv(spirv)).count(kFunctionCall), 0u);  // all passes are known to this version, too
}

// What regroups numbers would make a kernel's bits differ from those of the same code in the megakernel.
TEST(OptimizeSpirv, LeavesArithmeticAsItIs) {
  const auto optimized = Opcodes(OptimizeSpirv(Compile("void main() { b[0] = b[1] * 3.0 * 0.1 / 7.0 * 0.3; }\n")));
  EXPECT_EQ(optimized.count(kFMul), 3u);
}

TEST(OptimizeSpirv, LeavesWhatWouldTakeLong) {
  std::string body = "float f(float x) { x = sin(x); x = cos(x); x = sin(x); x = cos(x); return x; }\n";
  for (char level = 'g'; level < 'n'; ++level)
    body += std::string("float ") + level + "(float x) { return " + char(level - 1) + "(x) + " + char(level - 1) + "(x + 1) + " +
            char(level - 1) + "(x + 2) + " + char(level - 1) + "(x + 3); }\n";
  const auto spirv = Compile(body + "void main() { b[0] = m(b[1]); }\n");
  ASSERT_GT(InlinedInstructions(spirv), kOptimizedInstructions);
  EXPECT_EQ(OptimizeSpirv(spirv), spirv);
  EXPECT_EQ(OptimizeSpirv({}), std::vector<uint32_t>{});
}

}  // namespace
}  // namespace materialgen
