// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Meshes moved by generated displacement kernels, point by point against closed forms.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

#include "materialgen/materialgen.h"
#include "tests/wavefront/vulkan/fixture.h"
#include "wavefront/scheduler/displacer.h"
#include "wavefront/scheduler/kernel_registry.h"

namespace wavefront {
namespace {

using materialgen::MaterialNetwork;
using Vector = std::array<float, 3>;

// (n + 1)^2 points of the square [0, 1]^2 in the plane z = 0, facing +Z; "st" is the place, and `seam` gives both halves
// their own values along the middle, equal ones.
MeshData Grid(uint32_t n, bool seam = false) {
  MeshData mesh;
  mesh.path = "/grid";
  PrimvarData st{"st", seam ? Interpolation::FaceVarying : Interpolation::Vertex, 2, {}, {}};
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) {
      mesh.positions.push_back({float(x) / float(n), float(y) / float(n), 0});
      if (!seam) st.values.insert(st.values.end(), {float(x) / float(n), float(y) / float(n)});
    }
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + n + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  for (const UInt3& t : mesh.triangles)
    for (const uint32_t v : {t.x, t.y, t.z})
      if (seam) st.values.insert(st.values.end(), {mesh.positions[v].x, mesh.positions[v].y});
  mesh.faceIds.resize(mesh.triangles.size());
  std::iota(mesh.faceIds.begin(), mesh.faceIds.end(), 0u);
  mesh.primvars.push_back(st);
  return mesh;
}

// Longitudes and latitudes, one pole point each, normals of the true sphere.
MeshData Sphere(uint32_t n, double radius) {
  MeshData mesh;
  PrimvarData normals{"normals", Interpolation::Vertex, 3, {}, {}};
  const auto add = [&](double theta, double phi) {
    const double x = std::sin(theta) * std::cos(phi), y = std::sin(theta) * std::sin(phi), z = std::cos(theta);
    mesh.positions.push_back({float(radius * x), float(radius * y), float(radius * z)});
    normals.values.insert(normals.values.end(), {float(x), float(y), float(z)});
  };
  add(0, 0);
  for (uint32_t i = 1; i < n; ++i)
    for (uint32_t j = 0; j < 2 * n; ++j) add(std::numbers::pi * i / n, std::numbers::pi * j / n);
  add(std::numbers::pi, 0);
  const auto at = [&](uint32_t i, uint32_t j) { return 1 + (i - 1) * 2 * n + j % (2 * n); };
  const auto last = static_cast<uint32_t>(mesh.positions.size() - 1);
  for (uint32_t j = 0; j < 2 * n; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (uint32_t i = 1; i + 1 < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.triangles.push_back({at(n - 1, j), last, at(n - 1, j + 1)});
  }
  mesh.primvars.push_back(normals);
  return mesh;
}

MaterialNetwork Constant(float amount) {
  MaterialNetwork network;
  network.path = "/m";
  network.nodes = {{"/m/d", "ND_displacement_float", {{"displacement", amount}}}};
  network.displacementNode = "/m/d";
  network.displacementOutput = "out";
  return network;
}

// 0.25 sin(6 u), u the first texture coordinate.
MaterialNetwork Waves() {
  MaterialNetwork network = Constant(0);
  network.nodes[0].parameters["scale"] = 0.25f;
  network.nodes.push_back({"/m/uv", "ND_texcoord_vector2", {}});
  network.nodes.push_back({"/m/x", "ND_dotproduct_vector2", {{"in2", std::array<float, 2>{6, 0}}}});
  network.nodes.push_back({"/m/sin", "ND_sin_float", {}});
  network.connections = {{"/m/uv", "out", "/m/x", "in1"},
                         {"/m/x", "out", "/m/sin", "in"},
                         {"/m/sin", "out", "/m/d", "displacement"}};
  return network;
}

MaterialNetwork Textured(float scale) {
  MaterialNetwork network = Constant(0);
  network.nodes[0].parameters["scale"] = scale;
  network.nodes.push_back({"/m/t",
                           "UsdUVTexture",
                           {{"file", materialgen::AssetValue{"a.png", "/a.png", ""}},
                            {"wrapS", std::string("clamp")},
                            {"wrapT", std::string("clamp")}}});
  network.nodes.push_back({"/m/r", "UsdPrimvarReader_float2", {{"varname", std::string("st")}}});
  network.connections = {{"/m/t", "r", "/m/d", "displacement"}, {"/m/r", "result", "/m/t", "st"}};
  return network;
}

class DisplacerTest : public vulkan::VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    kernels_ = vulkan::Must(KernelRegistry::Create(*device_));
    textures_ = std::make_unique<TextureStore>(*device_);
    displacer_ = std::make_unique<Displacer>(*device_, kernels_->layout(), *textures_);
  }
  void TearDown() override {
    displacer_.reset();
    textures_.reset();
    kernels_.reset();
    VulkanTest::TearDown();
  }

  std::shared_ptr<const DisplacementData> Kernel(const MaterialNetwork& network, TextureId texture = kInvalidId) {
    static const auto generator = materialgen::Generator::Create(HDWAVEFRONT_MATERIALX_LIBRARIES, {});
    const materialgen::CompiledMaterial material = generator->GenerateDisplacement(
        network, [](const materialgen::Message& m) { ADD_FAILURE() << m.location << ": " << m.text; });
    if (!material.kernel) return nullptr;
    auto data = std::make_shared<DisplacementData>();
    std::string error;
    data->kernelKey = material.kernel->key;
    data->spirv = std::make_shared<const std::vector<uint32_t>>(
        materialgen::CompileGlsl(material.kernel->displacement, "displacement", &error));
    EXPECT_FALSE(data->spirv->empty()) << error;
    data->primvars = material.kernel->primvars;
    std::vector<float> values = material.parameters;
    for (const materialgen::TextureRequest& request : material.textures)
      values[request.offset] = std::bit_cast<float>(texture);
    for (size_t i = 0; i < values.size(); i += 4)
      data->parameters.push_back({values[i], values[i + 1], values[i + 2], values[i + 3]});
    return data;
  }

  template <typename Red>
  TextureId Texture(uint32_t side, Red red) {
    TextureData image;
    image.width = image.height = side;
    for (uint32_t i = 0; i < side * side; ++i)
      image.texels.insert(image.texels.end(), {static_cast<uint8_t>(red(i % side, i / side)), 0, 0, 255});
    const TextureId texture = textures_->Create(image);
    bool changed = false;
    vulkan::Must(textures_->Commit({}, &changed));
    return texture;
  }

  MeshData Displaced(MeshData mesh, std::vector<std::shared_ptr<const DisplacementData>> displacements) {
    mesh.displacements = std::move(displacements);
    said_.clear();
    vulkan::Must(displacer_->Displace(mesh, [this](const Diagnostic& d) { said_.push_back(d); }));
    EXPECT_TRUE(mesh.displacements.empty());
    return mesh;
  }

  std::unique_ptr<KernelRegistry> kernels_;
  std::unique_ptr<TextureStore> textures_;
  std::unique_ptr<Displacer> displacer_;
  std::vector<Diagnostic> said_;
};

const PrimvarData& Normals(const MeshData& mesh) {
  for (const PrimvarData& p : mesh.primvars)
    if (p.name == "normals") return p;
  ADD_FAILURE() << "no normals";
  return mesh.primvars.at(0);
}

TEST_F(DisplacerTest, AConstantMakesASphereOfTheNextSize) {
  const MeshData moved = Displaced(Sphere(32, 2), {Kernel(Constant(0.5f))});
  const PrimvarData& normals = Normals(moved);
  ASSERT_EQ(normals.interpolation, Interpolation::Vertex);
  double worst = 0, worstNormal = 1;
  for (size_t i = 0; i < moved.positions.size(); ++i) {
    const Float3& p = moved.positions[i];
    const double length = std::hypot(p.x, p.y, p.z);
    worst = std::max(worst, std::abs(length - 2.5));
    const float* n = &normals.values[3 * i];
    worstNormal = std::min(worstNormal, (p.x * n[0] + p.y * n[1] + p.z * n[2]) / length);
  }
  EXPECT_LT(worst, 1e-6 * 2.5);
  EXPECT_GT(worstNormal, std::cos(0.02));  // the tessellation's: an edge spans 0.1 radians
}

TEST_F(DisplacerTest, APlaneFollowsAFunctionOfItsCoordinates) {
  for (const bool seam : {false, true}) {
    const MeshData plane = Grid(24, seam), moved = Displaced(plane, {Kernel(Waves())});
    for (size_t i = 0; i < plane.positions.size(); ++i) {
      const Float3 &before = plane.positions[i], &after = moved.positions[i];
      EXPECT_EQ(before.x, after.x);
      EXPECT_EQ(before.y, after.y);
      EXPECT_NEAR(after.z, 0.25 * std::sin(6.0 * before.x), 2e-7) << i;
    }
    // Flat before, so smooth after: the gradient, but for the error of the mesh.
    const PrimvarData& normals = Normals(moved);
    ASSERT_EQ(normals.interpolation, Interpolation::Vertex);
    for (size_t i = 0; i < plane.positions.size(); ++i) {
      const double x = plane.positions[i].x, slope = 1.5 * std::cos(6 * x), length = std::hypot(1.0, slope);
      if (x == 0 || x == 1) continue;  // one-sided there
      EXPECT_NEAR(normals.values[3 * i], -slope / length, 0.02) << x;
      EXPECT_NEAR(normals.values[3 * i + 1], 0, 0.02);
    }
  }
}

TEST_F(DisplacerTest, AVectorIsInTangentSpace) {
  MaterialNetwork network = Constant(0);
  network.nodes[0] = {"/m/d", "ND_displacement_vector3", {{"displacement", Vector{0.1f, 0.2f, 0.3f}}, {"scale", 2.0f}}};
  MeshData plane = Grid(4);
  // dP/du along +y, dP/dv along -x, five times as long as those of the grid.
  PrimvarData& st = plane.primvars[0];
  for (size_t i = 0; i < plane.positions.size(); ++i) {
    st.values[2 * i] = 0.2f * plane.positions[i].y;
    st.values[2 * i + 1] = -0.2f * plane.positions[i].x;
  }
  const MeshData moved = Displaced(plane, {Kernel(network)});
  for (size_t i = 0; i < plane.positions.size(); ++i) {
    EXPECT_NEAR(moved.positions[i].x, plane.positions[i].x - 0.4, 1e-6);
    EXPECT_NEAR(moved.positions[i].y, plane.positions[i].y + 0.2, 1e-6);
    EXPECT_NEAR(moved.positions[i].z, 0.6, 1e-6);
  }
}

TEST_F(DisplacerTest, ATextureIsReadWhereThePointIs) {
  const TextureId texture = Texture(4, [](uint32_t x, uint32_t y) { return uint8_t(16 * (x + 4 * y)); });
  const MeshData plane = Grid(10), moved = Displaced(plane, {Kernel(Textured(3), texture)});
  for (size_t i = 0; i < plane.positions.size(); ++i) {
    // Bilinear between texel centres, held at the border.
    const double x = std::clamp(plane.positions[i].x * 4 - 0.5, 0.0, 3.0), y = std::clamp(plane.positions[i].y * 4 - 0.5, 0.0, 3.0);
    EXPECT_NEAR(moved.positions[i].z, 3 * (x + 4 * y) * 16 / 255, 2e-6) << i;
  }
}

// A mesh cannot show every other texel of a fine texture; it must not pick some of them either.
TEST_F(DisplacerTest, ATextureIsFilteredOverTheSpacingOfThePoints) {
  const TextureId texture = Texture(64, [](uint32_t x, uint32_t y) { return (x ^ y) & 1 ? 255 : 0; });
  const MeshData moved = Displaced(Grid(4), {Kernel(Textured(1), texture)});
  for (const Float3& p : moved.positions) EXPECT_NEAR(p.z, 0.5, 0.01);
  const MeshData fine = Displaced(Grid(128), {Kernel(Textured(1), texture)});
  const auto [low, high] = std::minmax_element(fine.positions.begin(), fine.positions.end(),
                                               [](const Float3& a, const Float3& b) { return a.z < b.z; });
  EXPECT_LT(low->z, 0.3);
  EXPECT_GT(high->z, 0.7);
}

TEST_F(DisplacerTest, SubsetsMeetWithoutAGap) {
  MeshData plane = Grid(8);
  plane.materialSlots.resize(plane.triangles.size());
  for (size_t t = 0; t < plane.triangles.size(); ++t) plane.materialSlots[t] = (t / 2) % 8 < 4 ? 0 : 1;
  const MeshData both = Displaced(plane, {Kernel(Constant(1)), Kernel(Constant(0.5f))});
  const MeshData one = Displaced(plane, {nullptr, Kernel(Constant(0.5f))});
  for (size_t i = 0; i < plane.positions.size(); ++i) {
    const float x = plane.positions[i].x;
    if (x == 0.5f) {  // three corners of one and three of the other; at both ends one and two, or two and one
      EXPECT_GT(both.positions[i].z, 0.6);
      EXPECT_LT(both.positions[i].z, 0.9);
      if (plane.positions[i].y != 0 && plane.positions[i].y != 1) {
        EXPECT_EQ(both.positions[i].z, 0.75f);
        EXPECT_EQ(one.positions[i].z, 0.25f);
      }
    } else {
      EXPECT_EQ(both.positions[i].z, x < 0.5f ? 1.0f : 0.5f);
      EXPECT_EQ(one.positions[i].z, x < 0.5f ? 0.0f : 0.5f);
    }
  }
}

TEST_F(DisplacerTest, EdgesOfFacetedBodiesStaySharpAndClosed) {
  MeshData box;
  for (int i = 0; i < 8; ++i) box.positions.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
  uint32_t face = 0;
  for (auto q : {std::array<uint32_t, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    box.triangles.push_back({q[0], q[1], q[2]});
    box.triangles.push_back({q[0], q[2], q[3]});
    box.faceIds.insert(box.faceIds.end(), {face, face});
    ++face;
  }
  const MeshData moved = Displaced(box, {Kernel(Constant(std::sqrt(3.0f)))});
  ASSERT_EQ(moved.positions.size(), 8u);
  const PrimvarData& normals = Normals(moved);
  ASSERT_EQ(normals.interpolation, Interpolation::FaceVarying);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(moved.positions[i].x, 2 * box.positions[i].x, 1e-6);
    EXPECT_NEAR(moved.positions[i].z, 2 * box.positions[i].z, 1e-6);
  }
  for (size_t corner = 0; corner < 36; ++corner) {
    const float* n = &normals.values[3 * normals.indices[corner]];
    EXPECT_NEAR(std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]), 1, 1e-6);
  }
}

TEST_F(DisplacerTest, WhatIsNoNumberStaysAndIsSaidOnce) {
  MaterialNetwork network = Waves();
  network.nodes[3] = {"/m/sin", "ND_divide_float", {{"in1", 1.0f}}};  // 1 / (6 u): infinite at u = 0
  network.connections[1] = {"/m/x", "out", "/m/sin", "in2"};
  const MeshData plane = Grid(4), moved = Displaced(plane, {Kernel(network)});
  ASSERT_EQ(said_.size(), 1u);
  EXPECT_EQ(said_[0].code, "displacement-not-finite");
  EXPECT_EQ(said_[0].location, "/grid");
  EXPECT_NE(said_[0].message.find(" 5 points"), std::string::npos);
  for (size_t i = 0; i < plane.positions.size(); ++i) {
    const double x = plane.positions[i].x;
    EXPECT_NEAR(moved.positions[i].z, x == 0 ? 0 : 0.25 / (6 * x), 1e-6);
  }
  const MeshData far = Displaced(plane, {Kernel(Constant(3e38f))});
  EXPECT_EQ(said_.size(), 1u);
  for (const Float3& p : far.positions) EXPECT_EQ(p.z, 0);
}

TEST_F(DisplacerTest, TheSameToTheBitAgain) {
  const auto kernel = Kernel(Waves());
  const MeshData a = Displaced(Grid(64, true), {kernel}), b = Displaced(Grid(64, true), {kernel});
  EXPECT_EQ(0, std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * sizeof(Float3)));
  EXPECT_EQ(Normals(a).values, Normals(b).values);
}

}  // namespace
}  // namespace wavefront
