// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/emit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "materialgen/printer.h"
#include "materialgen/spirv_cache.h"

namespace materialgen {
namespace {

// Part of every key: raise it when the same network yields other source.
constexpr const char* kGeneratorVersion = "7";

class Emitter {
 public:
  Emitter(Expressions* expressions, const Material& material, const std::string& functions)
      : e_(*expressions), material_(material), functions_(functions) {}

  CompiledMaterial Run() {
    if (material_.displacement != kNone) return RunDisplacement();
    FindRoots();
    std::vector<std::vector<Id>> entries = {surfaceRoots_, opacityRoots_, emissionRoots_};
    layout_ = LayOut(e_, entries);
    auto kernel = std::make_shared<KernelSource>();
    kernel->primvars = layout_.primvars;
    for (const WeightedLobe& lobe : material_.closure.lobes) kernel->lobes.emplace_back(lobe.lobe->name);
    kernel->surface = SurfaceSource();
    if (hasOpacity_) kernel->opacity = PatternSource("opacity", "materialOpacity", opacity_, opacityRoots_);
    if (emission_ != kNone) kernel->emission = PatternSource("emission", "materialEmission", radiance_, emissionRoots_);
    std::string all = kGeneratorVersion;
    for (const std::string* text : {&kernel->surface, &kernel->opacity, &kernel->emission}) all += "\n---\n" + *text;
    for (const std::string& primvar : kernel->primvars) all += "\n" + primvar;
    kernel->key = HashOf(all);
    CompiledMaterial result;
    result.kernel = std::move(kernel);
    FillBlock(&result);
    return result;
  }

 private:
  CompiledMaterial RunDisplacement() {
    const std::vector<Id> roots = {material_.displacement};
    layout_ = LayOut(e_, {roots});
    auto kernel = std::make_shared<KernelSource>();
    kernel->primvars = layout_.primvars;
    kernel->displacement = PatternSource("displacement", "materialDisplacement", material_.displacement, roots);
    std::string all = kGeneratorVersion + ("\n---\n" + kernel->displacement);
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
      const Id blocked = e_.Arithmetic("subtract", {e_.Number(1), material_.closure.passThrough});
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
    if (material_.closure.extinction != kNone) surfaceRoots_.push_back(material_.closure.extinction);
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
    const size_t count = lobes_.size();
    for (size_t i = 0; i < count; ++i) {
      const LobeKind& kind = *lobes_[i].lobe;
      const std::string n = std::to_string(i), function(kind.function);
      const std::string lobe = printer.Text(lobes_[i].expression);
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
    const Id extinction = material_.closure.extinction;
    const std::string inside = extinction != kNone ? printer.TextAs(extinction, Type::Vec3) : "vec3(0.0)";
    const auto flag = [](const char* name, bool value) {
      return "const bool " + std::string(name) + (value ? " = true;\n" : " = false;\n");
    };
    std::string text = Head("surface", printer);
    text += flag("kHasTransmission", material_.closure.transmits) + flag("kHasOpacity", hasOpacity_) +
            flag("kHasEmission", emission_ != kNone);
    text += "struct Closure {\n  vec3 opacity;\n  vec3 emission;\n  vec3 interiorExtinction;\n  vec3 albedo;\n" +
            fields + "};\n";
    text += "void closureMake(ShadingPoint sp, out Closure c) {\n" + printer.Body() + assign +
            "  c.albedo = " + (count ? sum : "vec3(0.0)") + ";\n" + normalise + "  c.opacity = " + opacity +
            ";\n  c.emission = " + emission + ";\n  c.interiorExtinction = " + inside + ";\n}\n";
    std::string rgb, pdf;
    for (size_t i = 0; i < count; ++i) {
      const std::string n = std::to_string(i);
      rgb += (i ? " + c.w" : "c.w") + n + " * e" + n + ".rgb";
      pdf += (i ? " + c.p" : "c.p") + n + " * e" + n + ".a";
    }
    text += "vec4 closureEval(Closure c, vec3 wo, vec3 wi) {\n" + eval + "  return " +
            (count ? "vec4(" + rgb + ", " + pdf + ")" : "vec4(0.0)") + ";\n}\n";
    text += "vec3 closureSample(Closure c, vec3 wo, float uLobe, vec2 u) {\n" + sample +
            (count ? "}\n" : "  return vec3(0.0);\n}\n");
    text += "vec3 closureAlbedo(Closure c, vec3 wo) { return c.albedo; }\n";
    return text + "#include \"material/surface_tail.glsl\"\n";
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

std::string_view GeneratorVersion() { return kGeneratorVersion; }

CompiledMaterial Emit(Expressions* expressions, const Material& material, const std::string& functions) {
  return Emitter(expressions, material, functions).Run();
}

}  // namespace materialgen
