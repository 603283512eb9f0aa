// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Hydra's cameras, framing, lights, materials and products to the delegate's updates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pxr/base/gf/camera.h>
#include <pxr/base/gf/frustum.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdf/assetPath.h>

#include "plugin/hydra/convert_camera.h"
#include "plugin/hydra/convert_light.h"
#include "plugin/hydra/convert_material.h"
#include "plugin/hydra/exr_writer.h"
#include "plugin/hydra/products.h"

namespace hydra {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class TestCamera : public HdCamera {
 public:
  // As UsdImaging scales.
  TestCamera(float aperture, float focalLength) : HdCamera(SdfPath("/camera")) {
    _horizontalAperture = aperture * float(GfCamera::APERTURE_UNIT);
    _verticalAperture = _horizontalAperture;
    _focalLength = focalLength * float(GfCamera::FOCAL_LENGTH_UNIT);
    _clippingRange = GfRange1f(0.5f, 100);
    _fStop = 2.8f;
    _focusDistance = 7;
    _exposure = 1;
  }
};

// What `hdwavefront record` hands over, authored numbers in tenths, is the same camera to the bit.
TEST(ConvertCamera, ItIsTheAuthoredCameraToTheBit) {
  for (const std::string projection : {"orthographic", "perspective"})
    for (const float aperture : {20.955f, 15.2908f, 36.0f, 23.6f, 24.892f, 0.1f, 0.2f, 0.70000005f})
      for (const float focal : {50.0f, 35.0f, 18.147562f, 85.3f, 14.0f}) {
        delegate::CameraParams authored;
        authored.projection = projection;
        authored.horizontalAperture = authored.verticalAperture = aperture;
        authored.focalLength = focal;
        authored.fStop = 2.8f;
        authored.focusDistance = 7;
        auto params = ToCameraParams(TestCamera(aperture, focal), [](const TfToken&) { return VtValue(); });
        params.projection = projection;
        const auto convert = [](const delegate::CameraParams& p) {
          return ConvertCamera("/camera", p, {{0, {}}}, 1.5, delegate::ConformPolicy::Fit, [](const auto&) {});
        };
        const auto ours = convert(params), theirs = convert(authored);
        EXPECT_EQ(ours.left, theirs.left) << projection << " " << aperture << " " << focal;
        EXPECT_EQ(ours.top, theirs.top) << projection << " " << aperture << " " << focal;
        EXPECT_EQ(ours.lensRadius, theirs.lensRadius) << projection << " " << aperture << " " << focal;
      }
}

TEST(ConvertCamera, LensAndExposure) {
  const TestCamera camera(36, 50);
  const auto params = ToCameraParams(camera, [](const TfToken& name) {
    return name == TfToken("exposure:iso") ? VtValue(200.0f) : VtValue();
  });
  EXPECT_EQ(params.projection, "perspective");
  EXPECT_EQ(params.clippingNear, 0.5f);
  EXPECT_EQ(params.fStop, 2.8f);
  EXPECT_EQ(params.focusDistance, 7);
  EXPECT_EQ(params.exposure, 1);
  EXPECT_EQ(params.exposureIso, 200);
  EXPECT_EQ(params.exposureTime, 1);
}

TEST(ConvertCamera, MatricesGiveBackTheFrustum) {
  GfFrustum frustum;
  frustum.SetWindow(GfRange2d(GfVec2d(-0.3, -0.1), GfVec2d(0.5, 0.4)));
  frustum.SetNearFar(GfRange1d(0.25, 40));
  auto params = ToCameraParams(frustum.ComputeProjectionMatrix());
  EXPECT_EQ(params.projection, "perspective");
  EXPECT_NEAR(params.horizontalAperture, 0.8, 1e-6);
  EXPECT_NEAR(params.horizontalApertureOffset, 0.1, 1e-6);
  EXPECT_NEAR(params.verticalApertureOffset, 0.15, 1e-6);
  EXPECT_NEAR(params.clippingNear, 0.25, 1e-6);
  EXPECT_NEAR(params.clippingFar, 40, 1e-4);
  frustum.SetProjectionType(GfFrustum::Orthographic);
  params = ToCameraParams(frustum.ComputeProjectionMatrix());
  EXPECT_EQ(params.projection, "orthographic");
  EXPECT_NEAR(params.verticalAperture, 0.5, 1e-6);
  EXPECT_NEAR(params.horizontalApertureOffset, 0.1, 1e-6);
  EXPECT_NEAR(params.clippingFar, 40, 1e-4);
}

TEST(ConvertCamera, FramingTellsThePartThatIsRendered) {
  const CameraUtilFraming framing(GfRange2f(GfVec2f(0, 0), GfVec2f(200, 100)),
                                  GfRect2i(GfVec2i(50, 0), 100, 25), 2.0f);
  const PassFraming f = ToPassFraming(framing, GfVec4f(0));
  EXPECT_EQ(f.width, 100u);
  EXPECT_EQ(f.height, 25u);
  EXPECT_EQ(f.pixelAspectRatio, 2);
  EXPECT_EQ(f.part, (delegate::DataWindow{0.25, 0.75, 0.75, 1}));  // rows count from the top
  EXPECT_EQ(f.x, 50);
  const PassFraming viewport = ToPassFraming(CameraUtilFraming(), GfVec4f(0, 0, 64, 48));
  EXPECT_EQ(viewport.width, 64u);
  EXPECT_EQ(viewport.part, delegate::DataWindow());
}

LightValues Values(std::map<std::string, VtValue> values) {
  return [values = std::move(values)](const TfToken& name) {
    const auto found = values.find(name.GetString());
    return found == values.end() ? VtValue() : found->second;
  };
}

TEST(ConvertLight, InputsByUsdLuxsNames) {
  const auto params = ToLightParams(
      HdPrimTypeTokens->rectLight,
      Values({{"intensity", VtValue(3.0f)}, {"color", VtValue(GfVec3f(1, 0.5, 0))}, {"normalize", VtValue(true)},
              {"width", VtValue(2.0f)}, {"texture:file", VtValue(SdfAssetPath("a.exr", "/a.exr"))},
              {"visibility:camera", VtValue(false)}}));
  EXPECT_EQ(params.type, "RectLight");
  EXPECT_EQ(params.intensity, 3);
  EXPECT_EQ(params.color.y, 0.5f);
  EXPECT_TRUE(params.normalize);
  EXPECT_EQ(params.width, 2);
  EXPECT_EQ(params.height, 1);
  EXPECT_EQ(params.texture.resolvedPath, "/a.exr");
  EXPECT_FALSE(params.visibleToCamera);
  EXPECT_FALSE(params.shaping);
}

TEST(ConvertLight, ShapingCountsWhereItsApiIsApplied) {
  const auto params =
      ToLightParams(HdPrimTypeTokens->sphereLight, Values({{"shaping:cone:softness", VtValue(0.25f)}}));
  ASSERT_TRUE(params.shaping);
  EXPECT_EQ(params.shaping->coneAngle, 90);
  EXPECT_EQ(params.shaping->coneSoftness, 0.25f);
}

TEST(ConvertLight, WhatIsNotRenderedIsTold) {
  EXPECT_THAT(UnsupportedLightInputs(
                  Values({{"shadow:color", VtValue(GfVec3f(0))}, {"shadow:distance", VtValue(-1.0f)}})),
              IsEmpty());
  std::vector<std::string> codes;
  for (const auto& [code, message] : UnsupportedLightInputs(
           Values({{"shadow:color", VtValue(GfVec3f(1, 0, 0))}, {"filters", VtValue(SdfPathVector{SdfPath("/f")})},
                   {"lightLink", VtValue(TfToken("group"))}})))
    codes.push_back(code);
  EXPECT_THAT(codes, ElementsAre("light-unsupported-input", "light-filter-unsupported", "light-link-unsupported"));
}

HdMaterialNetworkMap Network() {
  HdMaterialNetwork network;
  HdMaterialNode reader{SdfPath("/m/reader"), TfToken("UsdPrimvarReader_float2"), {}};
  reader.parameters[TfToken("varname")] = VtValue(std::string("st"));
  HdMaterialNode texture{SdfPath("/m/texture"), TfToken("UsdUVTexture"), {}};
  texture.parameters[TfToken("file")] = VtValue(SdfAssetPath("a.png", "/a.png"));
  texture.parameters[TfToken("colorSpace:file")] = VtValue(TfToken("sRGB"));
  HdMaterialNode surface{SdfPath("/m/surface"), TfToken("UsdPreviewSurface"), {}};
  surface.parameters[TfToken("roughness")] = VtValue(0.25f);
  surface.parameters[TfToken("typeName:roughness")] = VtValue(TfToken("float"));
  network.nodes = {reader, texture, surface};
  network.relationships = {{reader.path, TfToken("result"), texture.path, TfToken("st")},
                           {texture.path, TfToken("rgb"), surface.path, TfToken("diffuseColor")}};
  HdMaterialNetworkMap map;
  map.map[HdMaterialTerminalTokens->surface] = network;
  map.terminals = {surface.path};
  return map;
}

TEST(ConvertMaterial, NodesComeFromTheSurfaceDown) {
  const ConvertedMaterial material = ToMaterial(SdfPath("/m"), Network());
  EXPECT_THAT(material.messages, IsEmpty());
  ASSERT_EQ(material.update.contexts.size(), 1u);
  EXPECT_EQ(material.update.contexts[0].first, "");
  const materialgen::MaterialNetwork& network = material.update.contexts[0].second;
  EXPECT_EQ(network.surfaceNode, "/m/surface");
  ASSERT_EQ(network.nodes.size(), 3u);
  EXPECT_EQ(network.nodes[0].path, "/m/surface");
  EXPECT_EQ(network.nodes[2].identifier, "UsdPrimvarReader_float2");
  EXPECT_EQ(network.nodes[0].parameters.size(), 1u);
  const auto& file = std::get<materialgen::AssetValue>(network.nodes[1].parameters.at("file"));
  EXPECT_EQ(file.resolvedPath, "/a.png");
  EXPECT_EQ(file.colorSpace, "sRGB");
  ASSERT_EQ(network.connections.size(), 2u);
  EXPECT_EQ(network.connections[0].upstreamNode, "/m/texture");
  EXPECT_EQ(network.connections[0].upstreamOutput, "rgb");
  EXPECT_EQ(network.connections[0].downstreamInput, "diffuseColor");
}

TEST(ConvertMaterial, MaterialXIsToldByItsDefinitions) {
  HdMaterialNetworkMap map = Network();
  map.map[HdMaterialTerminalTokens->surface].nodes.back().identifier = TfToken("ND_open_pbr_surface_surfaceshader");
  EXPECT_EQ(ToMaterial(SdfPath("/m"), map).update.contexts[0].first, "mtlx");
}

TEST(ConvertMaterial, DisplacementIsATerminalOfTheSurfacesNetworkOrHasItsOwn) {
  HdMaterialNetworkMap map = Network();
  auto& displacement = map.map[HdMaterialTerminalTokens->displacement];
  displacement = map.map[HdMaterialTerminalTokens->surface];
  const ConvertedMaterial shared = ToMaterial(SdfPath("/m"), map);
  ASSERT_EQ(shared.update.contexts.size(), 1u);
  EXPECT_EQ(shared.update.contexts[0].second.displacementNode, "/m/surface");
  EXPECT_EQ(shared.update.contexts[0].second.displacementOutput, "displacement");
  EXPECT_EQ(shared.update.contexts[0].second.surfaceNode, "/m/surface");
  displacement.nodes = {displacement.nodes.back()};
  displacement.nodes[0].path = SdfPath("/m/bumps");
  displacement.nodes[0].identifier = TfToken("ND_displacement_float");
  displacement.relationships.clear();
  const ConvertedMaterial own = ToMaterial(SdfPath("/m"), map);
  ASSERT_EQ(own.update.contexts.size(), 2u);
  EXPECT_EQ(own.update.contexts[1].first, "mtlx");
  EXPECT_EQ(own.update.contexts[1].second.displacementNode, "/m/bumps");
  EXPECT_EQ(own.update.contexts[1].second.surfaceNode, "");
}

TEST(ConvertMaterial, WhatIsNotRenderedIsTold) {
  HdMaterialNetworkMap map = Network();
  map.map[HdMaterialTerminalTokens->volume] = map.map[HdMaterialTerminalTokens->surface];
  ASSERT_EQ(ToMaterial(SdfPath("/m"), map).messages.size(), 1u);
  const ConvertedMaterial empty = ToMaterial(SdfPath("/m"), HdMaterialNetworkMap());
  EXPECT_THAT(empty.update.contexts, IsEmpty());
  EXPECT_THAT(empty.messages, IsEmpty());  // the core's to tell
}

TEST(ConvertMaterial, ACycleEnds) {
  HdMaterialNetworkMap map = Network();
  auto& network = map.map[HdMaterialTerminalTokens->surface];
  network.relationships.push_back({SdfPath("/m/surface"), TfToken("surface"), SdfPath("/m/reader"), TfToken("x")});
  EXPECT_EQ(ToMaterial(SdfPath("/m"), map).update.contexts[0].second.nodes.size(), 3u);
}

HdRenderSettings::RenderProduct RawProduct(const char* name) {
  HdRenderSettings::RenderProduct product;
  product.productPath = SdfPath("/Render/p");
  product.type = TfToken("raster");
  product.name = TfToken(name);
  product.resolution = GfVec2i(80, 60);
  product.pixelAspectRatio = 1;
  product.disableDepthOfField = product.disableMotionBlur = false;
  product.dataWindowNDC = GfRange2f(GfVec2f(0), GfVec2f(1));
  product.renderVars.resize(2);
  product.renderVars[0].sourceName = "Ci";
  product.renderVars[1].sourceName = "depth";
  return product;
}

std::vector<std::string> CodesOf(const ConvertedProducts& converted) {
  std::vector<std::string> codes;
  for (const auto& [path, code, text] : converted.messages) codes.push_back(code);
  return codes;
}

TEST(Products, FramingAndAovs) {
  auto raw = RawProduct("a.exr");
  raw.dataWindowNDC = GfRange2f(GfVec2f(0.5, 0), GfVec2f(1, 1));
  const ConvertedProducts converted = ToProducts({raw});
  ASSERT_EQ(converted.products.size(), 1u);
  EXPECT_THAT(converted.products[0].aovs, ElementsAre("color", "depth"));
  EXPECT_EQ(converted.products[0].view.framing.width, 40u);
  EXPECT_EQ(converted.products[0].view.framing.part, (delegate::DataWindow{0.5, 1, 0, 1}));
  EXPECT_THAT(converted.messages, IsEmpty());
}

TEST(Products, WhatCannotBeWrittenIsTold) {
  auto deep = RawProduct("b.exr");
  deep.type = TfToken("deepRaster");
  const ConvertedProducts converted = ToProducts({RawProduct("a.png"), deep, RawProduct("")});
  EXPECT_THAT(converted.products, IsEmpty());
  EXPECT_THAT(CodesOf(converted),
              ElementsAre("render-product-format", "render-product-type", "render-product-name"));
}

TEST(Products, EachVarIsRenderedOnceAndUnknownOnesAreTold) {
  auto raw = RawProduct("a.exr");
  raw.renderVars.resize(4);
  raw.renderVars[2].sourceName = "color";  // Ci by another name
  raw.renderVars[3].sourceName = "unheardOf";
  const ConvertedProducts converted = ToProducts({raw});
  ASSERT_EQ(converted.products.size(), 1u);
  EXPECT_THAT(converted.products[0].aovs, ElementsAre("color", "depth"));
  EXPECT_THAT(CodesOf(converted), ElementsAre("render-var-unsupported"));
  raw.renderVars.erase(raw.renderVars.begin(), raw.renderVars.begin() + 3);
  const ConvertedProducts empty = ToProducts({raw});
  EXPECT_THAT(empty.products, IsEmpty());
  EXPECT_THAT(CodesOf(empty), ElementsAre("render-var-unsupported", "render-product-empty"));
}

TEST(Products, PolicyAndPixelsComeFromTheProduct) {
  auto raw = RawProduct("a.exr");
  EXPECT_EQ(ToProducts({raw}).products[0].view.policy, delegate::ConformPolicy::Fit);
  raw.aspectRatioConformPolicy = TfToken("cropAperture");
  raw.pixelAspectRatio = 2;
  const ProductView view = ToProducts({raw}).products[0].view;
  EXPECT_EQ(view.policy, delegate::ConformPolicy::Crop);
  EXPECT_EQ(view.framing.pixelAspectRatio, 2);
}

TEST(Products, EachHasItsOwnViewAndEqualViewsShareARender) {
  auto first = RawProduct("a.exr"), same = RawProduct("b.exr"), side = RawProduct("c.exr"), small = RawProduct("d.exr"),
       sharp = RawProduct("e.exr");
  side.cameraPath = SdfPath("/side");
  small.resolution = GfVec2i(40, 30);
  sharp.disableDepthOfField = true;
  const ConvertedProducts converted = ToProducts({first, side, small, same, sharp});
  EXPECT_THAT(converted.messages, IsEmpty());
  const std::vector<Shot> shots = ToShots(converted.products);
  ASSERT_EQ(shots.size(), 4u);
  EXPECT_FALSE(shots[0].view.depthOfField);
  EXPECT_EQ(shots[1].view.framing.width, 40u);
  EXPECT_EQ(shots[2].view.camera, "/side");
  ASSERT_EQ(shots[3].products.size(), 2u);  // the first product's comes last
  EXPECT_EQ(shots[3].products[0].name, "a.exr");
  EXPECT_EQ(shots[3].products[1].name, "b.exr");
}

TEST(Products, ADataWindowKnowsItsPlaceInTheWholePicture) {
  auto raw = RawProduct("a.exr");
  raw.dataWindowNDC = GfRange2f(GfVec2f(0.25, 0.5), GfVec2f(1.25, 1));
  const ConvertedProducts converted = ToProducts({raw});
  const Product& product = converted.products[0];
  EXPECT_EQ(product.view.framing.width, 80u);
  EXPECT_EQ(product.view.framing.height, 30u);
  EXPECT_EQ(product.view.framing.x, 20);
  EXPECT_EQ(product.view.framing.y, 0);
  EXPECT_EQ(product.fullWidth, 80u);
  EXPECT_EQ(product.fullHeight, 60u);
}

TEST(Products, AProductsOwnSettingsAreToldOf) {
  auto raw = RawProduct("a.exr");
  raw.namespacedSettings["wavefront:samples"] = VtValue(4);
  raw.namespacedSettings["ri:samples"] = VtValue(4);
  EXPECT_THAT(CodesOf(ToProducts({raw})), ElementsAre("render-product-setting"));
}

TEST(ExrWriter, ErrorsAreOneSentence) {
  ExrImage image;
  image.width = image.height = 1;
  EXPECT_FALSE(WriteExr("x.exr", image).ok());  // no channels
  image.channels.emplace_back("R", std::vector<float>{1});
  EXPECT_FALSE(WriteExr("/no/such/folder/x.exr", image).ok());
  image.channels.emplace_back("G", std::vector<float>{1, 2});
  EXPECT_FALSE(WriteExr("x.exr", image).ok());
}

}  // namespace
}  // namespace hydra
