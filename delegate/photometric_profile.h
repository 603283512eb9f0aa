// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Measured light profiles: files of the Illuminating Engineering Society (ANSI/IES LM-63, 1986 to 2019), type C.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/scene.h"

namespace delegate {

// Luminous intensity by direction. Angles in degrees, as in the file: vertical 0 is the axis that the lamp points along,
// horizontal runs around it.
struct PhotometricProfile {
  std::vector<float> vertical, horizontal;  // ascending
  std::vector<float> candela;               // a row of vertical.size() for each horizontal angle; the file's multiplier is in

  // Between the angles linearly, symmetries of the file applied; 0 beyond its vertical angles.
  float At(float verticalDegrees, float horizontalDegrees) const;
};

// By the file's name.
bool IsPhotometricProfile(std::string_view path);
// An error names what is wrong with the text.
wavefront::Result<PhotometricProfile> ParsePhotometricProfile(std::string_view text);
// The file, read and parsed.
wavefront::Result<PhotometricProfile> ReadPhotometricProfile(const std::string& path);

// What measured_edf reads: the factor of the colour's radiance. Columns: the angle around the normal, every degree; rows: the
// angle from it, 0 to 90, every half. Scaled so that a surface sends out as much as without a profile (MaterialX calls the
// colour the radiant emittance). An error where the profile sends nothing forward.
wavefront::Result<wavefront::TextureData> EmissionTexture(const PhotometricProfile& profile);

}  // namespace delegate
