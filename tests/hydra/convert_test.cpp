// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Hydra's values to the delegate's updates: values, primvars, meshes, implicit shapes, instancers, images, settings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pxr/base/gf/half.h>
#include <pxr/base/gf/matrix3d.h>
#include <pxr/base/gf/quath.h>
#include <pxr/base/gf/vec2d.h>
#include <pxr/base/gf/vec3h.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/pxOsd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include <bit>
#include <cstring>

#include "plugin/hydra/convert_image.h"
#include "plugin/hydra/convert_instancer.h"
#include "plugin/hydra/convert_mesh.h"
#include "plugin/hydra/convert_primvars.h"
#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ConvertValue, NumbersOfEveryKindBecomeFloats) {
  const auto floats = ToFloats(VtValue(VtArray<GfVec3h>{GfVec3h(1, 2, 3), GfVec3h(4, 5, 6)}));
  ASSERT_TRUE(floats);
  EXPECT_EQ(floats->components, 3u);
  EXPECT_TRUE(floats->isArray);
  EXPECT_THAT(floats->values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(ToFloats(VtValue(GfVec2d(0.5, -1)))->components, 2u);
  EXPECT_THAT(ToFloats(VtValue(VtArray<bool>{true, false}))->values, ElementsAre(1, 0));
  EXPECT_THAT(ToFloats(VtValue(7))->values, ElementsAre(7));
  EXPECT_EQ(ToFloats(VtValue(GfMatrix3d(1)))->components, 9u);
}

TEST(ConvertValue, WhatHoldsNoNumbersIsNothing) {
  EXPECT_FALSE(ToFloats(VtValue()));
  EXPECT_FALSE(ToFloats(VtValue(std::string("1"))));
  EXPECT_FALSE(ToFloats(VtValue(SdfAssetPath("a.png"))));
  EXPECT_FALSE(ToFloats(VtValue(VtQuathArray{GfQuath(1)})));
}

TEST(ConvertValue, QuaternionsHaveTheirRealPartLast) {
  const auto q = ToQuaternions(VtValue(VtQuathArray{GfQuath(0.5, 1, 2, 3)}));
  ASSERT_TRUE(q);
  EXPECT_EQ((*q)[0].x, 1);
  EXPECT_EQ((*q)[0].z, 3);
  EXPECT_EQ((*q)[0].w, 0.5f);
}

TEST(ConvertValue, MatricesKeepRowsAndBits) {
  GfMatrix4d m(1);
  m[3][0] = 1.0 / 3;
  m[0][1] = -2;
  const wavefront::Matrix4d converted = ToMatrix(m);
  EXPECT_EQ(converted.m[3][0], 1.0 / 3);
  EXPECT_EQ(converted.m[0][1], -2);
}

TEST(ConvertValue, ParametersKeepTheirType) {
  EXPECT_TRUE(std::get<bool>(ToParameter(VtValue(true))));
  EXPECT_EQ(std::get<int32_t>(ToParameter(VtValue(3))), 3);
  EXPECT_EQ(std::get<float>(ToParameter(VtValue(0.25))), 0.25f);
  EXPECT_EQ(std::get<std::string>(ToParameter(VtValue(TfToken("repeat")))), "repeat");
  EXPECT_THAT((std::get<std::array<float, 3>>(ToParameter(VtValue(GfVec3f(1, 2, 3))))), ElementsAre(1, 2, 3));
  EXPECT_TRUE(std::holds_alternative<std::monostate>(ToParameter(VtValue(VtFloatArray{1, 2, 3}))));
}

TEST(ConvertValue, AssetsTellWhatWasAuthoredAndFound) {
  const auto asset = ToAsset(VtValue(SdfAssetPath("a.png", "/x/a.png")));
  EXPECT_EQ(asset.authoredPath, "a.png");
  EXPECT_EQ(asset.resolvedPath, "/x/a.png");
  EXPECT_EQ(ToAsset(VtValue(SdfAssetPath("a.png"))).resolvedPath, "");
  EXPECT_EQ(ToAsset(VtValue(SdfAssetPath("/x/a.<UDIM>.png"))).resolvedPath, "/x/a.<UDIM>.png");
}

TEST(ConvertPrimvars, SkinningAndOtherRenderersSettingsAreLeftOut) {
  EXPECT_TRUE(IsShadingPrimvar(TfToken("st")));
  EXPECT_TRUE(IsShadingPrimvar(HdTokens->normals));
  for (const char* name : {"points", "velocities", "skel:jointIndices", "ri:attributes:x", "arnold:opaque"})
    EXPECT_FALSE(IsShadingPrimvar(TfToken(name))) << name;
}

TEST(ConvertPrimvars, KeepsIndicesAndInterpolation) {
  const auto primvar = ToPrimvar(TfToken("st"), ToInterpolation(HdInterpolationFaceVarying),
                                 VtValue(VtVec2fArray{GfVec2f(0, 1), GfVec2f(2, 3)}), {1, 0, 1});
  ASSERT_TRUE(primvar);
  EXPECT_EQ(primvar->name, "st");
  EXPECT_EQ(primvar->interpolation, "faceVarying");
  EXPECT_EQ(primvar->components, 2u);
  EXPECT_THAT(primvar->values, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(primvar->indices, ElementsAre(1, 0, 1));
  EXPECT_FALSE(ToPrimvar(TfToken("m"), "constant", VtValue(GfMatrix4d(1)), {}));
  EXPECT_FALSE(ToPrimvar(TfToken("e"), "constant", VtValue(VtFloatArray()), {}));
}

HdMeshTopology Quads() {
  HdMeshTopology topology(PxOsdOpenSubdivTokens->catmullClark, PxOsdOpenSubdivTokens->leftHanded, {4, 4},
                          {0, 1, 2, 3, 3, 2, 4, 5}, {1}, /*refineLevel=*/0);
  topology.SetGeomSubsets({{HdGeomSubset::TypeFaceSet, SdfPath("/m/a"), SdfPath("/red"), {1}},
                           {HdGeomSubset::TypeFaceSet, SdfPath("/m/b"), SdfPath(), {0}}});
  return topology;
}

TEST(ConvertMesh, TopologyTagsAndSubsets) {
  const PxOsdSubdivTags tags(PxOsdOpenSubdivTokens->edgeOnly, PxOsdOpenSubdivTokens->boundaries, TfToken(),
                             PxOsdOpenSubdivTokens->smooth, {0, 1}, {2}, {5.0f}, {3}, {10.0f});
  const delegate::MeshTopology t = ToTopology(Quads(), tags);
  EXPECT_EQ(t.scheme, "catmullClark");
  EXPECT_EQ(t.orientation, "leftHanded");
  EXPECT_THAT(t.faceVertexCounts, ElementsAre(4, 4));
  EXPECT_THAT(t.holeIndices, ElementsAre(1));
  EXPECT_EQ(t.interpolateBoundary, "edgeOnly");
  EXPECT_EQ(t.faceVaryingLinearInterpolation, "boundaries");
  EXPECT_EQ(t.triangleSubdivisionRule, "smooth");
  EXPECT_THAT(t.creaseIndices, ElementsAre(0, 1));
  EXPECT_THAT(t.creaseLengths, ElementsAre(2));
  EXPECT_THAT(t.creaseSharpnesses, ElementsAre(5));
  EXPECT_THAT(t.cornerIndices, ElementsAre(3));
  EXPECT_THAT(t.cornerSharpnesses, ElementsAre(10));
  ASSERT_EQ(t.subsets.size(), 2u);
  EXPECT_EQ(t.subsets[0].path, "/m/a");
  EXPECT_THAT(t.subsets[0].indices, ElementsAre(1));
  EXPECT_THAT(ToSubsetMaterials(Quads(), SdfPath("/blue")), ElementsAre("/red", "/blue"));
}

TEST(ConvertMesh, TokensThatAreEmptyKeepUsdsFallbacks) {
  const delegate::MeshTopology t = ToTopology(Quads(), PxOsdSubdivTags());
  EXPECT_EQ(t.interpolateBoundary, "edgeAndCorner");
  EXPECT_EQ(t.triangleSubdivisionRule, "catmullClark");
}

TEST(ConvertMesh, ImplicitShapesTakeTheirOwnFallbacks) {
  const auto none = [](const TfToken&) { return VtValue(); };
  EXPECT_EQ(ToImplicit(delegate::ImplicitShape::Capsule, none).radius, 0.5);
  EXPECT_EQ(ToImplicit(delegate::ImplicitShape::Capsule, none).height, 1);
  EXPECT_EQ(ToImplicit(delegate::ImplicitShape::Cone, none).radius, 1);
  const auto cone = ToImplicit(delegate::ImplicitShape::Cone, [](const TfToken& name) {
    return name == TfToken("axis") ? VtValue(TfToken("X")) : name == TfToken("height") ? VtValue(3.0) : VtValue();
  });
  EXPECT_EQ(cone.axis, "X");
  EXPECT_EQ(cone.height, 3);
  EXPECT_EQ(ToImplicitShape(HdPrimTypeTokens->cube), delegate::ImplicitShape::Cube);
  EXPECT_FALSE(ToImplicitShape(HdPrimTypeTokens->mesh));
}

delegate::InstancerUpdate Instances(const std::map<TfToken, VtValue>& values, size_t count = 0) {
  HdPrimvarDescriptorVector primvars;
  for (const auto& [name, value] : values) primvars.emplace_back(name, HdInterpolationInstance);
  delegate::InstancerUpdate update;
  ToInstances(primvars, [&](const HdPrimvarDescriptor& p, VtIntArray*) { return values.at(p.name); }, count, update);
  return update;
}

TEST(ConvertInstancer, ArraysOfPointInstancers) {
  const auto update = Instances({{HdInstancerTokens->instanceTranslations, VtValue(VtVec3fArray{GfVec3f(1, 2, 3)})},
                                 {HdInstancerTokens->instanceScales, VtValue(VtVec3fArray{GfVec3f(2)})},
                                 {HdInstancerTokens->instanceRotations, VtValue(VtQuathArray{GfQuath(1)})},
                                 {TfToken("displayColor"), VtValue(VtVec3fArray{GfVec3f(1, 0, 0)})}});
  EXPECT_EQ(update.positions->front().value[0].y, 2);
  EXPECT_EQ(update.scales->front().value[0].x, 2);
  EXPECT_EQ(update.orientations->front().value[0].w, 1);
  EXPECT_THAT(update.transforms->front().value, IsEmpty());
  ASSERT_EQ(update.primvars->size(), 1u);
  EXPECT_EQ(update.primvars->front().interpolation, "instance");
}

TEST(ConvertInstancer, MatricesAndArraysAtOnceAreMultiplied) {
  GfMatrix4d m(1);
  m.SetTranslate(GfVec3d(1, 0, 0));
  const auto update = Instances({{HdInstancerTokens->instanceTransforms, VtValue(VtMatrix4dArray{m})},
                                 {HdInstancerTokens->instanceScales, VtValue(VtVec3fArray{GfVec3f(2)})},
                                 {HdInstancerTokens->instanceTranslations, VtValue(VtVec3fArray{GfVec3f(0, 5, 0)})}});
  const wavefront::Matrix4d& result = update.transforms->front().value[0];
  EXPECT_EQ(result.m[3][0], 2);  // moved by 1, then scaled by 2
  EXPECT_EQ(result.m[3][1], 5);
  EXPECT_THAT(update.positions->front().value, IsEmpty());
}

TEST(ConvertInstancer, AnInstancerThatSaysNothingKeepsItsInstancesInPlace) {
  const auto update = Instances({}, 3);
  ASSERT_EQ(update.transforms->front().value.size(), 3u);
  EXPECT_EQ(update.transforms->front().value[2].m[0][0], 1);
}

TEST(ConvertImage, OnlyWhatIsFilledIsClaimed) {
  EXPECT_EQ(ToAovDescriptor(HdAovTokens->color).format, HdFormatFloat32Vec4);
  EXPECT_EQ(ToAovDescriptor(HdAovTokens->primId).format, HdFormatInt32);
  EXPECT_EQ(ToAovDescriptor(HdAovTokens->primId).clearValue, VtValue(-1));
  EXPECT_EQ(ToAovDescriptor(HdAovTokens->depth).clearValue, VtValue(1.0f));
  EXPECT_EQ(ToAovDescriptor(TfToken("primvars:st")).format, HdFormatFloat32Vec3);
  EXPECT_EQ(ToAovDescriptor(TfToken("lpe:C.*")).format, HdFormatInvalid);
}

wavefront::AovImage Ramp(wavefront::Aov aov, uint32_t width, uint32_t height, uint32_t components) {
  wavefront::AovImage image{aov, width, height, components, {}};
  for (uint32_t i = 0; i < width * height * components; ++i) image.bits.push_back(std::bit_cast<uint32_t>(float(i)));
  return image;
}

TEST(ConvertImage, RowsAreTurnedOver) {
  std::vector<uint8_t> pixels = ClearedPixels(2, 2, HdFormatFloat32, VtValue(9.0f));
  CopyImage(Ramp(wavefront::Aov::Depth, 2, 2, 1), 0, 0, 2, 2, HdFormatFloat32, pixels);
  const auto* values = reinterpret_cast<const float*>(pixels.data());
  EXPECT_THAT(std::vector<float>(values, values + 4), ElementsAre(2, 3, 0, 1));
}

TEST(ConvertImage, ADataWindowLiesInTheBufferAndIsCutAtItsEdge) {
  std::vector<uint8_t> pixels = ClearedPixels(3, 2, HdFormatFloat32, VtValue(9.0f));
  CopyImage(Ramp(wavefront::Aov::Depth, 2, 2, 1), 2, 1, 3, 2, HdFormatFloat32, pixels);
  const auto* values = reinterpret_cast<const float*>(pixels.data());
  EXPECT_THAT(std::vector<float>(values, values + 6), ElementsAre(9, 9, 0, 9, 9, 9));
}

TEST(ConvertImage, FormatsAreConverted) {
  wavefront::AovImage image{wavefront::Aov::Color, 1, 1, 4, {}};
  for (const float v : {0.5f, 2.0f, -1.0f, 1.0f}) image.bits.push_back(std::bit_cast<uint32_t>(v));
  std::vector<uint8_t> bytes = ClearedPixels(1, 1, HdFormatUNorm8Vec4, VtValue());
  CopyImage(image, 0, 0, 1, 1, HdFormatUNorm8Vec4, bytes);
  EXPECT_THAT(bytes, ElementsAre(128, 255, 0, 255));
  std::vector<uint8_t> halves = ClearedPixels(1, 1, HdFormatFloat16Vec4, VtValue());
  CopyImage(image, 0, 0, 1, 1, HdFormatFloat16Vec4, halves);
  uint16_t bits[4];
  std::memcpy(bits, halves.data(), 8);
  EXPECT_EQ(bits[0], GfHalf(0.5f).bits());
}

TEST(ConvertSettings, EveryRowHasADescriptorOfItsNamespace) {
  const auto descriptors = SettingDescriptors();
  ASSERT_EQ(descriptors.size(), delegate::RenderSettingInfos().size() + ColorSettingInfos().size());
  for (const auto& descriptor : descriptors) {
    EXPECT_TRUE(descriptor.key.GetString().starts_with("wavefront:"));
    EXPECT_TRUE(IsOwnSetting(descriptor.key));
    if (descriptor.defaultValue.IsHolding<std::string>() && ToCoreSetting(descriptor.key).empty()) {
      EXPECT_TRUE(WithColorSetting(descriptor.key, descriptor.defaultValue, {}) == ColorSettings()) << descriptor.key;
      continue;
    }
    EXPECT_FALSE(ToCoreSetting(descriptor.key).empty());
    const VtValue& v = descriptor.defaultValue;
    EXPECT_TRUE(v.IsHolding<bool>() || v.IsHolding<int>() || v.IsHolding<float>() || v.IsHolding<std::string>()) << descriptor.key;
  }
  EXPECT_EQ(ToCoreSetting(HdRenderSettingsTokens->convergedSamplesPerPixel), "convergedSamplesPerPixel");
  EXPECT_EQ(ToCoreSetting(TfToken("wavefront:nothing")), "");
}

}  // namespace
}  // namespace hydra
