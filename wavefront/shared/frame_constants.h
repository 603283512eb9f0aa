// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What is constant over a submit: camera, settings, counts. Written once for C++ and GLSL, scalar block layout.
#ifndef WAVEFRONT_SHARED_FRAME_CONSTANTS_H
#define WAVEFRONT_SHARED_FRAME_CONSTANTS_H

#ifdef __cplusplus
#include <cstdint>
namespace wavefront::layout {
struct vec4 { float x, y, z, w; };
using uint = uint32_t;
#endif

struct FrameConstants {
  vec4 cameraToWorld0, cameraToWorld1, cameraToWorld2;  // rows of the 3x4, relative to the scene's origin
  vec4 window;              // left, right, bottom, top on the plane z = -1 (orthographic: scene units)
  float nearClip, farClip;  // along -Z
  float lensRadius, focusDistance;
  float exposureScale;
  float pixelSpread;        // width of a pixel's cone per unit of distance (orthographic: constant width, spread 0)
  float pixelWidth;         // cone width at the camera
  uint orthographic;

  uint width, height;       // of the whole image
  uint bandY, bandHeight;   // rows of the image that the film buffers hold now
  uint rangeFirstSample;    // the sample that writes FirstSample AOVs
  uint seed;
  uint maxBounces, rouletteBounce;
  uint maxTransparency;
  uint flags;               // kFrame*
  float radianceClamp;      // per sample and channel
  float shutterOpen, shutterClose;
  float frameNumber, timeSeconds;  // what pattern nodes call frame and time
  vec4 sceneOrigin;         // what positions in kernels are relative to; w unused

  uint poolSize;
  uint bucketCount;
  uint lightItemCount;      // entries of the light distribution
  uint lightTree;           // first texel of the light tree among the light items; 0: items are picked by power alone
  uint infiniteLightCount;  // lights 0 .. infiniteLightCount-1 are distant and dome lights
  uint lightCount;
  uint hasGeometry;         // 0: no instance at all
  float sceneRadius;
  uint tlasRoot;            // node index of the tree over instances

  // Film channels: first 64-bit channel of each Mean AOV, first 32-bit channel of each FirstSample AOV; kNoChannel: not asked for.
  uint sumChannels, firstChannels;  // per pixel
  uint colorChannel, countChannel, albedoChannel, normalChannel;
  uint depthChannel, cameraDepthChannel, primIdChannel, instanceIdChannel, elementIdChannel;
  uint neyeChannel, costChannel;
  uint primvarChannel, primvarAovCount;  // slot i: 3 words from primvarChannel + 3 i

  // Camera space; camera rays see points with xyz . p + w >= 0 of the first clipPlaneCount.
  vec4 clipPlane0, clipPlane1, clipPlane2, clipPlane3, clipPlane4, clipPlane5;
  uint clipPlaneCount;
};

#ifdef __cplusplus
constexpr uint kNoChannel = 0xffffffffu;
constexpr uint kFrameDomeVisible = 1u;
constexpr uint kFrameShadows = 2u;
// Film sums are 64-bit fixed point: value * 2^26; a sample's channel is clamped to +-2^20 (1,048,576), so that
// 65,536 samples of the largest value still fit.
constexpr double kFilmScale = 67108864.0;
constexpr float kFilmClamp = 1048576.0f;
}  // namespace wavefront::layout
#else
const uint kNoChannel = 0xffffffffu;
const uint kFrameDomeVisible = 1u;
const uint kFrameShadows = 2u;
const float kFilmScale = 67108864.0;
const float kFilmClamp = 1048576.0;
#endif
#endif
