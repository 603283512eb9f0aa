// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <nanobind/nanobind.h>

/// Adds `__version__` and `build_facts()`, what `hdwavefront doctor` prints about the build.
void BindBuildFacts(nanobind::module_& module);
