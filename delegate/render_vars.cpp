// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/render_vars.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "wavefront/film.h"

namespace delegate {
namespace {

constexpr std::pair<const char*, const char*> kAliases[] = {
    {"ci", "color"},          {"rgba", "color"}, {"rgb", "color"}, {"beauty", "color"},
    {"lpe:c.*[lo]", "color"}, {"z", "cameraDepth"}, {"n", "normal"},
};

std::string Plain(const std::string& name) {
  std::string plain;
  for (const char c : name)
    if (c != ' ') plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

}  // namespace

std::string AovTokenOfVar(const std::string& sourceName, const std::string& sourceType) {
  const std::string prefix(wavefront::kPrimvarPrefix);
  if (sourceName.starts_with(prefix)) return sourceName.size() > prefix.size() ? sourceName : std::string();
  if (sourceType == "primvar") return sourceName.empty() ? sourceName : prefix + sourceName;
  const std::string name = Plain(sourceName);
  for (const auto& [alias, token] : kAliases)
    if (name == alias) return token;
  for (const wavefront::AovInfo& aov : wavefront::Aovs())
    if (wavefront::FindAov(aov.token) && name == Plain(std::string(aov.token))) return std::string(aov.token);
  return {};
}

std::vector<std::string> AovChannels(const std::string& token) {
  if (token == "color") return {"R", "G", "B", "A"};
  if (token == "sampleCount") return {token + ".samples"};
  if (token == "materialCost") return {token + ".ns"};
  const wavefront::AovInfo* info = wavefront::FindAov(token);
  const bool isInt = info && info->format == wavefront::AovFormat::Int32;
  const uint32_t components = info ? info->components : 3;  // primvars
  if (components == 1) return {token + (isInt ? ".id" : ".Z")};
  const char* names = token == "albedo" ? "RGB" : "XYZW";
  std::vector<std::string> channels;
  for (uint32_t c = 0; c < components; ++c) channels.push_back(token + "." + names[c]);
  return channels;
}

}  // namespace delegate
