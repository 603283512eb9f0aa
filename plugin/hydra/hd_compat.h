// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// All differences between OpenUSD 24.05 and 26.x that this plugin meets. Nothing else in the plugin asks for a version.
#pragma once

#include <pxr/pxr.h>

#include <pxr/imaging/hd/rendererPlugin.h>
#include <pxr/imaging/hd/version.h>

#if PXR_VERSION < 2405
#error "hdWavefront needs OpenUSD 24.05 or later"
#endif

// 25.11: hosts hand HdRendererCreateArgs (the Hgi, whether the GPU is on) to IsSupported in place of a bool.
#if __has_include(<pxr/imaging/hd/rendererCreateArgs.h>)
#include <pxr/imaging/hd/rendererCreateArgs.h>
#define HDWAVEFRONT_HAS_CREATE_ARGS 1
#else
#define HDWAVEFRONT_HAS_CREATE_ARGS 0
#endif

namespace hydra {
PXR_NAMESPACE_USING_DIRECTIVE
}
