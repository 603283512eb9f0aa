// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <nanobind/nanobind.h>

#include "delegate/render_delegate.h"

/// Adds `__version__` and `build_facts()`, what `hdwavefront doctor` prints about the build.
void BindBuildFacts(nanobind::module_& module);

/// Adds `list_devices()`, `render_settings()`, `aovs()`, `aov_of_render_var()`, `aov_channels()`.
void BindRegistries(nanobind::module_& module);

/// Adds RayCaster.
void BindRayCaster(nanobind::module_& module);

/// Adds Diagnostic, TextureRequest, Film.
void BindValues(nanobind::module_& module);

/// Adds RenderDelegate; the three that follow add groups of its methods.
void BindDelegate(nanobind::module_& module);
using DelegateClass = nanobind::class_<delegate::RenderDelegate>;
void BindGprimSync(DelegateClass& type);
void BindSprimSync(DelegateClass& type);
void BindRender(DelegateClass& type);

/// Raises: ValueError for arguments that make no sense, RuntimeError for the environment. Call with the GIL.
[[noreturn]] void RaiseValue(const std::string& message);
[[noreturn]] void RaiseType(const std::string& message);
[[noreturn]] void RaiseRuntime(const std::string& message);
