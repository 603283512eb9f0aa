// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// UsdGeom's implicit shapes as triangle meshes with normals and texture coordinates.
#pragma once

#include <optional>
#include <string>

#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"

namespace delegate {

enum class ImplicitShape { Sphere, Cube, Cone, Cylinder, Capsule, Plane };

// UsdGeom's attributes, defaults included. Each shape reads only its own; lengths in object space.
struct ImplicitInput {
  std::string path;                // named in diagnostics
  ImplicitShape shape = ImplicitShape::Sphere;
  double size = 2;                 // Cube: edge length
  double radius = 1;               // Sphere 1, Cone 1, Cylinder 1, Capsule 0.5: the host passes what is authored
  double radiusTop = -1;           // Cylinder_1, Capsule_1; negative: radius
  double radiusBottom = -1;        // Cylinder_1, Capsule_1; negative: radius
  double height = 2;               // Cone 2, Cylinder 2; Capsule 1: the spine without the two half spheres
  double width = 2, length = 2;    // Plane; axis Z: along x and y, Y: along x and z, X: along z and y
  std::string axis = "Z";          // X, Y, Z: Cone, Cylinder, Capsule, Plane
  bool doubleSided = false;        // Plane: UsdGeom's fallback is true
};

// Centred at the origin and facing outward (Plane: along +axis). Primvars: "normals" (unit) and "st" (u around, v
// along the axis, each face of the cube and each cap the whole square). Round shapes have 192 segments around: a
// silhouette of 1080 pixels is off by less than a tenth of a pixel. Pure; any thread. faceIds number the faces of the
// cube (0..5: -X +X -Y +Y -Z +Z) or the parts from bottom to top (cap, side, cap); other shapes have face 0 only.
// Nothing is returned for sizes that are zero, negative, or not finite; the sink is told.
std::optional<wavefront::MeshData> BuildImplicit(const ImplicitInput& input, const wavefront::DiagnosticSink& sink);

}  // namespace delegate
