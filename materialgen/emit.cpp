// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/emit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "materialgen/printer.h"
#include "materialgen/spirv_cache.h"

namespace materialgen {
namespace {

// What bodies have at the start of their block (wavefront/kernels/lib/media.glsl).
constexpr uint32_t kBodyTexels = 2;

class Emitter {
 public:
  Emitter(Expressions* expressions, const Material& material, const std::string& functions)
      : e_(*expressions), material_(material), functions_(functions) {}

  CompiledMaterial Run() {
    if (material_.displacement != kNone) return RunDisplacement();
    FindRoots();
    std::vector<std::vector<Id>> entries = {surfaceRoots_, opacityRoots_, emissionRoots_};
    layout_ = LayOut(e_, entries, material_.closure.transmits ? kBodyTexels : 0);
    auto kernel = std::make_shared<KernelSource>();
    for (const WeightedLobe& lobe : material_.closure.lobes) kernel->lobes.emplace_back(lobe.lobe->name);
    kernel->surface = SurfaceSource();
    if (hasOpacity_) kernel->opacity = PatternSource("opacity", "materialOpacity", opacity_, opacityRoots_);
    if (emission_ != kNone) kernel->emission = PatternSource("emission", "materialEmission", radiance_, emissionRoots_);
    CompiledMaterial result = Finish(kernel, {&kernel->surface, &kernel->opacity, &kernel->emission});
    if (material_.closure.transmits) FillBody(&result);
    result.scatters = result.scatters || material_.closure.hasSubsurface;
    result.lightEnters = material_.closure.transmits || material_.closure.hasSubsurface;
    result.mediumPriority = uint8_t(material_.priority);
    return result;
  }

 private:
  CompiledMaterial RunDisplacement() {
    const std::vector<Id> roots = {material_.displacement};
    layout_ = LayOut(e_, {roots}, 0);
    auto kernel = std::make_shared<KernelSource>();
    kernel->displacement = PatternSource("displacement", "materialDisplacement", material_.displacement, roots);
    return Finish(kernel, {&kernel->displacement});
  }

  // The key, and the block of values.
  CompiledMaterial Finish(std::shared_ptr<KernelSource> kernel, std::initializer_list<const std::string*> sources) const {
    kernel->primvars = layout_.primvars;
    std::string all(GeneratorVersion());
    for (const std::string* text : sources) all += "\n---\n" + *text;
    for (const std::string& primvar : kernel->primvars) all += "\n" + primvar;
    kernel->key = HashOf(all);
    CompiledMaterial result;
    result.kernel = std::move(kernel);
    FillBlock(&result);
    return result;
  }

  // Light that passes through unhindered is one thing for the core, whether a surface is partly absent (opacity) or a
  // BSDF lets it through: what remains is weighted so that opacity * lobes comes out right.
  void FindRoots() {
    opacity_ = material_.opacity;
    emission_ = material_.emission;
    Id scale = kNone;
    if (material_.closure.passThrough != kNone) {
      const Id present = opacity_ == kNone ? e_.Number(1) : opacity_;
      // Shares that add up to 1 may round to more.
      const Id passed = e_.Arithmetic("min", {material_.closure.passThrough, e_.Number(1)});
      const Id blocked = e_.Arithmetic("subtract", {e_.Number(1), passed});
      opacity_ = e_.Arithmetic("multiply", {present, blocked});
      scale = e_.Arithmetic("divide", {present, e_.Arithmetic("max", {opacity_, e_.Number(1e-4f)})});
      if (emission_ != kNone) emission_ = e_.Arithmetic("multiply", {emission_, scale});
    }
    hasOpacity_ = opacity_ != kNone;
    for (const WeightedLobe& lobe : material_.closure.lobes) {
      WeightedLobe scaled = lobe;
      if (scale != kNone) scaled.weight = e_.Arithmetic("multiply", {scaled.weight, scale});
      lobes_.push_back(scaled);
      surfaceRoots_.push_back(scaled.expression);
      surfaceRoots_.push_back(scaled.weight);
    }
    if (hasOpacity_) {
      opacity_ = e_.Convert(opacity_, Type::Vec3);
      opacityRoots_.push_back(opacity_);
      surfaceRoots_.push_back(opacity_);
    }
    if (emission_ != kNone) {
      emission_ = e_.Convert(emission_, Type::Vec3);
      // The light sampler sees no opacity of its own: what leaves the surface on average.
      radiance_ = hasOpacity_ ? e_.Arithmetic("multiply", {emission_, opacity_}) : emission_;
      emissionRoots_.push_back(radiance_);
      surfaceRoots_.push_back(emission_);
    }
    if (!material_.closure.transmits || IsInsideUniform()) return;
    for (Id id : InsideOf()) {
      if (id != kNone) surfaceRoots_.push_back(id);
    }
  }

  std::array<Id, 3> InsideOf() const {
    const Vdf& v = material_.closure.inside;
    return {v.absorption, v.scattering, v.anisotropy};
  }
  bool IsInsideUniform() const {
    for (Id id : InsideOf()) {
      if (id != kNone && !e_.IsUniform(id)) return false;
    }
    return true;
  }
  // The medium inside, for the kernel: from the block, where the values are the same all over the surface.
  std::string InsideText(const Printer& printer) const {
    if (!material_.closure.transmits) return "clearMedium()";
    if (IsInsideUniform()) return "mediumAt(sp.parameterBase)";
    const auto text = [&](Id id, Type type, const char* none) { return id == kNone ? none : printer.TextAs(id, type); };
    const Vdf& v = material_.closure.inside;
    return "Medium(" + text(v.absorption, Type::Vec3, "vec3(0.0)") + ", " + text(v.scattering, Type::Vec3, "vec3(0.0)") +
           ", " + text(v.anisotropy, Type::Float, "0.0") + ")";
  }
  // Absorption, anisotropy; scattering, index. Whoever comes back into the body from another one inside reads them here.
  // As where the kernel computes them: infinity is the most there is, what is no number is none.
  void FillBody(CompiledMaterial* result) const {
    const auto put = [&](Id id, size_t at, size_t count, float none, float most) {
      for (size_t i = 0; i < count; ++i) {
        const bool isKnown = id != kNone && e_.IsUniform(id);
        const float value = isKnown ? e_[id].value[Components(e_[id].type) == 1 ? 0 : i] : none;
        result->parameters[at + i] = std::isnan(value) ? none : std::clamp(value, count == 3 ? 0.0f : -most, most);
      }
    };
    const Vdf& v = material_.closure.inside;
    put(v.absorption, 0, 3, 0, 1e9f);
    put(v.anisotropy, 3, 1, 0, 0.999f);
    put(v.scattering, 4, 3, 0, 1e9f);
    put(material_.closure.bodyIor, 7, 1, 1, 10);
    const float* scattering = &result->parameters[4];
    const bool varies = v.scattering != kNone && !e_.IsUniform(v.scattering);
    result->scatters = varies || scattering[0] + scattering[1] + scattering[2] > 0;
  }

  std::string Head(const char* head, const Printer& printer) const {
    std::string text = "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"material/";
    text += head;
    text += "_head.glsl\"\n#include \"lib/pattern.glsl\"\n";
    if (printer.CallsHexTiles()) text += "#include \"lib/hextile.glsl\"\n";
    for (const std::string& lobe : printer.LobeFiles()) text += "#include \"lib/bsdf/" + lobe + ".glsl\"\n";
    if (printer.CallsLibrary()) text += functions_;
    return text;
  }

  std::string PatternSource(const char* entry, const char* function, Id value, const std::vector<Id>& roots) const {
    Printer printer(e_, layout_, roots);
    const std::string result = printer.Text(value);
    std::string text = Head(entry == std::string_view("displacement") ? "displacement" : "pattern", printer);
    text +=
        "vec3 " + std::string(function) + "(ShadingPoint sp) {\n" + printer.Body() + "  return " + result + ";\n}\n";
    return text + "#include \"material/" + entry + "_tail.glsl\"\n";
  }

  std::string SurfaceSource() const {
    Printer printer(e_, layout_, surfaceRoots_);
    std::string fields, assign, importance, eval, sample;
    std::set<std::string> frames;
    std::string sum;
    std::vector<std::string> walks;  // numbers of the lobes that lead to a random walk
    const size_t count = lobes_.size();
    for (size_t i = 0; i < count; ++i) {
      const LobeKind& kind = *lobes_[i].lobe;
      const std::string n = std::to_string(i), function(kind.function);
      const std::string lobe = printer.Text(lobes_[i].expression);
      if (kind.name == "subsurface") walks.push_back(n);
      const std::string frame = printer.Text(e_[lobes_[i].expression].arguments[0]);
      if (frames.insert(frame).second) {
        fields += "  Frame " + frame + ";\n";
        assign += "  c." + frame + " = " + frame + ";\n";
        eval +=
            "  vec3 o" + frame + " = toLocal(c." + frame + ", wo), i" + frame + " = toLocal(c." + frame + ", wi);\n";
      }
      fields += "  " + std::string(kind.structure) + " l" + n + ";\n  vec3 w" + n + ";\n  float p" + n + ";\n";
      assign += "  c.l" + n + " = " + lobe + ";\n";
      assign += "  c.w" + n + " = " + printer.TextAs(lobes_[i].weight, Type::Vec3) + ";\n";
      assign += "  vec3 a" + n + " = c.w" + n + " * " + function + "Albedo(" + lobe + ", o" + frame + ");\n";
      assign += "  c.p" + n + " = closureImportance(c.w" + n + ", a" + n + ");\n";
      sum += (i ? " + a" : "a") + n;
      importance += (i ? " + c.p" : "c.p") + n;
      eval += "  vec4 e" + n + " = " + function + "Eval(c.l" + n + ", o" + frame + ", i" + frame + ");\n";
      const std::string call = "return toWorld(c." + frame + ", " + function + "Sample(c.l" + n + ", toLocal(c." +
                               frame + ", wo), vec3(u, uLobe)));\n";
      if (count == 1) {
        sample += "  " + call;
      } else {
        // The number that chose the lobe is stretched and used again: its low bits are as good.
        // The last one takes what rounding leaves; with no lobe alive its pdf is 0 and the path ends.
        const std::string stretch = "uLobe = min(uLobe / max(c.p" + n + ", 1e-9), 0.9999999);\n";
        if (i + 1 == count) {
          sample += "  " + stretch + "  " + call;
        } else {
          sample += "  if (uLobe < c.p" + n + ") {\n    " + stretch + "    " + call + "  }\n  uLobe -= c.p" + n + ";\n";
        }
      }
    }
    std::string normalise;
    if (count == 1) {
      normalise = "  c.p0 = c.p0 > 0.0 ? 1.0 : 0.0;\n";
    } else if (count > 1) {
      normalise = "  float total = " + importance + ";\n  float scale = total > 0.0 ? 1.0 / total : 0.0;\n";
      for (size_t i = 0; i < count; ++i) normalise += "  c.p" + std::to_string(i) + " *= scale;\n";
    }
    const std::string opacity = hasOpacity_ ? printer.Text(opacity_) : "vec3(1.0)";
    const std::string emission = emission_ != kNone ? printer.Text(emission_) : "vec3(0.0)";
    const auto flag = [](const char* name, bool value) {
      return "const bool " + std::string(name) + (value ? " = true;\n" : " = false;\n");
    };
    std::string text = Head("surface", printer);
    text += flag("kHasTransmission", material_.closure.transmits) + flag("kHasOpacity", hasOpacity_) +
            flag("kHasEmission", emission_ != kNone) + flag("kHasSubsurface", !walks.empty());
    text += "struct Closure {\n  vec3 opacity;\n  vec3 emission;\n  Medium interior;\n  vec3 albedo;\n" +
            fields + "};\n";
    text += "void closureMake(ShadingPoint sp, out Closure c) {\n" + printer.Body() + assign +
            "  c.albedo = " + (count ? sum : "vec3(0.0)") + ";\n" + normalise + "  c.opacity = " + opacity +
            ";\n  c.emission = " + emission + ";\n  c.interior = " + InsideText(printer) + ";\n}\n";
    std::string rgb, pdf;
    for (size_t i = 0; i < count; ++i) {
      const std::string n = std::to_string(i);
      rgb += (i ? " + c.w" : "c.w") + n + " * e" + n + ".rgb";
      pdf += (i ? " + c.p" : "c.p") + n + " * e" + n + ".a";
    }
    for (const std::string& n : walks) eval += "  below += c.w" + n + " * e" + n + ".rgb;\n";
    text += "vec4 closureEval(Closure c, vec3 wo, vec3 wi, inout vec3 below) {\n" + eval + "  return " +
            (count ? "vec4(" + rgb + ", " + pdf + ")" : "vec4(0.0)") + ";\n}\n";
    text += "vec3 closureSample(Closure c, vec3 wo, float uLobe, vec2 u) {\n" + sample +
            (count ? "}\n" : "  return vec3(0.0);\n}\n");
    text += "vec3 closureAlbedo(Closure c, vec3 wo) { return c.albedo; }\n" + WalkSource(walks);
    return text + "#include \"material/surface_tail.glsl\"\n";
  }

  // Which lobe's body a random walk runs through: in proportion to what they let in, colours and all.
  std::string WalkSource(const std::vector<std::string>& walks) const {
    std::string text = "SubsurfaceLobe closureWalk(Closure c, float u, inout vec3 below) {\n";
    if (walks.empty()) return text + "  return subsurfaceMake(c.albedo, vec3(0.0), vec3(0.0), 0.0);\n}\n";
    if (walks.size() == 1) return text + "  return c.l" + walks[0] + ";\n}\n";
    std::string sum;
    for (const std::string& n : walks) {
      text += "  vec3 s" + n + " = c.w" + n + " * c.l" + n + ".color;\n";
      sum += (sum.empty() ? "s" : " + s") + n;
    }
    text += "  vec3 all = max(" + sum + ", vec3(1e-20));\n  float mean = bsdfMean(all);\n  u *= mean;\n";
    for (size_t i = 0; i < walks.size(); ++i) {
      const std::string s = "s" + walks[i];
      const std::string take = "below *= " + s + " / all * (mean / max(bsdfMean(" + s + "), 1e-20));\n";
      if (i + 1 == walks.size()) return text + "  " + take + "  return c.l" + walks[i] + ";\n}\n";
      text += "  if (u < bsdfMean(" + s + ")) {\n    " + take + "    return c.l" + walks[i] + ";\n  }\n  u -= bsdfMean(" + s + ");\n";
    }
    return text;
  }

  void FillBlock(CompiledMaterial* result) const {
    result->parameters.assign(layout_.floats, 0.0f);
    for (const auto& [id, offset] : layout_.offsets) {
      const Expression& expression = e_[id];
      if (expression.op->name == "texture") {
        const TextureLeaf& leaf = e_.Textures()[size_t(expression.value[0])];
        TextureRequest request;
        request.file = leaf.file;
        request.sourceColorSpace = leaf.sourceColorSpace;
        request.isColor = leaf.isColor;
        request.offset = offset;
        request.node = leaf.node;
        result->textures.push_back(std::move(request));
        // Until the host has stored an id: missing.
        const uint32_t missing = 0xffffffffu;
        std::memcpy(&result->parameters[offset], &missing, sizeof(missing));
        result->slots.push_back({leaf.node, "file", offset, 1, true});
        continue;
      }
      for (int i = 0; i < Components(expression.type); ++i) {
        const float value = expression.value[size_t(i)];
        result->parameters[offset + size_t(i)] = std::isfinite(value) ? value : 0.0f;
      }
      for (const Leaf& leaf : e_.Leaves()) {
        if (leaf.id != id) continue;
        result->slots.push_back({leaf.node, leaf.input, offset, uint32_t(Components(expression.type)), false});
      }
    }
  }

  Expressions& e_;
  const Material& material_;
  const std::string& functions_;
  Layout layout_;
  std::vector<WeightedLobe> lobes_;
  Id opacity_ = kNone, emission_ = kNone, radiance_ = kNone;
  bool hasOpacity_ = false;
  std::vector<Id> surfaceRoots_, opacityRoots_, emissionRoots_;
};

}  // namespace

CompiledMaterial Emit(Expressions* expressions, const Material& material, const std::string& functions) {
  return Emitter(expressions, material, functions).Run();
}

}  // namespace materialgen
