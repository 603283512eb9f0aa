// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/primvars.h"

#include <cmath>
#include <optional>
#include <set>

namespace delegate {
namespace {

constexpr const char* kCode = "mesh-bad-primvar";

std::optional<AuthoredInterpolation> ReadInterpolation(const std::string& token) {
  if (token.empty() || token == "constant") return AuthoredInterpolation::Constant;
  if (token == "uniform") return AuthoredInterpolation::Uniform;
  if (token == "vertex") return AuthoredInterpolation::Vertex;
  if (token == "varying") return AuthoredInterpolation::Varying;
  if (token == "faceVarying") return AuthoredInterpolation::FaceVarying;
  return std::nullopt;
}

size_t ElementsNeeded(AuthoredInterpolation interpolation, const MeshInput& input, const CheckedTopology& topology) {
  switch (interpolation) {
    case AuthoredInterpolation::Constant: return 1;
    case AuthoredInterpolation::Uniform: return input.topology.faceVertexCounts.size();
    case AuthoredInterpolation::Vertex:
    case AuthoredInterpolation::Varying: return input.points.size();
    case AuthoredInterpolation::FaceVarying: return topology.cornerCount;
  }
  return 0;
}

bool IndicesInRange(const PrimvarInput& primvar, size_t needed, size_t elements) {
  for (size_t i = 0; i < needed; ++i)
    if (primvar.indices[i] < 0 || static_cast<size_t>(primvar.indices[i]) >= elements) return false;
  return true;
}

// `needed` elements are copied; the caller has checked that they exist.
void CopyValues(const PrimvarInput& in, size_t needed, CheckedPrimvar& out) {
  const size_t n = in.components;
  if (in.indices.empty()) {
    out.values.assign(in.values.begin(), in.values.begin() + static_cast<std::ptrdiff_t>(needed * n));
  } else if (out.interpolation == AuthoredInterpolation::FaceVarying) {
    out.values = in.values;
    out.indices.assign(in.indices.begin(), in.indices.begin() + static_cast<std::ptrdiff_t>(needed));
  } else {
    out.values.resize(needed * n);
    for (size_t i = 0; i < needed; ++i)
      for (size_t c = 0; c < n; ++c) out.values[i * n + c] = in.values[static_cast<size_t>(in.indices[i]) * n + c];
  }
}

void ReplaceNonFinite(CheckedPrimvar& primvar, const std::string& what, const MeshReport& report) {
  Tally bad;
  for (size_t i = 0; i < primvar.values.size(); ++i) {
    if (std::isfinite(primvar.values[i])) continue;
    primvar.values[i] = 0;
    bad.Add(static_cast<int64_t>(i / primvar.components));
  }
  if (bad.count)
    report.Warn(kCode, what + " has " + std::to_string(bad.count) + " values that are not finite (first: element " +
                           std::to_string(bad.first) + "); they are set to 0.");
}

std::optional<CheckedPrimvar> CheckOne(const PrimvarInput& in, const MeshInput& input, const CheckedTopology& topology,
                                       const MeshReport& report) {
  const std::string what = "Primvar \"" + in.name + "\"";
  const auto drop = [&](const std::string& why) {
    report.Warn(kCode, what + " " + why + "; left out.");
    return std::nullopt;
  };
  const auto interpolation = ReadInterpolation(in.interpolation);
  if (!interpolation) return drop("has the unknown interpolation \"" + in.interpolation + "\"");
  const uint32_t n = in.components;
  if (!((n >= 1 && n <= 4) || n == 16)) return drop("has " + std::to_string(n) + " components, not 1 to 4 or 16");
  if (in.name == "normals" && n != 3) return drop("has " + std::to_string(n) + " components, not 3");
  if (in.values.size() % n != 0) return drop("has a number of values that its " + std::to_string(n) + " components do not divide");
  const size_t elements = in.values.size() / n;
  const size_t needed = ElementsNeeded(*interpolation, input, topology);
  const size_t given = in.indices.empty() ? elements : in.indices.size();
  const std::string token = in.interpolation.empty() ? "constant" : in.interpolation;
  if (given < needed)
    return drop("(" + token + ") has " + std::to_string(given) + " elements where the mesh needs " + std::to_string(needed));
  if (!in.indices.empty() && !IndicesInRange(in, needed, elements))
    return drop("has indices outside its " + std::to_string(elements) + " values");
  const bool spansUnusedIndices = *interpolation == AuthoredInterpolation::FaceVarying && given == input.topology.faceVertexIndices.size();
  if (given > needed && !spansUnusedIndices)
    report.Warn(kCode, what + " (" + token + ") has " + std::to_string(given) + " elements where the mesh needs " +
                           std::to_string(needed) + "; the rest is ignored.");
  CheckedPrimvar out;
  out.name = in.name;
  out.interpolation = *interpolation;
  out.components = n;
  CopyValues(in, needed, out);
  ReplaceNonFinite(out, what, report);
  return out;
}

}  // namespace

std::vector<CheckedPrimvar> CheckPrimvars(const MeshInput& input, const CheckedTopology& topology, const MeshReport& report) {
  std::vector<CheckedPrimvar> result;
  std::set<std::string> names;
  for (const PrimvarInput& primvar : input.primvars) {
    if (primvar.name == "normals" && topology.scheme != Scheme::None) {
      report.Info("mesh-normals-ignored", "Authored normals are ignored because the mesh is a subdivision surface.");
      continue;
    }
    if (!names.insert(primvar.name).second) {
      report.Warn(kCode, "Primvar \"" + primvar.name + "\" is given twice; the first is taken.");
      continue;
    }
    if (auto checked = CheckOne(primvar, input, topology, report)) result.push_back(std::move(*checked));
  }
  return result;
}

}  // namespace delegate
