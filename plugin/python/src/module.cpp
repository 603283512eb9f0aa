// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// The extension module hdwavefront._core. Each file of this folder binds one thing and is called from here.
#include "plugin/python/src/bindings.h"

NB_MODULE(_core, module) {
  module.doc() = "hdWavefront's core: renderer, delegate and material generator";
  BindBuildFacts(module);
  BindRegistries(module);
  BindRayCaster(module);
  BindValues(module);
  BindDelegate(module);
}
