// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Render vars and files: the AOV that a var's name asks for, and the names of an AOV's channels in an EXR. Pure.
#pragma once

#include <string>
#include <vector>

namespace delegate {

// By our tokens (case and blanks do not matter) and the names that other renderers and USD's documentation use; with
// sourceType "primvar", or the prefix "primvars:", that primvar. Empty: it names no AOV of this renderer.
std::string AovTokenOfVar(const std::string& sourceName, const std::string& sourceType);

// The colour's are R, G, B, A; each other AOV is a layer of its token: albedo.R .G .B, normal.X .Y .Z, depth.Z,
// primId.id, sampleCount.samples, primvars:st.X .Y .Z.
std::vector<std::string> AovChannels(const std::string& token);

}  // namespace delegate
