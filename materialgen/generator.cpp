// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <mutex>
#include <set>
#include <unordered_map>

#include "materialgen/builder.h"
#include "materialgen/emit.h"
#include "materialgen/library.h"
#include "materialgen/materialgen.h"

namespace materialgen {
namespace {

// Decisions freeze values, frozen values fold more; a few rounds settle it.
constexpr int kMaximumPasses = 6;
// Drivers inline all calls, and their time grows faster than what comes out. At these limits llvmpipe compiles for some ten
// seconds of one core (README.md).
constexpr size_t kMaximumExpressions = 20000;
constexpr size_t kMaximumSource = 32000;  // characters of what is not MaterialX's functions
constexpr uint64_t kMaximumInstructions = 400000;
// Source that cannot reach that many, whatever it calls; so the others need no look.
constexpr size_t kSurelySmall = 8000;

class GeneratorImpl final : public Generator {
 public:
  explicit GeneratorImpl(std::unique_ptr<Library> library) : library_(std::move(library)) {}

  bool Supports(const MaterialNetwork& network, std::string* unsupportedNode) const override {
    std::vector<Message> messages;
    Expressions expressions(&kNoneFrozen_);
    Builder builder(library_.get(), network, &expressions, {});
    builder.Build();
    for (const Message& message : builder.TakeMessages()) {
      if (message.severity != Severity::Error) continue;
      if (unsupportedNode) *unsupportedNode = message.location;
      return false;
    }
    return true;
  }

  CompiledMaterial Generate(const MaterialNetwork& network, const MessageSink& sink,
                            const GenerateOptions& options) override {
    CompiledMaterial result = Compile(network, Terminal::Surface, sink, options);
    Share(&result);
    return result;
  }

  CompiledMaterial GenerateDisplacement(const MaterialNetwork& network, const MessageSink& sink) override {
    if (network.displacementNode.empty()) return {};
    CompiledMaterial result = Compile(network, Terminal::Displacement, sink, {});
    if (result.kernel) Share(&result);
    return result;
  }

  CompiledMaterial GenerateDefault(bool isOpaque) override {
    MaterialNetwork network;
    network.path = "(default material)";
    network.surfaceNode = "surface";
    network.surfaceOutput = "surface";
    const std::array<float, 3> gray{0.18f, 0.18f, 0.18f};
    network.nodes = {
        {"surface", "UsdPreviewSurface", {}},
        {"color", "UsdPrimvarReader_float3", {{"varname", std::string("displayColor")}, {"fallback", gray}}},
        {"opacity", "UsdPrimvarReader_float", {{"varname", std::string("displayOpacity")}, {"fallback", 1.0f}}},
    };
    network.connections = {{"color", "result", "surface", "diffuseColor"}};
    if (!isOpaque) network.connections.push_back({"opacity", "result", "surface", "opacity"});
    return Generate(network, [](const Message&) {}, {});
  }

 private:
  enum class Terminal { Surface, Displacement };

  // Equal topologies share one kernel object.
  void Share(CompiledMaterial* result) {
    const std::lock_guard lock(mutex_);
    result->kernel = kernels_.emplace(result->kernel->key, result->kernel).first->second;
  }

  // Whether a driver would compile one of the entries for too long. `functions`: MaterialX's, which the entries hold.
  bool IsTooLarge(const KernelSource& kernel, const std::string& functions) {
    const auto isTooLarge = [&](const std::string& source) {
      const bool holdsThem = !functions.empty() && source.find(functions) != std::string::npos;
      const size_t own = source.size() - (holdsThem ? functions.size() : 0);
      if (own <= kSurelySmall || own > kMaximumSource) return own > kMaximumSource;
      std::string error;
      return InlinedInstructions(CompileGlsl(source, kernel.key, &error)) > kMaximumInstructions;
    };
    {
      const std::lock_guard lock(mutex_);
      const auto known = isTooLarge_.find(kernel.key);
      if (known != isTooLarge_.end()) return known->second;
    }
    const bool result = isTooLarge(kernel.surface) || isTooLarge(kernel.opacity) || isTooLarge(kernel.emission) ||
                        isTooLarge(kernel.displacement);
    const std::lock_guard lock(mutex_);
    return isTooLarge_[kernel.key] = result;
  }

  CompiledMaterial Compile(const MaterialNetwork& network, Terminal terminal, const MessageSink& sink,
                           const GenerateOptions& options) {
    std::vector<std::string> frozen;
    SurfaceFacts facts;
    for (int pass = 0;; ++pass) {
      Expressions expressions(&frozen);
      Builder builder(library_.get(), network, &expressions, facts, options.diffuseSubsurface);
      const bool isSurface = terminal == Terminal::Surface;
      const Material material = isSurface ? builder.Build() : builder.BuildDisplacement();
      const std::vector<std::string>& more = expressions.NewlyFrozen();
      const bool isSettled = more.empty() && material.facts == facts;
      if (!isSettled && pass + 1 < kMaximumPasses) {
        frozen.insert(frozen.end(), more.begin(), more.end());
        facts = material.facts;
        continue;
      }
      std::vector<Message> messages = builder.TakeMessages();
      std::set<std::string> seen;
      std::string functions;
      if (builder.CallsLibrary()) {
        // Its macros serve all the others.
        functions = library_->FunctionSource(library_->MathFile(), &seen);
        for (const std::string& file : builder.FunctionFiles()) functions += library_->FunctionSource(file, &seen);
      }
      bool isTooLarge = expressions.size() > kMaximumExpressions;
      CompiledMaterial result;
      const bool isNothing = !isSurface && material.displacement == kNone;
      if (!isTooLarge && !isNothing) result = Emit(&expressions, material, functions);
      result.closureTree = material.closureTree;
      isTooLarge = isTooLarge || (result.kernel && IsTooLarge(*result.kernel, functions));
      if (!isSurface && isTooLarge) {
        messages.push_back({Severity::Error, "material-too-large", network.path,
                            "the displacement is too large to compile; the surface is not displaced"});
        result = {};
      } else if (isTooLarge) {
        messages.push_back({Severity::Error, "material-too-large", network.path,
                            "the material is too large to compile; it shows magenta"});
        MaterialNetwork empty;
        empty.path = network.path;
        result = Compile(empty, Terminal::Surface, [](const Message&) {}, options);
      }
      const auto asks = [&](const char* function) {
        return result.kernel && result.kernel->displacement.find(function) != std::string::npos;
      };
      if (asks("frameNumber()") || asks("frameSeconds()")) {
        messages.push_back({Severity::Warning, "material-unsupported-feature", network.path,
                            "displacement does not follow the frame: it sees frame 1 and time 0"});
      }
      for (const Message& message : messages) {
        if (sink) sink(message);
      }
      return result;
    }
  }

  std::unique_ptr<Library> library_;
  const std::vector<std::string> kNoneFrozen_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<const KernelSource>> kernels_;
  std::unordered_map<std::string, bool> isTooLarge_;  // by key
};

}  // namespace

std::unique_ptr<Generator> Generator::Create(const std::string& libraryPath, const MessageSink& sink) {
  std::string error;
  std::unique_ptr<Library> library = Library::Load(libraryPath, &error);
  if (!library) {
    if (sink) sink({Severity::Error, "materialx-libraries-missing", libraryPath, error});
    return nullptr;
  }
  return std::make_unique<GeneratorImpl>(std::move(library));
}

}  // namespace materialgen
