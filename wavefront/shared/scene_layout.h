// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scene records that C++ writes and GLSL reads through texel buffers (RGBA32: one texel = 16 bytes).
// Written once, here; included by C++ (namespace wavefront::layout) and by GLSL.
#ifndef WAVEFRONT_SHARED_SCENE_LAYOUT_H
#define WAVEFRONT_SHARED_SCENE_LAYOUT_H

#ifdef __cplusplus
#include <cstdint>
#define WF_CONST(name, value) constexpr uint32_t name = value;
namespace wavefront::layout {
#else
#define WF_CONST(name, value) const uint name = value;
#endif

// ---- BVH node: 4 children, 8-bit quantised boxes, 64 bytes = 4 texels (uvec4) --------------------------------
// texel 0: origin.xyz (float bits), exponents (biased 8-bit exponent of x | y<<8 | z<<16) | childCount<<24
// texel 1: child references c0..c3:  inner: node index relative to the tree's nodeBase;
//          leaf: kBvhLeafBit | (count-1) << 27 | first item (relative to the tree's itemBase); empty: kBvhEmpty
// texel 2: lo.x of 4 children (one byte each), lo.y, lo.z, hi.x
// texel 3: hi.y, hi.z, (unused), (unused)
WF_CONST(kBvhNodeTexels, 4u)
WF_CONST(kBvhLeafBit, 0x80000000u)
WF_CONST(kBvhEmpty, 0xffffffffu)
WF_CONST(kBvhMaxNodes, 0x3ffffffu)  // in the whole stream: traversal names a node with 26 bits
WF_CONST(kBvhLeafCountShift, 27u)   // leaf holds 1..8 items (3 bits above bit 27, below the leaf bit: 27..30)
WF_CONST(kBvhLeafFirstMask, 0x07ffffffu)

// ---- Triangle record: leaf order, 3 texels -------------------------------------------------------------------
// texel 0: v0.xyz, bits(triangle index in MeshData order); texel 1: v1.xyz, bits(material slot); texel 2: v2.xyz, 0
WF_CONST(kTriangleTexels, 3u)

// ---- Instance record: 9 texels -------------------------------------------------------------------------------
// 0..2: world-to-object rows (3x4, p' = row . (p,1)), scene-origin relative
// 3: nodeBase (node index), triangleBase (triangle index), flags (kInstance*), visibility mask | categories << 8
// 4..6: object-to-world rows
// 7: mesh record index (kind mesh) or light index (light kinds); bindingBase; index for Instance primvars; light item base
//    (first light item of this instance's triangles, triangle order; kNoLight where it does not emit)
// 8: primId, instanceId (int bits), unused, unused
WF_CONST(kInstanceTexels, 9u)
WF_CONST(kInstanceKindMask, 0xfu)       // primitive kind of the instance
WF_CONST(kKindMesh, 0u)
WF_CONST(kKindRect, 1u)                 // analytic light shapes, in light space, unit parameters in texel 4..6's scale:
WF_CONST(kKindDisk, 2u)                 //   rect [-.5,.5]^2 z=0; disk radius 1 z=0; sphere radius 1;
WF_CONST(kKindSphere, 3u)               //   cylinder radius 1 (yz), x in [-.5,.5], no caps.
WF_CONST(kKindCylinder, 4u)             //   The instance transform carries the size.
WF_CONST(kInstanceOpaque, 0x10u)        // every material on it is opaque: any hit blocks a shadow ray
WF_CONST(kInstanceFlip, 0x20u)          // transform mirrors (negative determinant)
WF_CONST(kInstanceDoubleSided, 0x40u)
WF_CONST(kNoLight, 0xffffffffu)

// ---- Mesh record: 2 texels (uvec4) ---------------------------------------------------------------------------
// 0: indexBase (first of 3*triangles uints in the index stream), faceIdBase (in the index stream; kNoStream: identity),
//    triangleCount, flags
// 1: normals descriptor (see primvar descriptor)
WF_CONST(kMeshTexels, 2u)
WF_CONST(kNoStream, 0xffffffffu)

// ---- Primvar descriptor: 1 texel (uvec4) ---------------------------------------------------------------------
// x: valueBase (first float in the primvar stream), y: indexBase in the index stream or kNoStream,
// z: interpolation (Interpolation enum) | components << 8, w: 0.  kNoStream in x: absent.
WF_CONST(kInterpConstant, 0u)
WF_CONST(kInterpUniform, 1u)
WF_CONST(kInterpVertex, 2u)
WF_CONST(kInterpFaceVarying, 3u)
WF_CONST(kInterpInstance, 4u)

// ---- Binding record: 2 + primvarCount + primvar AOV texels -------------------------------------------------
// instance.bindingBase + slot indexes the *binding index* (1 uint in the index stream), which is the first texel here.
// 0: surface bucket, opacity bucket (kNoBucket: opaque), emission bucket (kNoBucket: does not emit), parameter base (texel)
// 1: flags, material id, primvar count, priority of its inside among media (lib/media.glsl)
// 2..: one primvar descriptor per primvar that the kernel reads, in slot order; then one per primvar AOV
WF_CONST(kBindingHeaderTexels, 2u)
WF_CONST(kNoBucket, 0xffffffffu)

// ---- Light record: 10 texels (vec4) --------------------------------------------------------------------------
// 0: type (bits), flags (bits), texture id (bits), light item (bits)
// 1..3: light-to-world rows (3x4, unit shape, size included as in the instance record)
// 4..6: world-to-light rows WITHOUT size (rotation and translation and user scale; for shaping, texture and dome)
// 7: radiance.rgb, world area (distant: solid angle)
// 8: coneAngle cosines etc: cutoff angle (radians), softness start angle (radians), focus, angle (distant: half angle, radians)
// 9: focusTint.rgb, dome distribution base (bits)
WF_CONST(kLightTexels, 10u)
WF_CONST(kLightRect, 0u)
WF_CONST(kLightDisk, 1u)
WF_CONST(kLightSphere, 2u)
WF_CONST(kLightCylinder, 3u)
WF_CONST(kLightDistant, 4u)
WF_CONST(kLightDome, 5u)
WF_CONST(kLightFlagCameraVisible, 1u)
WF_CONST(kLightFlagShadows, 2u)
WF_CONST(kLightFlagMirrored, 4u)      // negative determinant
// The upper bytes of the flags hold groups that nothing reads yet: light linking, shadow linking, light group AOVs.
WF_CONST(kLightLinkShift, 8u)
WF_CONST(kShadowLinkShift, 16u)
WF_CONST(kLightGroupShift, 24u)
WF_CONST(kLightFlagUniform, 8u)       // uniform scale: spheres are sampled by solid angle
WF_CONST(kLightFlagRectangular, 16u)  // x and y stay perpendicular: rect lights are sampled by solid angle

// ---- Light item: 1 texel (uvec4): what the light distribution selects ----------------------------------------
// analytic: x = light index, y = kNoLight, z = probability (float bits), w = 0
// emissive triangle: x = instance index, y = triangle record (absolute, leaf order), z = probability, w = triangle (mesh order)
// With a light tree: z of an item in the tree = its trail.
WF_CONST(kLightItemTexels, 1u)

// ---- Light tree: nodes after the light items, 2 texels (uvec4) each; root first, siblings side by side ---------
// 0: centre.xyz (float bits) and radius of a sphere around the lights
// 1: axis of the normals' cone (octahedral, 2 x snorm16), cosines of its half angle and of the emission's angle around
//    normals (2 x unorm16 of (1 + cos) / 2), power (float bits), reference: first child or kLightNodeLeaf | light item,
//    and kLightNodeTwoSided
WF_CONST(kLightNodeTexels, 2u)
WF_CONST(kLightNodeLeaf, 0x80000000u)
WF_CONST(kLightNodeTwoSided, 0x40000000u)
WF_CONST(kLightNodeMask, 0x3fffffffu)

// ---- Texture record: 1 texel (uvec4) -------------------------------------------------------------------------
// width, height, mip count | format (TexelFormat) << 16, first uint of its own in the page table
// (A set of UDIM tiles: columns, rows, 0, first of columns * rows texture ids in the page table.)
// There stands a uint per level: where in the page table the level's entries start. An entry is where its texels start
// in the pool, counted in texels of the format. A page is 64 x 64 texels, and the column and row that follow them, in rows
// of kPagePitch texels; levels of at most 32 texels share one page, each with an entry of its own.
WF_CONST(kTextureTexels, 1u)
WF_CONST(kPageShift, 6u)
WF_CONST(kPageSide, 64u)
WF_CONST(kPagePitch, 65u)
// The pool is handed out in blocks of this many bytes (a multiple of 16: it is fetched as uvec4): a page of bytes takes
// one, a page of halfs or 16-bit numbers two, a page of floats four.
WF_CONST(kPageBlockBytes, 16912u)
// TexelFormat
WF_CONST(kTexelBytes, 0u)
WF_CONST(kTexelHalfs, 1u)
WF_CONST(kTexelWords, 2u)
WF_CONST(kTexelFloats, 3u)

#ifdef __cplusplus
}  // namespace wavefront::layout
#endif
#undef WF_CONST
#endif
