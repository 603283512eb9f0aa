// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/host_time.h"

#include <pxr/imaging/hd/dataSource.h>
#include <pxr/imaging/hd/dataSourceTypeDefs.h>
#include <pxr/imaging/hd/sceneIndex.h>

#include <cmath>

namespace hydra {
namespace {

// By name, not by HdSceneGlobalsSchema: which members that has depends on the version.
std::optional<double> Number(const HdContainerDataSourceHandle& globals, const char* name) {
  const auto source = HdDoubleDataSource::Cast(globals->Get(TfToken(name)));
  const double value = source ? source->GetTypedValue(0) : std::nan("");
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<HostTime> ReadHostTime(const HdRenderIndex& index) {
  const HdSceneIndexBaseRefPtr scene = index.GetTerminalSceneIndex();
  if (!scene) return std::nullopt;
  const HdContainerDataSourceHandle root = scene->GetPrim(SdfPath::AbsoluteRootPath()).dataSource;
  const auto globals = root ? HdContainerDataSource::Cast(root->Get(TfToken("sceneGlobals"))) : nullptr;
  const std::optional<double> frame = globals ? Number(globals, "currentFrame") : std::nullopt;
  if (!frame) return std::nullopt;
  // Where the host does not tell, UsdStage's fallback.
  const double framesPerSecond = Number(globals, "timeCodesPerSecond").value_or(24);
  return HostTime{*frame, framesPerSecond > 0 ? *frame / framesPerSecond : 0};
}

}  // namespace hydra
