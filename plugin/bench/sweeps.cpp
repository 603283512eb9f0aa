// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/sweeps.h"

#include <algorithm>
#include <cmath>

#include "plugin/bench/random.h"
#include "plugin/bench/sweep_materials.h"

namespace bench {
namespace {

using delegate::CapturedScene;
using namespace wavefront;

constexpr float kPi = 3.14159265f;

Matrix4d Placed(double scale, double x, double y, double z) {
  Matrix4d m;
  m.m[0][0] = m.m[1][1] = m.m[2][2] = scale;
  m.m[3][0] = x;
  m.m[3][1] = y;
  m.m[3][2] = z;
  return m;
}

// Unit sphere, smooth.
MeshData SphereMesh(uint32_t columns, uint32_t rows) {
  MeshData mesh;
  mesh.path = "/sphere";
  PrimvarData normals{"normals", Interpolation::Vertex, 3, {}, {}};
  for (uint32_t r = 0; r <= rows; ++r)
    for (uint32_t c = 0; c <= columns; ++c) {
      const float theta = kPi * static_cast<float>(r) / static_cast<float>(rows);
      const float phi = 2 * kPi * static_cast<float>(c) / static_cast<float>(columns);
      const Float3 p{std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi)};
      mesh.positions.push_back(p);
      normals.values.insert(normals.values.end(), {p.x, p.y, p.z});
    }
  for (uint32_t r = 0; r < rows; ++r)
    for (uint32_t c = 0; c < columns; ++c) {
      const uint32_t a = r * (columns + 1) + c, b = a + columns + 1;
      if (r != 0) mesh.triangles.push_back({a, b, a + 1});
      if (r + 1 != rows) mesh.triangles.push_back({a + 1, b, b + 1});
    }
  mesh.primvars.push_back(std::move(normals));
  return mesh;
}

// Hills over [-10, 10]^2 with about that many triangles; amplitude 0: a floor.
MeshData HillMesh(uint32_t triangles, float amplitude) {
  const auto side = std::max(1u, static_cast<uint32_t>(std::lround(std::sqrt(triangles / 2.0))));
  MeshData mesh;
  mesh.path = "/ground";
  mesh.positions.reserve((side + 1ull) * (side + 1ull));
  mesh.triangles.reserve(2ull * side * side);
  for (uint32_t z = 0; z <= side; ++z)
    for (uint32_t x = 0; x <= side; ++x) {
      const float u = 20 * static_cast<float>(x) / static_cast<float>(side) - 10, v = 20 * static_cast<float>(z) / static_cast<float>(side) - 10;
      float height = 0;
      for (int octave = 0; octave < 7; ++octave) {
        const float f = 0.4f * static_cast<float>(1 << octave);
        height += std::sin(f * u + 1.3f * static_cast<float>(octave)) * std::cos(f * v - 0.7f * static_cast<float>(octave)) / f;
      }
      mesh.positions.push_back({u, amplitude * height, v});
    }
  for (uint32_t z = 0; z < side; ++z)
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t a = z * (side + 1) + x, b = a + side + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  return mesh;
}

// A camera above, that looks down at the middle; a sky.
CapturedScene EmptyScene(const SweepPoint& point, float distance, float sky) {
  CapturedScene scene;
  scene.info = {point.name, HDWAVEFRONT_VERSION, delegate::IncludedGlslHash()};
  const double slope = 0.6, c = std::cos(slope), s = std::sin(slope);
  Matrix4d view;  // rows: right, up, back, place
  view.m[1] = {0, c, -s, 0};
  view.m[2] = {0, s, c, 0};
  view.m[3] = {0, distance * s, distance * c, 1};
  scene.camera.transforms = {{0, view}};
  scene.camera.left = -0.64f;
  scene.camera.right = 0.64f;
  scene.camera.bottom = -0.36f;
  scene.camera.top = 0.36f;
  scene.settings.width = 320;
  scene.settings.height = 180;
  scene.settings.samples = 8;
  scene.settings.maxBounces = 6;
  if (sky > 0) {
    LightData dome;
    dome.path = "/sky";
    dome.type = LightType::Dome;
    dome.transforms = {{0, {}}};
    dome.radiance = {sky, sky, sky * 1.15f};
    scene.lights[0] = dome;
  }
  return scene;
}

void AddSun(CapturedScene& scene) {
  LightData lamp;
  lamp.path = "/lamp";
  lamp.type = LightType::Rect;
  Matrix4d down = Placed(1, 0, 14, 0);  // a rect shines along its -Z
  down.m[1] = {0, 0, -1, 0};
  down.m[2] = {0, 1, 0, 0};
  lamp.transforms = {{0, down}};
  lamp.width = lamp.height = 6;
  lamp.radiance = {12, 11, 9};
  scene.lights[1] = lamp;
}

// Id of a material of `kernel`, which becomes the scene's where it is not yet.
MaterialId AddMaterial(CapturedScene& scene, delegate::CapturedKernel kernel, uint32_t number) {
  const auto id = static_cast<MaterialId>(scene.materials.size());
  scene.materials[id] = MakeMaterial(kernel, number);
  const bool known = std::any_of(scene.kernels.begin(), scene.kernels.end(), [&](const auto& k) { return k.key == kernel.key; });
  if (!known) scene.kernels.push_back(std::move(kernel));
  return id;
}

MeshId AddMesh(CapturedScene& scene, MeshData mesh) {
  const auto id = static_cast<MeshId>(scene.meshes.size());
  scene.meshes[id] = std::move(mesh);
  return id;
}

void AddInstances(CapturedScene& scene, const std::string& path, MeshId mesh, MaterialId material, const std::vector<Matrix4d>& places) {
  InstanceData data;
  data.path = path;
  data.mesh = mesh;
  data.materials = {material};
  data.primId = static_cast<int32_t>(scene.instances.size());
  for (const Matrix4d& place : places) {
    data.instanceIds.push_back(static_cast<int32_t>(data.transforms.size()));
    data.transforms.push_back({{0, place}});
  }
  scene.instances[static_cast<InstanceGroupId>(scene.instances.size())] = std::move(data);
}

// 1024 spheres on a floor; sphere i wears material i modulo their number, the floor the first. A CPU's driver compiles for seconds a kernel, so
// that there are at most 100 topologies there, and the others differ by values.
CapturedScene MaterialScene(const SweepPoint& point, bool cpu) {
  CapturedScene scene = EmptyScene(point, 13, 0.6f);
  AddSun(scene);
  const uint32_t topologies = std::min(point.size, cpu ? 100u : 1000u);
  std::vector<delegate::CapturedKernel> kernels;
  for (uint32_t t = 0; t < topologies; ++t) kernels.push_back(MakeKernel(t, point.operations));
  std::vector<std::vector<Matrix4d>> places(point.size);
  for (uint32_t i = 0; i < 1024; ++i) places[i % point.size].push_back(Placed(0.27, 0.6 * (i % 32) - 9.3, 0.27, 0.6 * (i / 32) - 9.3));
  const MeshId floor = AddMesh(scene, HillMesh(2, 0)), sphere = AddMesh(scene, SphereMesh(24, 12));
  for (uint32_t m = 0; m < std::min<std::size_t>(point.size, 1024); ++m) {
    const MaterialId material = AddMaterial(scene, kernels[m % topologies], m);
    if (m == 0) AddInstances(scene, "/floor", floor, material, {Matrix4d()});
    AddInstances(scene, "/spheres" + std::to_string(m), sphere, material, places[m]);
  }
  return scene;
}

CapturedScene TriangleScene(const SweepPoint& point, bool) {
  CapturedScene scene = EmptyScene(point, 15, 0.6f);
  AddSun(scene);
  AddInstances(scene, "/ground", AddMesh(scene, HillMesh(point.size, 1)), AddMaterial(scene, MakePlainKernel(), 0), {Matrix4d()});
  return scene;
}

// Spheres of 264 triangles all over a cube, the smaller the more there are.
CapturedScene InstanceScene(const SweepPoint& point, bool) {
  CapturedScene scene = EmptyScene(point, 20, 0.6f);
  AddSun(scene);
  AddInstances(scene, "/floor", AddMesh(scene, HillMesh(2, 0)), AddMaterial(scene, MakePlainKernel(), 0), {Placed(1, 0, -6, 0)});
  Random random(5);
  std::vector<Matrix4d> places;
  const double size = 3.0 / std::cbrt(static_cast<double>(point.size));
  const auto along = [&] { return 10.0 * random.Uniform() - 5.0; };
  for (uint32_t i = 0; i < point.size; ++i) {
    const double x = along(), y = along(), z = along();
    places.push_back(Placed(size * (0.5 + random.Uniform()), x, y, z));
  }
  AddInstances(scene, "/spheres", AddMesh(scene, SphereMesh(12, 12)), AddMaterial(scene, MakePlainKernel(), 1), places);
  return scene;
}

// Small sphere lights over hills, all together as bright as one.
CapturedScene LightScene(const SweepPoint& point, bool) {
  CapturedScene scene = EmptyScene(point, 15, 0);
  AddInstances(scene, "/ground", AddMesh(scene, HillMesh(20000, 1)), AddMaterial(scene, MakePlainKernel(), 0), {Matrix4d()});
  Random random(9);
  for (uint32_t i = 0; i < point.size; ++i) {
    LightData light;
    light.path = "/light" + std::to_string(i);
    light.type = LightType::Sphere;
    const double x = 18.0 * random.Uniform() - 9.0, y = 2.5 + 2.0 * random.Uniform(), z = 18.0 * random.Uniform() - 9.0;
    light.transforms = {{0, Placed(1, x, y, z)}};
    light.radius = 0.05f;
    const float power = 60000.0f / static_cast<float>(point.size);
    light.radiance = {power * (0.3f + random.Uniform()), power * (0.3f + random.Uniform()), power * (0.3f + random.Uniform())};
    scene.lights[i] = light;
  }
  return scene;
}

// What the pool and the image are measured on: 16 materials of middling size.
CapturedScene MixedScene(const SweepPoint& point, bool cpu) {
  return MaterialScene({point.name, 16, 200}, cpu);
}
CapturedScene PoolScene(const SweepPoint& point, bool cpu) {
  CapturedScene scene = MixedScene(point, cpu);
  scene.settings.poolSize = point.size;
  return scene;
}
CapturedScene ResolutionScene(const SweepPoint& point, bool cpu) {
  CapturedScene scene = MixedScene(point, cpu);
  scene.settings.width = point.size;
  scene.settings.height = std::max(1u, static_cast<uint32_t>(uint64_t{point.size} * 9 / 16));
  return scene;
}
CapturedScene SampleScene(const SweepPoint& point, bool cpu) {
  CapturedScene scene = MixedScene(point, cpu);
  scene.settings.samples = point.size;
  return scene;
}

}  // namespace

std::span<const Sweep> Sweeps() {
  static const std::vector<Sweep> sweeps{
      {"materials", "1 to 1000 materials, each of 100, 1000 and 4000 operations, on 1024 spheres",
       {1, 4}, {1, 4, 16, 100, 1000}, {1, 4, 16, 100, 1000}, {100, 1000, 4000}, MaterialScene},
      {"triangles", "hills of 10 thousand to 10 million triangles", {10000, 100000}, {10000, 100000, 1000000}, {10000, 100000, 1000000, 10000000}, {}, TriangleScene},
      {"instances", "1 to 1 million instances of a sphere", {1, 1000}, {1, 1000, 100000, 1000000}, {1, 1000, 100000, 1000000}, {}, InstanceScene},
      {"lights", "1 to 10 thousand lights over hills", {1, 100}, {1, 10, 100, 1000, 10000}, {1, 10, 100, 1000, 10000}, {}, LightScene},
      {"pool", "paths in flight: 2^12 to 2^17 on a CPU, 2^16 to 2^23 on a GPU", {1u << 14, 1u << 16},
       {1u << 12, 1u << 13, 1u << 14, 1u << 15, 1u << 16, 1u << 17}, {1u << 16, 1u << 17, 1u << 18, 1u << 19, 1u << 20, 1u << 21, 1u << 22, 1u << 23}, {}, PoolScene},
      {"resolution", "images 160 to 3840 pixels wide", {160, 320}, {160, 320, 640, 1280}, {160, 320, 640, 1280, 1920, 3840}, {}, ResolutionScene},
      {"samples", "1 to 256 samples a pixel", {1, 4}, {1, 4, 16, 64}, {1, 4, 16, 64, 256}, {}, SampleScene, true},
  };
  return sweeps;
}

const Sweep* FindSweep(const std::string& name) {
  for (const Sweep& sweep : Sweeps())
    if (sweep.name == name) return &sweep;
  return nullptr;
}

std::vector<SweepPoint> PointsOf(const Sweep& sweep, const std::vector<uint32_t>& sizes, bool quick, bool cpu) {
  std::vector<SweepPoint> points;
  const std::vector<uint32_t>& own = quick ? sweep.quick : cpu ? sweep.cpu : sweep.gpu;
  std::span<const uint32_t> operations = sweep.operations;
  if (quick) operations = operations.first(std::min<std::size_t>(operations.size(), 1));
  for (uint32_t size : sizes.empty() ? own : sizes) {
    const std::string name = std::string(sweep.name) + " " + std::to_string(size);
    if (operations.empty()) points.push_back({name, size, 0});
    for (uint32_t n : operations) points.push_back({name + ", " + std::to_string(n) + " operations", size, n});
  }
  return points;
}

}  // namespace bench
