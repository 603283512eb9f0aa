// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/film.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "wavefront/renderer.h"
#include "wavefront/shared/film_layout.h"

namespace wavefront {
namespace {
constexpr AovInfo kAovs[] = {
#define WAVEFRONT_AOV(name, token, components, format, clear, rule, doc) \
  {Aov::name, token, components, AovFormat::format, clear, AovRule::rule, doc},
#include "wavefront/shared/aovs.def"
#undef WAVEFRONT_AOV
};
uint32_t ClearBits(const AovInfo& info) {
  return info.format == AovFormat::Float32 ? std::bit_cast<uint32_t>(info.clear) : static_cast<uint32_t>(static_cast<int32_t>(info.clear));
}
}  // namespace

std::span<const AovInfo> Aovs() { return kAovs; }
const AovInfo* FindAov(std::string_view token) {
  for (const AovInfo& info : kAovs) if (info.token == token && !IsPrimvarAov(info.aov)) return &info;
  return nullptr;
}

std::optional<Aov> FindAov(std::string_view token, std::span<const std::string> primvars) {
  if (const AovInfo* info = FindAov(token)) return info->aov;
  if (!token.starts_with(kPrimvarPrefix)) return std::nullopt;
  const auto found = std::find(primvars.begin(), primvars.end(), token.substr(kPrimvarPrefix.size()));
  if (found == primvars.end()) return std::nullopt;
  return PrimvarAov(static_cast<uint32_t>(found - primvars.begin()));
}

Result<AovSelection> SelectAovs(std::span<const std::string> tokens) {
  AovSelection selection;
  for (const std::string& token : tokens) {
    if (token.starts_with(kPrimvarPrefix) && token.size() > kPrimvarPrefix.size() && !FindAov(token, selection.primvars)) {
      if (selection.primvars.size() == kMaxPrimvarAovs)
        return Error{"at most " + std::to_string(kMaxPrimvarAovs) + " primvars can be AOVs of one render; " + token + " is one too many"};
      selection.primvars.push_back(token.substr(kPrimvarPrefix.size()));
    }
    const std::optional<Aov> aov = FindAov(token, selection.primvars);
    if (!aov) {
      std::string known;
      for (const AovInfo& info : kAovs) if (!IsPrimvarAov(info.aov)) known += std::string(info.token) + ", ";
      return Error{"there is no AOV \"" + token + "\"; there are: " + known + "primvars:<name>"};
    }
    if (std::find(selection.aovs.begin(), selection.aovs.end(), *aov) == selection.aovs.end()) selection.aovs.push_back(*aov);
  }
  return selection;
}

FilmLayout MakeFilmLayout(const std::vector<Aov>& aovs) {
  FilmLayout film;
  for (uint32_t& c : film.channel) c = layout::kNoChannel;
  auto sum = [&](Aov aov, uint32_t components) {
    film.channel[static_cast<uint32_t>(aov)] = film.sumChannels;
    film.sumChannels += components;
  };
  sum(Aov::Color, 4);
  sum(Aov::SampleCount, 1);
  for (const AovInfo& info : kAovs) {
    if (std::find(aovs.begin(), aovs.end(), info.aov) == aovs.end() || film.of(info.aov) != layout::kNoChannel) continue;
    if (info.rule == AovRule::Mean) {
      sum(info.aov, info.components);
    } else {
      film.channel[static_cast<uint32_t>(info.aov)] = film.firstChannels;
      film.firstChannels += info.components;
      film.firstClear.insert(film.firstClear.end(), info.components, ClearBits(info));
    }
  }
  return film;
}

Result<RawFilm> MergeFilms(const RawFilm& a, const RawFilm& b) {
  if (a.samples == 0) return b;
  if (b.samples == 0) return a;
  if (a.width != b.width || a.height != b.height || a.sums.size() != b.sums.size() || a.first.size() != b.first.size() || a.aovs != b.aovs || a.primvarAovs != b.primvarAovs) {
    return Error{"films of different size or different AOVs cannot be merged"};
  }
  const RawFilm& lower = a.firstSample <= b.firstSample ? a : b;
  const RawFilm& upper = &lower == &a ? b : a;
  if (!a.complete || !b.complete) return Error{"a render that was stopped early cannot be merged: nobody knows which samples it holds"};
  if (lower.firstSample + lower.samples > upper.firstSample) return Error{"the sample ranges overlap: the same samples would count twice"};
  if (lower.firstSample + lower.samples < upper.firstSample) return Error{"the sample ranges are not neighbours: merge what lies between first"};
  RawFilm merged = lower;
  merged.samples = lower.samples + upper.samples;
  for (std::size_t i = 0; i < merged.sums.size(); ++i) merged.sums[i] += upper.sums[i];
  return merged;
}

AovImage ResolveFilm(const RawFilm& film, Aov aov) {
  const FilmLayout where = MakeFilmLayout(film.aovs);
  const AovInfo& info = kAovs[static_cast<uint32_t>(aov)];
  AovImage image{aov, film.width, film.height, info.components, {}};
  const std::size_t pixels = static_cast<std::size_t>(film.width) * film.height;
  image.bits.assign(pixels * info.components, ClearBits(info));
  const uint32_t channel = where.of(aov), count = where.of(Aov::SampleCount);
  if (channel == layout::kNoChannel) return image;
  constexpr float kScale = static_cast<float>(1.0 / layout::kFilmScale);
  for (std::size_t p = 0; p < pixels; ++p) {
    for (uint32_t c = 0; c < info.components; ++c) {
      if (info.rule == AovRule::FirstSample) {
        image.bits[p * info.components + c] = film.first[p * where.firstChannels + channel + c];
        continue;
      }
      const float sum = static_cast<float>(film.sums[p * where.sumChannels + channel + c]) * kScale;
      const float n = static_cast<float>(film.sums[p * where.sumChannels + count]) * kScale;
      image.bits[p * info.components + c] = std::bit_cast<uint32_t>(aov == Aov::SampleCount ? sum : (n > 0 ? sum / n : 0.0f));
    }
  }
  return image;
}

}  // namespace wavefront
