// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "tests/kernel_runner/glsl.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>

namespace kernel_runner {
namespace {

// #include "x" looks beside the including file first, then in the folders; #include <x> in the folders only.
class Includer : public glslang::TShader::Includer {
 public:
  explicit Includer(const std::vector<std::string>& folders) : folders_(folders) {}

  IncludeResult* includeSystem(const char* header, const char*, size_t) override {
    for (const std::string& folder : folders_) {
      if (IncludeResult* found = Open(std::filesystem::path(folder) / header)) return found;
    }
    return nullptr;
  }
  IncludeResult* includeLocal(const char* header, const char* includer, size_t depth) override {
    if (includer != nullptr && includer[0] != '\0') {
      if (IncludeResult* found = Open(std::filesystem::path(includer).parent_path() / header)) return found;
    }
    return includeSystem(header, includer, depth);
  }
  void releaseInclude(IncludeResult* result) override {
    if (result == nullptr) return;
    delete static_cast<std::string*>(result->userData);
    delete result;
  }

 private:
  IncludeResult* Open(const std::filesystem::path& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return nullptr;
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    auto content = std::make_unique<std::string>(text.str());
    const std::string name = std::filesystem::weakly_canonical(path, ignored).string();
    auto* result = new IncludeResult(name, content->data(), content->size(), content.get());
    content.release();
    return result;
  }
  const std::vector<std::string>& folders_;
};

EShLanguage StageOf(const std::string& stage) {
  if (stage == "comp") return EShLangCompute;
  if (stage == "vert") return EShLangVertex;
  if (stage == "frag") return EShLangFragment;
  throw std::runtime_error("unknown shader stage '" + stage + "' (comp, vert or frag)");
}

}  // namespace

std::vector<uint32_t> CompileGlsl(const std::string& source, const std::string& stage,
                                  const std::vector<std::string>& includeFolders) {
  static std::once_flag once;
  std::call_once(once, [] { glslang::InitializeProcess(); });
  const EShLanguage language = StageOf(stage);
  glslang::TShader shader(language);
  const char* text = source.c_str();
  const int length = static_cast<int>(source.size());
  const char* name = "";
  shader.setStringsWithLengthsAndNames(&text, &length, &name, 1);
  // Allows #include even where the source does not name the extension.
  shader.setPreamble("#extension GL_GOOGLE_include_directive : require\n");
  shader.setEnvInput(glslang::EShSourceGlsl, language, glslang::EShClientVulkan, 100);
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
  const auto messages = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
  Includer includer(includeFolders);
  if (!shader.parse(GetDefaultResources(), 460, false, messages, includer)) {
    throw std::runtime_error(std::string("GLSL does not compile:\n") + shader.getInfoLog() + shader.getInfoDebugLog());
  }
  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(messages)) {
    throw std::runtime_error(std::string("GLSL does not link:\n") + program.getInfoLog() + program.getInfoDebugLog());
  }
  std::vector<uint32_t> spirv;
  glslang::SpvOptions options;
  options.disableOptimizer = true;
  glslang::GlslangToSpv(*program.getIntermediate(language), spirv, &options);
  return spirv;
}

std::map<std::string, uint32_t> BindingNames(const std::vector<uint32_t>& spirv) {
  constexpr uint32_t kOpName = 5, kOpTypePointer = 32, kOpVariable = 59, kOpDecorate = 71, kBinding = 33;
  std::map<uint32_t, std::string> names;
  std::map<uint32_t, uint32_t> pointees, variableTypes, bindings;
  for (std::size_t i = 5; i < spirv.size();) {
    const uint32_t op = spirv[i] & 0xffff, words = spirv[i] >> 16;
    if (words == 0 || i + words > spirv.size()) break;
    if (op == kOpName && words > 2) {
      const char* text = reinterpret_cast<const char*>(&spirv[i + 2]);
      names[spirv[i + 1]] = std::string(text, strnlen(text, (words - 2) * 4));
    } else if (op == kOpTypePointer) {
      pointees[spirv[i + 1]] = spirv[i + 3];
    } else if (op == kOpVariable) {
      variableTypes[spirv[i + 2]] = spirv[i + 1];
    } else if (op == kOpDecorate && words > 3 && spirv[i + 2] == kBinding) {
      bindings[spirv[i + 1]] = spirv[i + 3];
    }
    i += words;
  }
  std::map<std::string, uint32_t> result;
  for (const auto& [variable, binding] : bindings) {
    std::string name = names[variable];
    if (name.empty()) name = names[pointees[variableTypes[variable]]];
    if (!name.empty()) result[name] = binding;
  }
  return result;
}

}  // namespace kernel_runner
