// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which meshes are displaced, how finely they are cut for it, and what an edit of a displacement costs.
#include "delegate/displacement.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>

#include "delegate/mesh/split_triangles.h"
#include "tests/delegate/fakes.h"

namespace {

using delegate::MaterialUpdate;
using delegate::MeshUpdate;
using delegate_test::Fixture;
using delegate_test::Quad;

// A surface of value 1 and a displacement of `amount`, in the universal context.
MaterialUpdate Displacing(const std::string& path, float amount, float surface = 1) {
  materialgen::MaterialNetwork network = delegate_test::Network(path, "surface", surface);
  network.nodes.push_back({path + "/d", "bumps", {{"value", amount}}});
  network.displacementNode = path + "/d";
  network.displacementOutput = "out";
  return {{{"", network}}};
}

MeshUpdate Wearing(const std::string& material) {
  MeshUpdate mesh = Quad();
  mesh.material = material;
  return mesh;
}

const wavefront::MeshData& MeshOf(const Fixture& f, const std::string& path) {
  return f.renderer->meshes.at(f.renderer->InstancesOf(path).mesh);
}

// Edges with one triangle on one side only, by place.
size_t OpenEdges(const wavefront::MeshData& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const wavefront::UInt3& t : mesh.triangles) {
    if (t.x == t.y || t.y == t.z || t.z == t.x) continue;
    for (const auto& [a, b] : {std::pair{t.x, t.y}, {t.y, t.z}, {t.z, t.x}}) edges[std::minmax(a, b)] += a < b ? 1 : -1;
  }
  return static_cast<size_t>(std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second != 0; }));
}

TEST(DelegateDisplacement, OnlyWhatIsDisplacedIsRefined) {
  Fixture f;
  f.delegate->Sync("/moved", Wearing("/bumpy"));
  f.delegate->Sync("/still", Wearing("/flat"));
  f.delegate->Sync("/bumpy", Displacing("/bumpy", 0.5f));
  f.delegate->Sync("/flat", Displacing("/flat", 0));
  f.Commit();
  EXPECT_EQ(MeshOf(f, "/still").triangles.size(), 2u);
  EXPECT_TRUE(MeshOf(f, "/still").displacements.empty());
  const wavefront::MeshData& moved = MeshOf(f, "/moved");
  EXPECT_EQ(moved.triangles.size(), size_t{2} << 16);  // the first level with 100,000
  EXPECT_EQ(moved.path, "/moved");
  ASSERT_EQ(moved.displacements.size(), 1u);
  EXPECT_EQ(moved.displacements[0]->parameters[0].x, 0.5f);
  EXPECT_EQ(f.renderer->MaterialOf("/bumpy")->kernelKey, f.renderer->MaterialOf("/flat")->kernelKey);
}

TEST(DelegateDisplacement, AnEditMovesOnlyItsMeshAndCompilesNothing) {
  Fixture f;
  EXPECT_TRUE(f.delegate->SetRenderSetting("displacementTriangles", int64_t{30}).ok());
  for (const char* name : {"/a", "/b"}) {
    f.delegate->Sync(name, Wearing(std::string(name) + "m"));
    f.delegate->Sync(std::string(name) + "m", Displacing(std::string(name) + "m", 0.5f));
  }
  f.Commit();
  const auto before = f.delegate->counters();
  EXPECT_EQ(before.meshesBuilt, 2u);
  EXPECT_EQ(before.kernelsCompiled, 2u);  // the surface's and the displacement's
  f.delegate->Sync("/am", Displacing("/am", 0.75f));
  f.Commit();
  auto after = f.delegate->counters();
  EXPECT_EQ(after.meshesBuilt, 3u);
  EXPECT_EQ(after.kernelsCompiled, before.kernelsCompiled);
  EXPECT_EQ(after.materialsUploaded, before.materialsUploaded);
  ASSERT_EQ(MeshOf(f, "/a").displacements.size(), 1u);
  EXPECT_EQ(MeshOf(f, "/a").displacements[0]->parameters[0].x, 0.75f);
  f.delegate->Sync("/am", Displacing("/am", 0.75f, 2));  // the surface
  f.Commit();
  after = f.delegate->counters();
  EXPECT_EQ(after.meshesBuilt, 3u);
  EXPECT_EQ(after.materialsUploaded, before.materialsUploaded + 1);
  f.delegate->Sync("/am", Displacing("/am", 0, 2));
  f.Commit();
  EXPECT_EQ(MeshOf(f, "/a").triangles.size(), 2u);
  EXPECT_TRUE(MeshOf(f, "/a").displacements.empty());
  EXPECT_TRUE(f.delegate->SetRenderSetting("enableSceneMaterials", false).ok());
  f.Commit();
  EXPECT_EQ(MeshOf(f, "/b").triangles.size(), 2u);
}

TEST(DelegateDisplacement, SubsetsAndContextsAreFollowed) {
  Fixture f;
  EXPECT_TRUE(f.delegate->SetRenderSetting("displacementTriangles", int64_t{0}).ok());
  MeshUpdate mesh = Wearing("/flat");
  mesh.topology->subsets = {{"/mesh/half", {0}}};
  mesh.subsetMaterials = {{"/bumpy"}};
  f.delegate->Sync("/mesh", mesh);
  f.delegate->Sync("/flat", Displacing("/flat", 0));
  // The surface of one context, the displacement of another.
  MaterialUpdate bumpy{{{"mtlx", delegate_test::Network("/bumpy", "surface", 1)}}};
  bumpy.contexts.push_back(Displacing("/bumpy", 0.5f).contexts[0]);
  bumpy.contexts.back().second.surfaceNode.clear();
  f.delegate->Sync("/bumpy", bumpy);
  f.Commit();
  const wavefront::MeshData& built = MeshOf(f, "/mesh");
  ASSERT_EQ(built.displacements.size(), 2u);
  EXPECT_FALSE(built.displacements[0]);
  ASSERT_TRUE(built.displacements[1]);
  EXPECT_EQ(built.triangles.size(), 2u);  // no finer than it is: the setting says so
}

TEST(DelegateDisplacement, LevelsFollowThePrimvarTheSettingAndTheBound) {
  Fixture f;
  EXPECT_TRUE(f.delegate->SetRenderSetting("displacementTriangles", int64_t{30}).ok());
  MeshUpdate mesh = Wearing("/bumpy");
  f.delegate->Sync("/mesh", mesh);
  f.delegate->Sync("/bumpy", Displacing("/bumpy", 0.5f));
  f.Commit();
  EXPECT_EQ(MeshOf(f, "/mesh").triangles.size(), 32u);
  mesh.primvars = {{delegate::kDisplacementLevelPrimvar, "constant", 1, {1}, {}}};
  f.delegate->Sync("/mesh", mesh);
  f.Commit();
  EXPECT_EQ(MeshOf(f, "/mesh").triangles.size(), 8u);
  mesh.primvars->clear();
  mesh.topology->scheme = "catmullClark";
  mesh.refineLevel = 3;
  f.delegate->Sync("/mesh", mesh);
  f.Commit();
  EXPECT_EQ(MeshOf(f, "/mesh").triangles.size(), 128u);
  EXPECT_FALSE(f.Codes().count("displacement-coarse"));

  delegate::MeshInput fine;
  fine.topology = *mesh.topology;
  fine.topology.scheme = "none";
  EXPECT_EQ(delegate::ChooseDisplacementLevel(fine, {1000, 100}).level, 2);  // 32; the next would be 128
  EXPECT_EQ(delegate::ChooseDisplacementLevel(fine, {uint64_t{1} << 40, uint64_t{1} << 40}).level, 8);
}

TEST(DelegateDisplacement, AllOfASceneStayWithinMemory) {
  Fixture f;
  EXPECT_TRUE(f.delegate->SetRenderSetting("displacementTriangles", int64_t{100'000}).ok());
  f.delegate->Sync("/bumpy", Displacing("/bumpy", 0.5f));
  for (int i = 0; i < 70; ++i) f.delegate->Sync("/mesh" + std::to_string(i), Wearing("/bumpy"));
  f.Commit();
  EXPECT_EQ(f.Codes().count("displacement-coarse"), 1u);
  EXPECT_EQ(MeshOf(f, "/mesh0").triangles.size(), size_t{2} << 14);  // 70 x 131,072 are too many
}

TEST(DelegateDisplacement, ImplicitShapesBecomeClosedMeshesOfTheirOwn) {
  Fixture f;
  f.delegate->Sync("/bumpy", Displacing("/bumpy", 0.5f));
  const auto shapes = {delegate::ImplicitShape::Sphere, delegate::ImplicitShape::Cube, delegate::ImplicitShape::Cone,
                       delegate::ImplicitShape::Cylinder, delegate::ImplicitShape::Capsule};
  for (const auto shape : shapes) {
    delegate::ImplicitUpdate update;
    update.shape.emplace();
    update.shape->shape = shape;
    update.material = "/bumpy";
    f.delegate->Sync("/a", update);
    f.delegate->Sync("/b", update);
    f.Commit();
    EXPECT_EQ(f.renderer->meshes.size(), 2u);
    const wavefront::MeshData& mesh = MeshOf(f, "/a");
    EXPECT_GE(mesh.triangles.size(), 100'000u);
    EXPECT_EQ(OpenEdges(mesh), 0u) << static_cast<int>(shape);
    EXPECT_EQ(mesh.displacements.size(), 1u);
  }
  f.delegate->Sync("/bumpy", Displacing("/bumpy", 0));
  f.Commit();
  EXPECT_EQ(f.renderer->meshes.size(), 1u);  // shared again
}

TEST(SplitTriangles, KeepsTheSurfaceAndWhatIsOnIt) {
  wavefront::MeshData mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 2}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.faceIds = {7, 9};
  mesh.materialSlots = {0, 1};
  // The second triangle has texture coordinates of its own on the shared edge.
  mesh.primvars = {{"st", wavefront::Interpolation::FaceVarying, 2, {0, 0, 1, 0, 1, 1, 5, 5, 6, 6, 5, 6}, {0, 1, 2, 3, 4, 5}},
                   {"normals", wavefront::Interpolation::Vertex, 3, {0, 0, 1, 0, 0, 1, 0, 0, 1, 1, 0, 0}, {}}};
  delegate::SplitTriangles(mesh, 2);
  ASSERT_EQ(mesh.triangles.size(), 32u);
  EXPECT_EQ(mesh.positions.size(), 25u);  // 15 + 15 - the 5 on the shared edge
  double area = 0;
  for (size_t t = 0; t < 32; ++t) {
    EXPECT_EQ(mesh.faceIds[t], t < 16 ? 7u : 9u);
    EXPECT_EQ(mesh.materialSlots[t], t < 16 ? 0 : 1);
    const uint32_t corners[] = {mesh.triangles[t].x, mesh.triangles[t].y, mesh.triangles[t].z};
    const wavefront::Float3 &a = mesh.positions[corners[0]], &b = mesh.positions[corners[1]], &c = mesh.positions[corners[2]];
    area += 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
    for (size_t k = 0; k < 3; ++k) {
      const wavefront::Float3& p = mesh.positions[corners[k]];
      const float* st = &mesh.primvars[0].values[2 * mesh.primvars[0].indices[3 * t + k]];
      EXPECT_FLOAT_EQ(st[0], t < 16 ? p.x / 2 : 5 + p.x / 2);
      EXPECT_FLOAT_EQ(st[1], t < 16 ? p.y / 2 : 5 + p.y / 2);
      const float* n = &mesh.primvars[1].values[3 * corners[k]];
      EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);
    }
  }
  EXPECT_DOUBLE_EQ(area, 4);
}

}  // namespace
