// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which RenderSettings prim is the active one, OpenUSD tells to renderers that ask for it by a scene index of its own.
// Registered as a function, not as a HdSceneIndexPlugin: that class has gained virtual functions between versions.
#include <pxr/base/tf/registryManager.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/sceneIndexPlugin.h>
#include <pxr/imaging/hd/sceneIndexPluginRegistry.h>
#include <pxr/imaging/hdsi/renderSettingsFilteringSceneIndex.h>

#include "plugin/hydra/convert_settings.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
  const HdContainerDataSourceHandle arguments = HdRetainedContainerDataSource::New(
      HdsiRenderSettingsFilteringSceneIndexTokens->namespacePrefixes,
      HdRetainedTypedSampledDataSource<VtArray<TfToken>>::New({TfToken(hydra::kSettingsNamespace)}));
  HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
      "Wavefront",
      [](const std::string&, const HdSceneIndexBaseRefPtr& input,
         const HdContainerDataSourceHandle& args) -> HdSceneIndexBaseRefPtr {
        return HdsiRenderSettingsFilteringSceneIndex::New(input, args);
      },
      arguments, /*insertionPhase=*/0, HdSceneIndexPluginRegistry::InsertionOrderAtStart);
}

PXR_NAMESPACE_CLOSE_SCOPE
