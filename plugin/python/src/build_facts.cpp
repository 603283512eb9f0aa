// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <nanobind/stl/string.h>

#include "plugin/python/src/bindings.h"

namespace nb = nanobind;

void BindBuildFacts(nb::module_& module) {
  module.attr("__version__") = HDWAVEFRONT_VERSION;
  module.def(
      "build_facts",
      [] {
        nb::dict facts;
        facts["version"] = HDWAVEFRONT_VERSION;
        facts["build_type"] = HDWAVEFRONT_BUILD_TYPE;
        facts["sanitizers"] = HDWAVEFRONT_SANITIZE;
        facts["compiler"] = HDWAVEFRONT_COMPILER;
        facts["materialx"] = HDWAVEFRONT_MATERIALX_VERSION;
        facts["glslang"] = HDWAVEFRONT_GLSLANG_VERSION;
        return facts;
      },
      "How this module was built, as a dict of strings: version, build_type, sanitizers, compiler, materialx, "
      "glslang.");
}
