// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// AOVs: what can be asked for and how it is handed out.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "wavefront/base/result.h"

namespace wavefront {

// One enumerator per row of shared/aovs.def, in its order.
enum class Aov : uint32_t {
#define WAVEFRONT_AOV(name, token, components, format, clear, rule, doc) name,
#include "wavefront/shared/aovs.def"
#undef WAVEFRONT_AOV
  kCount
};

enum class AovFormat : uint8_t { Float32, Int32 };
enum class AovRule : uint8_t { Mean, FirstSample };  // see aovs.def

struct AovInfo {
  Aov aov;
  std::string_view token;  // Hydra's name
  uint32_t components;
  AovFormat format;
  float clear;
  AovRule rule;
  std::string_view doc;
};
std::span<const AovInfo> Aovs();                     // by enumerator
const AovInfo* FindAov(std::string_view token);      // null: unknown; never a Primvar slot

// What a host asks for by token. "primvars:<name>" takes the next of the slots Aov::Primvar0 ... in the order asked.
constexpr uint32_t kMaxPrimvarAovs = 4;
struct AovSelection {
  std::vector<Aov> aovs;              // each once, in order of first mention
  std::vector<std::string> primvars;  // names by slot, without the prefix
};
inline constexpr std::string_view kPrimvarPrefix = "primvars:";
constexpr Aov PrimvarAov(uint32_t slot) { return static_cast<Aov>(static_cast<uint32_t>(Aov::Primvar0) + slot); }
constexpr bool IsPrimvarAov(Aov aov) { return aov >= Aov::Primvar0 && aov < PrimvarAov(kMaxPrimvarAovs); }
// An error for tokens that are unknown and for more primvars than there are slots.
Result<AovSelection> SelectAovs(std::span<const std::string> tokens);
// The AOV of a token where the slots hold `primvars`; nothing: unknown, or a primvar that no slot holds.
std::optional<Aov> FindAov(std::string_view token, std::span<const std::string> primvars);

// A resolved AOV: width * height * components 32-bit values, row 0 at the *top*.
struct AovImage {
  Aov aov{};
  uint32_t width = 0, height = 0, components = 0;
  std::vector<uint32_t> bits;  // float or int32 by the AOV's format
};

}  // namespace wavefront
