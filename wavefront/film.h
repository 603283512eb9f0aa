// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// AOVs: what can be asked for and how it is handed out.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

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
const AovInfo* FindAov(std::string_view token);      // null: unknown

// A resolved AOV: width * height * components 32-bit values, row 0 at the *top*.
struct AovImage {
  Aov aov{};
  uint32_t width = 0, height = 0, components = 0;
  std::vector<uint32_t> bits;  // float or int32 by the AOV's format
};

}  // namespace wavefront
