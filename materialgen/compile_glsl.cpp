// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <glslang/Include/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <mutex>
#include <string>

#include "materialgen/embedded_glsl.h"
#include "materialgen/materialgen.h"

#if __has_include(<glslang/Public/ResourceLimits.h>)
#include <glslang/Public/ResourceLimits.h>
#define HDWAVEFRONT_GLSLANG_LIMITS GetDefaultResources()
#else
#include <glslang/StandAlone/ResourceLimits.h>
#define HDWAVEFRONT_GLSLANG_LIMITS &glslang::DefaultTBuiltInResource
#endif

namespace materialgen {
namespace {

// Files embedded from the wavefront folder; a name is looked for beside the includer, then under kernels/, then at the
// root.
class Includer final : public glslang::TShader::Includer {
 public:
  IncludeResult* includeLocal(const char* name, const char* includer, size_t) override {
    std::string folder(includer ? includer : "");
    folder.erase(folder.find_last_of('/') == std::string::npos ? 0 : folder.find_last_of('/') + 1);
    for (const std::string& prefix : {folder, std::string("kernels/"), std::string()}) {
      const std::string path = Normalise(prefix + name);
      const std::string_view text = EmbeddedGlsl(path);
      if (text.empty()) continue;
      // An entry point that the megakernel includes is a stage there: only the first text of a program names a version.
      const size_t skip = text.starts_with("#version") ? text.find('\n') : 0;
      return new IncludeResult(path, text.data() + skip, text.size() - skip, nullptr);
    }
    return nullptr;
  }
  IncludeResult* includeSystem(const char* name, const char* includer, size_t depth) override {
    return includeLocal(name, includer, depth);
  }
  void releaseInclude(IncludeResult* result) override { delete result; }

 private:
  // "a/b/../c" to "a/c".
  static std::string Normalise(std::string path) {
    for (size_t at = path.find("/../"); at != std::string::npos && at > 0; at = path.find("/../")) {
      const size_t begin = path.rfind('/', at - 1);
      path.erase(begin == std::string::npos ? 0 : begin + 1, at + 4 - (begin == std::string::npos ? 0 : begin + 1));
    }
    return path;
  }
};

}  // namespace

std::vector<uint32_t> CompileGlsl(const std::string& source, const std::string& name, std::string* error) {
  // Once for the life of the program: finalising while another thread compiles is not safe.
  static std::once_flag initialised;
  std::call_once(initialised, [] { glslang::InitializeProcess(); });

  glslang::TShader shader(EShLangCompute);
  const char* text = source.c_str();
  const int length = int(source.size());
  const char* label = name.c_str();
  shader.setStringsWithLengthsAndNames(&text, &length, &label, 1);
  shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 460);
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
  const auto messages = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);
  Includer includer;
  glslang::TProgram program;
  if (!shader.parse(HDWAVEFRONT_GLSLANG_LIMITS, 460, ENoProfile, false, false, messages, includer)) {
    if (error) *error = name + ":\n" + shader.getInfoLog();
    return {};
  }
  program.addShader(&shader);
  if (!program.link(messages)) {
    if (error) *error = name + ":\n" + program.getInfoLog();
    return {};
  }
  std::vector<uint32_t> spirv;
  glslang::SpvOptions options;
  // The optimiser would halve the size for several times the time of compiling; drivers do the same work anyway.
  options.stripDebugInfo = true;
  options.disableOptimizer = true;
  glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), spirv, &options);
  return spirv;
}

}  // namespace materialgen
