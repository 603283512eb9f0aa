// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/driver_compile.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace wavefront::vulkan {
namespace {

std::string Environment(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr ? text : "";
}

// As Mesa reads its switches.
bool IsTrue(const std::string& text) { return text == "1" || text == "true" || text == "TRUE" || text == "y" || text == "yes"; }

// The folder, or the nearest one above it that exists: can files be made there?
bool IsWritable(std::filesystem::path folder) {
  std::error_code error;
  while (!folder.empty() && !std::filesystem::exists(folder, error)) {
    if (folder == folder.parent_path()) return false;
    folder = folder.parent_path();
  }
  return std::filesystem::is_directory(folder, error) && access(folder.c_str(), W_OK | X_OK) == 0;
}

// Mesa's rules (src/util/disk_cache_os.c): its own variable, else XDG's, else the home folder.
std::filesystem::path MesaCacheFolder() {
  for (const char* name : {"MESA_SHADER_CACHE_DIR", "MESA_GLSL_CACHE_DIR", "XDG_CACHE_HOME"}) {
    if (const std::string folder = Environment(name); !folder.empty()) return folder;
  }
  const std::string home = Environment("HOME");
  return home.empty() ? std::filesystem::path() : std::filesystem::path(home) / ".cache";
}

}  // namespace

DriverCompile DriverCompileOf(const DeviceInfo& info, std::string* why) {
  if (info.driverName != "llvmpipe") return DriverCompile::AtCreation;
  for (const char* name : {"MESA_SHADER_CACHE_DISABLE", "MESA_GLSL_CACHE_DISABLE"}) {
    if (!IsTrue(Environment(name))) continue;
    *why = std::string(name) + " switches Mesa's shader cache off";
    return DriverCompile::AtDispatch;
  }
  const std::filesystem::path folder = MesaCacheFolder();
  if (!IsWritable(folder)) {
    *why = folder.empty() ? "there is no folder for Mesa's shader cache"
                          : "Mesa's shader cache cannot be written to " + folder.string();
    return DriverCompile::AtDispatch;
  }
  return DriverCompile::AtDispatchCached;
}

}  // namespace wavefront::vulkan
