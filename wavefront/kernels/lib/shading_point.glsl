// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The contract between generated material code and the core: what a material may read at a hit.
#ifndef WAVEFRONT_LIB_SHADING_POINT_GLSL
#define WAVEFRONT_LIB_SHADING_POINT_GLSL

struct ShadingPoint {
  vec3 positionWorld;      // relative to the scene's origin
  vec3 positionObject;
  vec3 normalWorld;        // shading normal: interpolated, unit, on the side of the *authored* outside
  vec3 normalGeometric;    // unit, world, authored outside (cross product of the winding, flips included)
  vec3 wo;                 // unit, world, to the viewer
  bool frontFacing;        // wo is on the authored outside
  float footprint;         // width of the ray cone at the hit, world units
  float time;              // frame time of the path
  float exteriorIor;       // index of refraction of what surrounds the body whose boundary this is
  // where the data lie; used by the readers in geometry.glsl
  uint instance;
  uint triangle;           // triangle index in MeshData order
  uint mesh;               // texel of the mesh record
  uint binding;            // first texel of the binding record
  uint parameterBase;      // first texel of the parameter block
  vec2 barycentric;        // (u, v): p = (1-u-v) p0 + u p1 + v p2
};
#endif
