// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/light_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "wavefront/scene/light_tree.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kDomeMapSide = 512;

bool IsInfinite(LightType type) { return type == LightType::Distant || type == LightType::Dome; }

// Size of the unit shape, and its name in the records.
void UnitScale(const LightData& light, double scale[3], uint32_t* kind) {
  const double r = light.radius;
  switch (light.type) {
    case LightType::Rect: scale[0] = light.width; scale[1] = light.height; scale[2] = 1; *kind = layout::kKindRect; break;
    case LightType::Disk: scale[0] = scale[1] = scale[2] = r; *kind = layout::kKindDisk; break;
    case LightType::Sphere: scale[0] = scale[1] = scale[2] = r; *kind = layout::kKindSphere; break;
    case LightType::Cylinder: scale[0] = light.length; scale[1] = scale[2] = r; *kind = layout::kKindCylinder; break;
    default: scale[0] = scale[1] = scale[2] = 1; *kind = layout::kKindMesh; break;
  }
}

double Length(const Matrix4d& m, int row) { return std::sqrt(m.m[row][0] * m.m[row][0] + m.m[row][1] * m.m[row][1] + m.m[row][2] * m.m[row][2]); }

double Length3(const Float4& v) { return std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z); }

// Approximate world area of a shape, for the choice among lights only (exact pdfs come from the kernels).
double ShapeArea(LightType type, const Matrix4d& m) {
  const double x = Length(m, 0), y = Length(m, 1), z = Length(m, 2);
  switch (type) {
    case LightType::Rect: return x * y;
    case LightType::Disk: return kPi * x * y;
    case LightType::Sphere: return 4 * kPi * std::cbrt(x * y * z) * std::cbrt(x * y * z);
    case LightType::Cylinder: return 2 * kPi * x * std::sqrt(y * z);
    default: return 0;
  }
}

// A dome is infinitely far: only its rotation counts. World-to-light rows of the frame that keeps the pole (+Y) and the
// side of +Z of a transform that scales or shears; mirrors stay mirrors.
Rows DomeRotation(const Matrix4d& m) {
  double y[3], z[3];
  const double ly = Length(m, 1);
  double along = 0, lz = 0;
  for (int c = 0; c < 3; ++c) { y[c] = m.m[1][c] / ly; along += y[c] * m.m[2][c]; }
  for (int c = 0; c < 3; ++c) { z[c] = m.m[2][c] - along * y[c]; lz += z[c] * z[c]; }
  for (double& c : z) c /= std::sqrt(lz);
  const double side = Determinant3(m) < 0 ? -1 : 1;
  float axes[3][3];
  for (int c = 0; c < 3; ++c) {
    const double x = side * (y[(c + 1) % 3] * z[(c + 2) % 3] - y[(c + 2) % 3] * z[(c + 1) % 3]);
    axes[0][c] = static_cast<float>(x);
    axes[1][c] = static_cast<float>(y[c]);
    axes[2][c] = static_cast<float>(z[c]);
  }
  return {Float4{axes[0][0], axes[0][1], axes[0][2], 0}, Float4{axes[1][0], axes[1][1], axes[1][2], 0}, Float4{axes[2][0], axes[2][1], axes[2][2], 0}};
}

// Marginal and conditional CDFs over luminance * sin(theta); appended to the distribution. Returns the mean luminance.
double AppendDomeMap(const FloatImage& image, std::vector<float>* out) {
  const uint32_t w = image.width, h = image.height;
  out->push_back(static_cast<float>(w));
  out->push_back(static_cast<float>(h));
  std::vector<double> rowSums(h);
  std::vector<std::vector<double>> rows(h, std::vector<double>(w));
  double total = 0, solid = 0;
  for (uint32_t y = 0; y < h; ++y) {
    const double sine = std::sin(kPi * (y + 0.5) / h);
    for (uint32_t x = 0; x < w; ++x) {
      // Bilinear lookups reach into the neighbours: so does the importance, or a bright texel's rim is never sampled.
      double value = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const uint32_t yy = static_cast<uint32_t>(std::clamp<int>(static_cast<int>(y) + dy, 0, static_cast<int>(h) - 1));
          const uint32_t xx = (x + w + static_cast<uint32_t>(dx + static_cast<int>(w))) % w;
          const Float4& t = image.texels[static_cast<std::size_t>(yy) * w + xx];
          const double l = Luminance({t.x, t.y, t.z});
          if (std::isfinite(l) && l > 0) value += l * (dx == 0 && dy == 0 ? 0.5 : 0.0625);
        }
      }
      rows[y][x] = value * sine;
      rowSums[y] += value * sine;
    }
    total += rowSums[y];
    solid += sine * w;
  }
  // A floor of 1 % uniform keeps every direction possible.
  const double floorValue = total > 0 ? 0.01 * total / solid : 1.0;
  for (uint32_t y = 0; y < h; ++y) {
    const double sine = std::sin(kPi * (y + 0.5) / h);
    for (double& v : rows[y]) v += floorValue * sine;
    rowSums[y] += floorValue * sine * w;
  }
  const double sum = total + floorValue * solid;
  double running = 0;
  out->push_back(0.0f);
  for (uint32_t y = 0; y < h; ++y) {
    running += rowSums[y];
    out->push_back(y + 1 == h ? 1.0f : static_cast<float>(running / sum));
  }
  for (uint32_t y = 0; y < h; ++y) {
    double rowRunning = 0;
    out->push_back(0.0f);
    for (uint32_t x = 0; x < w; ++x) {
      rowRunning += rows[y][x];
      out->push_back(x + 1 == w ? 1.0f : static_cast<float>(rowRunning / rowSums[y]));
    }
  }
  return total / solid;
}

struct Group {  // one analytic light or one emissive instance
  double power = 0;
  int light = -1, emissive = -1;
  LightBounds bounds;  // of a light at a finite place
};

// What of its surroundings an analytic light can reach. `sized`: unit shape to world; `toLight`: world to light space.
LightBounds ShapeBounds(const LightData& light, const Matrix4d& sized, const Rows& toLight, const Double3& origin) {
  const Rows rows = ToRows(sized, origin);
  const bool flat = light.type == LightType::Rect || light.type == LightType::Disk;
  LightBounds b;
  for (int i = 0; i < 3; ++i) {
    const Float4& r = rows[static_cast<std::size_t>(i)];
    // Half widths of the unit shape's box: rect .5 .5 0, disk 1 1 0, sphere 1 1 1, cylinder .5 1 1.
    const float x = light.type == LightType::Rect || light.type == LightType::Cylinder ? 0.5f : 1.0f;
    const float half = x * std::abs(r.x) + (light.type == LightType::Rect ? 0.5f : 1.0f) * std::abs(r.y) + (flat ? 0.0f : std::abs(r.z));
    b.min[i] = r.w - half;
    b.max[i] = r.w + half;
  }
  const auto setAxis = [&](double x, double y, double z) {
    const double length = std::sqrt(x * x + y * y + z * z);
    b.axis[0] = static_cast<float>(x / length);
    b.axis[1] = static_cast<float>(y / length);
    b.axis[2] = static_cast<float>(z / length);
  };
  if (flat) {  // shines along the unit shape's -Z: perpendicular to its plane, on the side that -Z is carried to
    const auto& m = sized.m;
    const double n[3] = {m[0][1] * m[1][2] - m[0][2] * m[1][1], m[0][2] * m[1][0] - m[0][0] * m[1][2], m[0][0] * m[1][1] - m[0][1] * m[1][0]};
    const double side = Determinant3(sized) < 0 ? 1 : -1;
    setAxis(side * n[0], side * n[1], side * n[2]);
    b.normals = 0;
  } else if (light.coneAngle < 0.5f * static_cast<float>(kPi)) {
    // Shaping is about light space's -Z, in which lengths may be scaled: only the axis is exact.
    setAxis(-toLight[2].x, -toLight[2].y, -toLight[2].z);
    const double sx = Length3(toLight[0]), sy = Length3(toLight[1]), sz = Length3(toLight[2]);
    const bool round = std::max({sx, sy, sz}) <= 1.0001 * std::min({sx, sy, sz});
    b.normals = 0;
    b.emission = round ? std::max(light.coneAngle, 0.0f) + 1e-3f : 1.57079633f;
    if (!round) b.normals = static_cast<float>(kPi);
  }
  return b;
}

// Emissive triangles shine to both sides. Their radiance is only known to their material's kernel.
LightBounds TriangleBounds(const Float3* corners) {
  LightBounds b;
  const float* p[3] = {&corners[0].x, &corners[1].x, &corners[2].x};
  double u[3], v[3];
  for (int i = 0; i < 3; ++i) {
    b.min[i] = std::min({p[0][i], p[1][i], p[2][i]});
    b.max[i] = std::max({p[0][i], p[1][i], p[2][i]});
    u[i] = double(p[1][i]) - p[0][i];
    v[i] = double(p[2][i]) - p[0][i];
  }
  const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  b.twoSided = true;
  if (!(length > 0)) return b;
  for (int i = 0; i < 3; ++i) b.axis[i] = static_cast<float>(n[i] / length);
  b.normals = 0;
  return b;
}

Float4 Bits(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  return {std::bit_cast<float>(a), std::bit_cast<float>(b), std::bit_cast<float>(c), std::bit_cast<float>(d)};
}

// Chances of picking, from weights in item order, as the float CDF really gives them: kernels divide by these.
std::vector<float> AppendCdf(const std::vector<double>& weights, std::vector<float>* distribution) {
  double sum = 0, running = 0;
  for (double w : weights) sum += w;
  std::vector<float> chances;
  float before = 0;
  distribution->push_back(0.0f);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    running += weights[i];
    const float after = i + 1 == weights.size() ? 1.0f : static_cast<float>(std::min(1.0, running / sum));
    distribution->push_back(after);
    chances.push_back(after - before);
    before = after;
  }
  return chances;
}

// Items of all groups and how one of them is picked: by the tree, or by weight alone. False: nothing shines.
bool WriteItems(const std::vector<Group>& groups, std::vector<EmissiveTriangles>& emissive, LightSampling sampling, LightTable* table) {
  double powerSum = 0;
  std::size_t shining = 0, shiningFar = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    powerSum += groups[g].power;
    shining += groups[g].power > 0;
    shiningFar += groups[g].power > 0 && g < table->infiniteCount;
  }
  if (shining == 0) return false;

  std::vector<double> weights;  // of items
  std::vector<LightBounds> near;
  const auto addItem = [&](uint32_t a, uint32_t b, uint32_t c, double weight, LightBounds bounds) {
    bounds.item = static_cast<uint32_t>(weights.size());
    bounds.power = weight;
    if (weight > 0 && weights.size() >= table->infiniteCount) near.push_back(bounds);
    weights.push_back(weight);
    table->items.insert(table->items.end(), {a, b, 0u, c});
  };
  // Half by power, half evenly: power alone starves a small light near the eye, and an emissive mesh counts as of
  // radiance 1 whatever its material says. A tree knows what is near.
  const bool evenly = !emissive.empty() || sampling == LightSampling::Power || shining <= kHandfulOfLights;
  for (const Group& g : groups) {
    const double power = g.power / powerSum;
    const double weight = g.power > 0 ? (evenly ? 0.5 * power + 0.5 / static_cast<double>(shining) : power) : 0.0;
    if (g.light >= 0) {
      addItem(static_cast<uint32_t>(g.light), layout::kNoLight, 0, weight, g.bounds);
      continue;
    }
    EmissiveTriangles& e = emissive[static_cast<std::size_t>(g.emissive)];
    e.itemBase = static_cast<uint32_t>(weights.size());
    const double area = g.power / kPi;
    for (std::size_t t = 0; t < e.areas.size(); ++t) {
      const bool emits = e.records[t] != layout::kNoLight && area > 0;
      addItem(e.instance, emits ? e.records[t] : 0u, static_cast<uint32_t>(t), emits ? weight * e.areas[t] / area : 0.0,
              emits ? TriangleBounds(&e.corners[3 * t]) : LightBounds{});
    }
  }
  table->itemCount = static_cast<uint32_t>(weights.size());
  const bool tree = !near.empty() && (sampling == LightSampling::Tree || (sampling == LightSampling::Auto && near.size() > kHandfulOfLights));
  if (!tree) {
    const std::vector<float> chances = AppendCdf(weights, &table->distribution);
    for (std::size_t i = 0; i < chances.size(); ++i) table->items[4 * i + 2] = std::bit_cast<uint32_t>(chances[i]);
    return true;
  }
  // The tree counts as one light beside those at infinity.
  std::vector<double> far(table->infiniteCount);
  const double even = 0.5 / static_cast<double>(shiningFar + 1);
  double nearPower = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (g < far.size()) far[g] = groups[g].power > 0 ? 0.5 * groups[g].power / powerSum + even : 0.0;
    else nearPower += groups[g].power;
  }
  far.push_back(0.5 * nearPower / powerSum + even);
  const std::vector<float> chances = AppendCdf(far, &table->distribution);
  for (std::size_t i = 0; i < table->infiniteCount; ++i) table->items[4 * i + 2] = std::bit_cast<uint32_t>(chances[i]);
  const LightTree built = BuildLightTree(near);
  for (std::size_t i = 0; i < near.size(); ++i) table->items[4 * near[i].item + 2] = built.trails[i];
  table->tree = table->itemCount;
  table->items.insert(table->items.end(), built.nodes.begin(), built.nodes.end());
  return true;
}

}  // namespace

LightTable BuildLightTable(std::vector<LightData> lights, std::vector<EmissiveTriangles>& emissive, TextureStore& textures,
                           const Double3& origin, double sceneRadius, LightSampling sampling, bool shadows, const DiagnosticSink& sink) {
  LightTable table;
  std::stable_sort(lights.begin(), lights.end(), [](const LightData& a, const LightData& b) {
    return IsInfinite(a.type) != IsInfinite(b.type) ? IsInfinite(a.type) : a.path < b.path;
  });
  std::vector<Group> groups;
  std::vector<float> domeMaps;
  std::vector<uint32_t> domeBases;
  const double radius = std::max(sceneRadius, 1e-6);

  for (const LightData& light : lights) {
    const Matrix4d transform = light.transforms.empty() ? Matrix4d{} : light.transforms.front().value;
    double scale[3];
    uint32_t kind;
    UnitScale(light, scale, &kind);
    const Matrix4d sized = Prescale(transform, scale[0], scale[1], scale[2]);
    auto worldToLight = InverseRows(transform, origin);
    const bool finite = std::isfinite(light.radiance.x) && std::isfinite(light.radiance.y) && std::isfinite(light.radiance.z);
    if (!worldToLight || !finite || (!IsInfinite(light.type) && !InverseRows(sized, origin))) {
      if (sink) sink({Severity::Warning, "light-degenerate", light.path, "the light has no area, a singular transform or values that are not finite; it does not shine"});
      continue;
    }
    const uint32_t index = table.lightCount++;
    double power = std::max<double>(0, Luminance(light.radiance)), solidAngle = 0, halfAngle = 0;
    Float3 radiance = light.radiance;
    uint32_t distribution = layout::kNoStream, texture = light.texture;
    if (texture != kInvalidId && !textures.Has(texture)) texture = kInvalidId;
    if (light.type == LightType::Dome) {
      worldToLight = DomeRotation(transform);
      if (texture != kInvalidId) {
        auto image = textures.ReadLevel(texture, kDomeMapSide);
        if (image.ok()) {
          distribution = static_cast<uint32_t>(domeMaps.size());
          power *= AppendDomeMap(image.value(), &domeMaps);
        }
      }
      const bool picked = distribution != layout::kNoStream || !light.castsShadows || !shadows;
      power *= picked ? 4 * kPi * kPi * radius * radius : 0;
    } else if (light.type == LightType::Distant) {
      // A parallel light is a cone too small to see that carries the same irradiance.
      halfAngle = 0.5 * light.angle;
      const bool parallel = halfAngle < 1e-5;
      if (parallel) halfAngle = 1e-4;
      halfAngle = std::min(halfAngle, kPi);
      const double s = std::sin(0.5 * halfAngle);
      solidAngle = 4 * kPi * s * s;
      if (parallel) {
        const float k = static_cast<float>(1.0 / (kPi * std::sin(halfAngle) * std::sin(halfAngle)));
        radiance = {radiance.x * k, radiance.y * k, radiance.z * k};
        power *= k;
      }
      power *= solidAngle * kPi * radius * radius;
    } else {
      power *= kPi * ShapeArea(light.type, sized);
      table.shapes.push_back({kind, index, sized, light.visibleToCamera});
    }
    uint32_t flags = (light.visibleToCamera ? layout::kLightFlagCameraVisible : 0u) | (light.castsShadows ? layout::kLightFlagShadows : 0u);
    if (Determinant3(sized) < 0) flags |= layout::kLightFlagMirrored;
    flags |= (light.lightLink & 0xffu) << layout::kLightLinkShift | (light.shadowLink & 0xffu) << layout::kShadowLinkShift |
             (light.lightGroup & 0xffu) << layout::kLightGroupShift;
    const double lx = Length(sized, 0), ly = Length(sized, 1), lz = Length(sized, 2), largest = std::max({lx, ly, lz});
    auto orthogonalRelative = [&](int a, int b, double lengths) {
      double d = 0;
      for (int c = 0; c < 3; ++c) d += sized.m[a][c] * sized.m[b][c];
      return std::abs(d) <= 1e-5 * lengths;
    };
    auto orthogonal = [&](int a, int b) { return orthogonalRelative(a, b, largest * largest); };
    if (std::max({std::abs(lx - ly), std::abs(ly - lz)}) <= 1e-5 * largest && orthogonal(0, 1) && orthogonal(1, 2) && orthogonal(0, 2)) flags |= layout::kLightFlagUniform;
    if (lx > 0 && ly > 0 && orthogonalRelative(0, 1, lx * ly)) flags |= layout::kLightFlagRectangular;
    const Rows shape = ToRows(sized, origin);
    const float cutoff = std::clamp(light.coneAngle, 0.0f, 6.2831853f);
    const float start = cutoff * (1.0f - std::clamp(light.coneSoftness, 0.0f, 1.0f));
    table.traits |= LightTraitOf(light.type);
    // Angles end at pi, or a little beyond by the rounding of acos.
    if (!IsInfinite(light.type) && (start < 3.15f || light.focus > 0)) table.traits |= kLightTraitShaped;
    if (texture != kInvalidId) table.traits |= kLightTraitTextured;
    table.records.push_back(Bits(static_cast<uint32_t>(light.type), flags, texture, index));
    table.records.insert(table.records.end(), shape.begin(), shape.end());
    table.records.insert(table.records.end(), worldToLight->begin(), worldToLight->end());
    table.records.push_back({radiance.x, radiance.y, radiance.z, static_cast<float>(solidAngle)});
    table.records.push_back({cutoff, start, light.focus, static_cast<float>(halfAngle)});
    table.records.push_back({light.focusTint.x, light.focusTint.y, light.focusTint.z, std::bit_cast<float>(distribution)});
    domeBases.push_back(distribution);
    if (IsInfinite(light.type)) ++table.infiniteCount;
    groups.push_back({power, static_cast<int>(index), -1, {}});
    if (!IsInfinite(light.type)) groups.back().bounds = ShapeBounds(light, sized, *worldToLight, origin);
  }
  for (std::size_t e = 0; e < emissive.size(); ++e) {
    double area = 0;
    for (std::size_t t = 0; t < emissive[e].areas.size(); ++t) {
      if (emissive[e].records[t] != layout::kNoLight) area += emissive[e].areas[t];
    }
    groups.push_back({kPi * area, -1, static_cast<int>(e), {}});
  }

  if (!WriteItems(groups, emissive, sampling, &table)) {
    // Nothing is to be picked. Bounce rays ask for the chances of the lights that they find: none.
    table.items.assign(4 * std::size_t{table.lightCount}, 0u);
    for (EmissiveTriangles& e : emissive) e.itemBase = layout::kNoLight;
    for (uint32_t l = 0; l < table.lightCount; ++l) table.records[l * layout::kLightTexels + 9].w = std::bit_cast<float>(layout::kNoStream);
    return table;
  }
  const uint32_t domeStart = static_cast<uint32_t>(table.distribution.size());
  table.distribution.insert(table.distribution.end(), domeMaps.begin(), domeMaps.end());
  for (uint32_t l = 0; l < table.lightCount; ++l) {
    if (domeBases[l] != layout::kNoStream) table.records[l * layout::kLightTexels + 9].w = std::bit_cast<float>(domeBases[l] + domeStart);
  }
  return table;
}

}  // namespace wavefront
