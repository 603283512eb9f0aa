// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which channel of the film holds which AOV. Sums: colour R G B A, count, then the other Mean AOVs asked for.
// First: the words of the FirstSample AOVs asked for, in the order of aovs.def.
#pragma once

#include <cstdint>
#include <vector>

#include "wavefront/film.h"
#include "wavefront/shared/frame_constants.h"

namespace wavefront {

struct FilmLayout {
  uint32_t sumChannels = 0, firstChannels = 0;
  uint32_t channel[static_cast<uint32_t>(Aov::kCount)];  // of each AOV in its array; kNoChannel: not held
  std::vector<uint32_t> firstClear;                      // bits per First channel

  uint32_t of(Aov aov) const { return channel[static_cast<uint32_t>(aov)]; }
};
// Colour and count are always held.
FilmLayout MakeFilmLayout(const std::vector<Aov>& aovs);

}  // namespace wavefront
