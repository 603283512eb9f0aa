// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// materialgen: material network -> MaterialX document -> flattened -> closure tree -> GLSL -> SPIR-V.
// CPU only; knows no Vulkan and no pxr.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "materialgen/network.h"

namespace materialgen {

enum class Severity { Info, Warning, Error };
struct Message {
  Severity severity = Severity::Warning;
  std::string code;      // "material-unknown-node", "material-cycle", "material-unsupported-feature", ...
  std::string location;  // path of the node or the material
  std::string text;
};
using MessageSink = std::function<void(const Message&)>;

// Where one value of the parameter block comes from. Values that are computed from several inputs (an index of
// refraction and a colour making a reflectance, say) have no slot: for an edit, call Generate again (under a
// millisecond) and compare the kernels.
struct ParameterSlot {
  std::string node;       // node path in the network that was handed in (empty: a node inside a MaterialX graph)
  std::string input;
  uint32_t offset = 0;    // in floats from the start of the block
  uint32_t components = 1;
  bool isTexture = false; // one component holding the bits of a texture id
};

// A texture that the block needs; the delegate obtains an id for it and stores its bits at `offset` (floats).
struct TextureRequest {
  AssetValue file;
  std::string sourceColorSpace;   // "raw", "sRGB", "auto" (UsdUVTexture) or a colour-space name; empty: from the asset
  bool isColor = true;            // the node's output type is a colour (data otherwise: never colour-managed)
  uint32_t offset = 0;
  std::string node;               // for diagnostics
};

// GLSL sources of one topology. Sources are complete but for #include lines into wavefront/ (see EmbeddedGlsl).
struct KernelSource {
  std::string key;        // hash of topology and generator version; equal keys have equal sources
  std::string surface;
  std::string opacity;    // empty: opaque for every value of the parameters
  std::string emission;   // empty: never emits
  std::string displacement;  // of GenerateDisplacement's kernels only, which have no other entry
  std::vector<std::string> primvars;  // names read, in slot order
  std::vector<std::string> lobes;     // names of the lobes left after pruning, for statistics and explain
};

// One material: which kernel, and its values.
struct CompiledMaterial {
  std::shared_ptr<const KernelSource> kernel;
  std::vector<float> parameters;      // size a multiple of 4 (texels of 4 floats)
  std::vector<ParameterSlot> slots;
  std::vector<TextureRequest> textures;
  std::string closureTree;            // in words, for explain
  // Of the inside, where the material is a body's: where bodies overlap the highest (0..31) fills the overlap. Authored as
  // `dielectric_priority` on the node of the surface terminal (Arnold's name and meaning).
  uint8_t mediumPriority = 0;
  bool scatters = false;              // light scatters below the surface or inside of the body
  bool lightEnters = false;           // into the body: by refraction, or to scatter below the surface
};

struct GenerateOptions {
  bool diffuseSubsurface = false;     // subsurface_bsdf is a diffuse reflection instead of a random walk
};

// Thread-safe: Generate may be called from several threads. Libraries are loaded once (about 0.1 s).
class Generator {
 public:
  // `libraryPath`: folder holding MaterialX's data libraries ("stdlib", "pbrlib", "bxdf", ...).
  // Null with a message where they cannot be read.
  static std::unique_ptr<Generator> Create(const std::string& libraryPath, const MessageSink& sink);
  virtual ~Generator() = default;

  // True if every node of the network is known and supported (used to choose between contexts).
  virtual bool Supports(const MaterialNetwork& network, std::string* unsupportedNode) const = 0;

  // Never fails: an unknown node, cycle or type error gives a message and a visible fallback (magenta for colours
  // fed by an unknown node; the whole material where the terminal itself is unknown).
  virtual CompiledMaterial Generate(const MaterialNetwork& network, const MessageSink& sink,
                                    const GenerateOptions& options = {}) = 0;

  // The network's displacement terminal, as a kernel and a block of its own: materials that differ in displacement only
  // share their surface kernel, and an edit of the surface moves no mesh. `kernel` is null where nothing is displaced:
  // no terminal, a constant zero, or a message that says what is wrong.
  virtual CompiledMaterial GenerateDisplacement(const MaterialNetwork& network, const MessageSink& sink) = 0;

  // The material for prims that have none: MaterialX/USD preview grey using primvar displayColor and, unless
  // `isOpaque`, displayOpacity (a kernel with opacity costs every shadow ray a stop).
  virtual CompiledMaterial GenerateDefault(bool isOpaque = false) = 0;
};

// GLSL of the megakernel: the fixed kernels of wavefront/kernels and these materials in one program. The bucket that an
// entry of kernel k answers to is the specialization constant k * kKernelEntries + entry (surface, opacity, emission).
constexpr size_t kKernelEntries = 3;
std::string LinkMegakernel(const std::vector<std::shared_ptr<const KernelSource>>& kernels);

// GLSL (with includes into wavefront/) to SPIR-V for Vulkan 1.3. Thread-safe. Empty with the log in `error` on failure:
// that is a bug of the generator, the log names lines.
std::vector<uint32_t> CompileGlsl(const std::string& source, const std::string& name, std::string* error);

// Instructions of the entry point once every call is replaced by what it calls: what a driver compiles.
uint64_t InlinedInstructions(const std::vector<uint32_t>& spirv);

// The same program with calls inlined and variables made values; as it came where it is too large for that to be quick
// (kOptimizedInstructions), or the optimiser refuses it. A material kernel takes 0.2 to 0.35 s. Thread-safe.
constexpr uint64_t kOptimizedInstructions = 60000;
std::vector<uint32_t> OptimizeSpirv(std::vector<uint32_t> spirv);

}  // namespace materialgen
