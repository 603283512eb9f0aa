// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Materials side by side in one program.
#include "materialgen/link_megakernel.h"

#include <gtest/gtest.h>

#include "materialgen/materialgen.h"

namespace materialgen {
namespace {

TEST(LinkMegakernel, TopLevelNamesAreWhatStandsOutsideOfFunctions) {
  const std::set<std::string> names = TopLevelNames(R"(
#define MACRO(x) float macro(x) { return 1.0; }
#include "lib/file.glsl"
// float comment() { }
/* float block() { } */
struct Pair { float first; vec2 second[2]; };
const bool kFlag = true;
const float kTable[2] = float[2](1.0, 2.0), kOther = 3.0 * (kTable[0] + 1.0);
vec3 gA, gB;
layout(local_size_x = 64) in;
float declared(float x);
vec4 defined(Pair p, const in float t) {
  float local = p.first;
  for (int i = 0; i < 3; ++i) { local += float(i); }
  return vec4(local);
}
void last() {}
)");
  EXPECT_EQ(names, (std::set<std::string>{"Pair", "kFlag", "kTable", "kOther", "gA", "gB", "declared", "defined",
                                          "last"}));
}

TEST(LinkMegakernel, EveryLoopIsCounted) {
  EXPECT_EQ(WithCountedLoops("for (int i = 0; i < f(1, 2); i++) x();"),
            "for (int i = 0; countLoop() && (i < f(1, 2)); i++) x();");
  EXPECT_EQ(WithCountedLoops("for (;;) { while(a || b) c; }"), "for (; countLoop();) { while(countLoop() && (a || b)) c; }");
  EXPECT_EQ(WithCountedLoops("do { x(); } while (y); // while (z)"), "do { x(); } while (countLoop() && (y)); // while (z)");
  EXPECT_EQ(WithCountedLoops("float forward = whiles(1.0);"), "float forward = whiles(1.0);");
}

// Equal names, one of them with a loop; and a kernel that has every entry.
TEST(LinkMegakernel, EqualNamesStayApart) {
  const auto source = [](const char* body, const char* head, const char* tail) {
    return std::string("#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"material/") + head +
           "\"\n" + body + "#include \"material/" + tail + "\"\n";
  };
  const char* const surface = R"(
const bool kHasTransmission = false;
const bool kHasSubsurface = true;
const bool kHasOpacity = true;
const bool kHasEmission = true;
float helper(float x) { for (int i = 0; i < 3; ++i) x *= 2.0; return x; }
struct Closure { vec3 opacity; vec3 emission; Medium interior; float value; };
void closureMake(ShadingPoint sp, out Closure c) {
  c.opacity = vec3(0.5); c.emission = vec3(1.0); c.interior = mediumAt(sp.parameterBase); c.value = helper(1.0);
}
vec4 closureEval(Closure c, vec3 wo, vec3 wi, inout vec3 below) { return vec4(c.value); }
vec3 closureSample(Closure c, vec3 wo, float uLobe, vec2 u) { return wo; }
SubsurfaceLobe closureWalk(Closure c, float u, inout vec3 below) { return subsurfaceMake(vec3(0.0, 0.0, 1.0), below, vec3(1.0), 0.0); }
vec3 closureAlbedo(Closure c, vec3 wo) { return vec3(c.value); }
)";
  std::vector<std::shared_ptr<const KernelSource>> kernels;
  for (int i = 0; i < 3; ++i) {
    auto kernel = std::make_shared<KernelSource>();
    kernel->surface = source(surface, "surface_head.glsl", "surface_tail.glsl");
    if (i > 0) kernel->opacity = source("float helper() { return 0.5; }\nvec3 materialOpacity(ShadingPoint sp) { return vec3(helper()); }\n",
                                        "pattern_head.glsl", "opacity_tail.glsl");
    if (i > 1) kernel->emission = source("vec3 materialEmission(ShadingPoint sp) { return sp.wo; }\n", "pattern_head.glsl",
                                         "emission_tail.glsl");
    kernels.push_back(std::move(kernel));
  }
  const std::string text = LinkMegakernel(kernels);
  std::string error;
  EXPECT_FALSE(CompileGlsl(text, "megakernel", &error).empty()) << error;
  // One constant and one call each.
  for (size_t id : {0, 3, 4, 6, 7, 8}) EXPECT_NE(text.find("constant_id = " + std::to_string(id) + ")"), std::string::npos) << id;
  for (size_t id : {1, 2, 5}) EXPECT_EQ(text.find("constant_id = " + std::to_string(id) + ")"), std::string::npos) << id;
}

}  // namespace
}  // namespace materialgen
