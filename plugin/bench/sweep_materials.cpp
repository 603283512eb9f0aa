// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/sweep_materials.h"

#include <array>

#include "plugin/bench/random.h"

namespace bench {
namespace {

constexpr uint32_t kStraightOperations = 400;

// Steps of the pattern, each about ten operations on p (a place) and v (the value so far). $ is a constant.
constexpr std::array<const char*, 6> kSteps{
    "  v += sin(p * $ + v.yzx); p = p.zxy + v * $;\n",
    "  p = fract(p * $ + 0.31) * 4.0 - 2.0; v = mix(v, p * p, $);\n",
    "  v = abs(v - $) * 1.7; p += v.zxy * cos(v * $);\n",
    "  p = vec3(p.x * $ - p.z * 0.6, p.y + v.x, p.x * 0.6 + p.z * $); v = max(v, -p);\n",
    "  v *= 1.0 / (1.0 + dot(v, v) * $); p = p + floor(p * $) * 0.1;\n",
    "  v = v * (3.0 - 2.0 * clamp(v, vec3(0.0), vec3(1.0))) + $; p -= v * v.x;\n"};
constexpr uint32_t kStepOperations = 12;

// The contract is materialgen/CONTRACT.md's. Texels 0 and 1 are the medium's, as in every block.
constexpr const char* kLobe = R"(
struct Closure { vec3 opacity; vec3 emission; Medium interior; vec3 albedo; vec3 n; };
const bool kHasSubsurface = false;
const bool kHasTransmission = false;
const bool kHasOpacity = false;
const bool kHasEmission = false;
void closureMake(ShadingPoint sp, out Closure c) {
  c.opacity = vec3(1.0);
  c.emission = vec3(0.0);
  c.interior = mediumAt(sp.parameterBase);
  c.albedo = materialParameter(sp, 2u).rgb * pattern(worldToObjectPoint(sp, sp.positionWorld));
  c.n = dot(sp.normalWorld, sp.wo) < 0.0 ? -sp.normalWorld : sp.normalWorld;
}
vec4 closureEval(Closure c, vec3 wo, vec3 wi, inout vec3 below) {
  float k = max(dot(c.n, wi), 0.0) * 0.31830988618;
  return vec4(c.albedo * k, k);
}
vec3 closureSample(Closure c, vec3 wo, float uLobe, vec2 u) {
  float r = sqrt(u.x), phi = 6.28318530718 * u.y;
  return toWorld(frameFromNormal(c.n), vec3(r * cos(phi), r * sin(phi), sqrt(max(0.0, 1.0 - u.x))));
}
SubsurfaceLobe closureWalk(Closure c, float u, inout vec3 below) { return subsurfaceMake(c.n, c.albedo, vec3(1.0), 0.0); }
vec3 closureAlbedo(Closure c, vec3 wo) { return c.albedo; }
)";

std::string Source(const std::string& pattern) {
  return "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"material/surface_head.glsl\"\n" + pattern + kLobe +
         "#include \"material/surface_tail.glsl\"\n";
}

}  // namespace

delegate::CapturedKernel MakePlainKernel() {
  delegate::CapturedKernel kernel;
  kernel.key = "plain";
  kernel.glsl[0] = Source("vec3 pattern(vec3 p) { return vec3(1.0); }\n");
  return kernel;
}

delegate::CapturedKernel MakeKernel(uint32_t number, uint32_t operations) {
  const uint32_t rounds = (operations + kStraightOperations - 1) / kStraightOperations;
  const uint32_t steps = std::max(1u, operations / rounds / kStepOperations);
  Random random(number + 1);
  std::string body;
  for (uint32_t i = 0; i < steps; ++i) {
    std::string step = kSteps[random.Next() % kSteps.size()];
    for (std::size_t at; (at = step.find('$')) != std::string::npos;) step.replace(at, 1, std::to_string(0.2f + 0.7f * random.Uniform()));
    body += step;
  }
  if (rounds > 1) body = "  [[dont_unroll]] for (int i = 0; i < " + std::to_string(rounds) + "; ++i) {\n" + body + "  }\n";
  delegate::CapturedKernel kernel;
  kernel.key = "pattern " + std::to_string(number) + " of " + std::to_string(operations);
  kernel.glsl[0] = Source("vec3 pattern(vec3 p) {\n  vec3 v = p.zxy;\n" + body + "  return 0.55 + 0.4 * sin(v + p);\n}\n");
  return kernel;
}

wavefront::MaterialData MakeMaterial(const delegate::CapturedKernel& kernel, uint32_t number) {
  Random random(number + 77);
  const auto colour = [&] { return 0.35f + 0.6f * random.Uniform(); };
  wavefront::MaterialData material;
  material.path = "/materials/m" + std::to_string(number);
  material.kernelKey = kernel.key;
  const float r = colour(), g = colour(), b = colour();
  material.parameters = {{0, 0, 0, 0}, {0, 0, 0, 1}, {r, g, b, 1}};
  return material;
}

}  // namespace bench
