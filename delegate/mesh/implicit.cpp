// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/mesh/implicit.h"

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

#include "delegate/mesh/mesh_math.h"

namespace delegate {
namespace {

using wavefront::Interpolation;
using wavefront::MeshData;

constexpr uint32_t kSegments = 192;           // around the axis
constexpr uint32_t kRings = kSegments / 2;    // from pole to pole of a sphere

// A circle around z: radius, height, the outward normal as (radial, z), texture v.
struct Ring {
  double r, z, nr, nz, v;
};

class ShapeBuilder {
 public:
  uint32_t AddVertex(const Vec3& position, const Vec3& normal, double s, double t) {
    positions_.push_back(position);
    normals_.push_back(normal);
    st_.insert(st_.end(), {static_cast<float>(s), static_cast<float>(t)});
    return static_cast<uint32_t>(positions_.size() - 1);
  }

  void AddTriangle(uint32_t a, uint32_t b, uint32_t c, uint32_t face) {
    mesh_.triangles.push_back({a, b, c});
    mesh_.faceIds.push_back(face);
  }

  // a b c d counter-clockwise seen from outside.
  void AddQuad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& normal, uint32_t face) {
    const uint32_t i = AddVertex(a, normal, 0, 0);
    AddVertex(b, normal, 1, 0);
    AddVertex(c, normal, 1, 1);
    AddVertex(d, normal, 0, 1);
    AddTriangle(i, i + 1, i + 2, face);
    AddTriangle(i, i + 2, i + 3, face);
  }

  // The surface between rings of rising z. Rings have a seam, where s goes from 1 to 0; a ring of radius 0 (pole, tip)
  // has one vertex per segment, with the segment's middle normal.
  void AddRevolution(const std::vector<Ring>& rings, uint32_t face) {
    const uint32_t first = static_cast<uint32_t>(positions_.size());
    const uint32_t stride = kSegments + 1;
    for (const Ring& ring : rings) {
      for (uint32_t i = 0; i <= kSegments; ++i) {
        const double s = (i + (ring.r == 0 ? 0.5 : 0.0)) / kSegments;
        // The seam's two ends are one place to the bit.
        const double angle = 2 * std::numbers::pi * (i == kSegments && ring.r > 0 ? 0 : s);
        const Vec3 radial(std::cos(angle), std::sin(angle), 0);
        AddVertex(radial * ring.r + Vec3(0, 0, ring.z), radial * ring.nr + Vec3(0, 0, ring.nz), s, ring.v);
      }
    }
    for (uint32_t j = 0; j + 1 < rings.size(); ++j) {
      for (uint32_t i = 0; i < kSegments; ++i) {
        const uint32_t a = first + j * stride + i, b = a + 1, c = b + stride, d = a + stride;
        if (rings[j].r == 0) AddTriangle(a, c, d, face);
        else if (rings[j + 1].r == 0) AddTriangle(a, b, d, face);
        else {
          AddTriangle(a, b, c, face);
          AddTriangle(a, c, d, face);
        }
      }
    }
  }

  // A flat disk at height z; up: facing +z.
  void AddDisk(double radius, double z, bool up, uint32_t face) {
    if (radius <= 0) return;
    const Vec3 normal(0, 0, up ? 1 : -1);
    const uint32_t centre = AddVertex({0, 0, z}, normal, 0.5, 0.5);
    for (uint32_t i = 0; i < kSegments; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSegments, c = std::cos(angle), s = std::sin(angle);
      AddVertex({radius * c, radius * s, z}, normal, 0.5 + 0.5 * c, 0.5 + (up ? 0.5 : -0.5) * s);
    }
    for (uint32_t i = 0; i < kSegments; ++i) {
      const uint32_t a = centre + 1 + i, b = centre + 1 + (i + 1) % kSegments;
      AddTriangle(centre, up ? a : b, up ? b : a, face);
    }
  }

  // The truncated cone between two radii. Its normal is perpendicular to the slope everywhere, at a tip too.
  void AddSide(double bottom, double top, double height, double vBottom, double vTop, uint32_t face) {
    const double length = std::hypot(height, bottom - top), nr = height / length, nz = (bottom - top) / length;
    AddRevolution({{bottom, -height / 2, nr, nz, vBottom}, {top, height / 2, nr, nz, vTop}}, face);
  }

  // Part of a sphere around (0, 0, z), latitudes in quarter turns from -1 (south pole) to 1; v likewise from vFrom to vTo.
  void AddBowl(double radius, double z, int from, int to, double vFrom, double vTo, uint32_t face) {
    if (radius <= 0) return;
    std::vector<Ring> rings;
    const int count = static_cast<int>(kRings) / 2 * (to - from);
    for (int j = 0; j <= count; ++j) {
      const double f = static_cast<double>(j) / count, latitude = std::numbers::pi / 2 * (from + f * (to - from));
      const bool isPole = (from == -1 && j == 0) || (to == 1 && j == count);
      const double c = isPole ? 0 : std::cos(latitude), s = std::sin(latitude);
      rings.push_back({radius * c, z + radius * s, c, s, vFrom + f * (vTo - vFrom)});
    }
    AddRevolution(rings, face);
  }

  // z becomes `axis`; x, y, z are rotated cyclically, so that outside stays outside.
  MeshData Finish(char axis, bool doubleSided) {
    const auto turn = [&](const Vec3& p) {
      if (axis == 'X') return Vec3(p.z, p.x, p.y);
      if (axis == 'Y') return Vec3(p.y, p.z, p.x);
      return p;
    };
    std::vector<float> normals;
    normals.reserve(3 * normals_.size());
    for (const Vec3& n : normals_) {
      const wavefront::Float3 f = ToFloat3(turn(n));
      normals.insert(normals.end(), {f.x, f.y, f.z});
    }
    for (const Vec3& p : positions_) mesh_.positions.push_back(ToFloat3(turn(p)));
    mesh_.primvars.push_back({"normals", Interpolation::Vertex, 3, std::move(normals), {}});
    mesh_.primvars.push_back({"st", Interpolation::Vertex, 2, std::move(st_), {}});
    mesh_.doubleSided = doubleSided;
    return std::move(mesh_);
  }

 private:
  MeshData mesh_;
  std::vector<Vec3> positions_, normals_;
  std::vector<float> st_;
};

void AddCube(double size, ShapeBuilder& builder) {
  const double h = size / 2;
  // For each axis the two others, so that cross(u, v) = axis.
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (uint32_t i = 0; i < 3; ++i) {
    const Vec3 &n = axes[i], &u = axes[(i + 1) % 3], &v = axes[(i + 2) % 3];
    const auto corner = [&](double sn, double su, double sv) { return n * (sn * h) + u * (su * h) + v * (sv * h); };
    builder.AddQuad(corner(-1, 1, -1), corner(-1, -1, -1), corner(-1, -1, 1), corner(-1, 1, 1), -n, 2 * i);
    builder.AddQuad(corner(1, -1, -1), corner(1, 1, -1), corner(1, 1, 1), corner(1, -1, 1), n, 2 * i + 1);
  }
}

// st as seen from the front with y (or, for axis Y, -z) up.
void AddPlane(double width, double length, char axis, ShapeBuilder& builder) {
  Vec3 right(1, 0, 0), up(0, 1, 0);
  if (axis == 'X') right = {0, 0, -1};
  if (axis == 'Y') up = {0, 0, -1};
  right = right * (width / 2);
  up = up * (length / 2);
  builder.AddQuad(-right - up, right - up, right + up, up - right, Normalized(Cross(right, up)), 0);
}

struct Radii {
  double bottom, top;
};

Radii ReadRadii(const ImplicitInput& input) {
  return {input.radiusBottom >= 0 ? input.radiusBottom : input.radius, input.radiusTop >= 0 ? input.radiusTop : input.radius};
}

bool ArePositive(std::initializer_list<double> lengths) {
  for (const double length : lengths)
    if (!(length > 0 && length <= 1e18)) return false;  // NaN fails
  return true;
}

// The lengths that the shape reads, all of them usable.
bool HasUsableSizes(const ImplicitInput& input) {
  const auto [bottom, top] = ReadRadii(input);
  const bool radiiFit = ArePositive({bottom + top}) && bottom >= 0 && top >= 0;
  switch (input.shape) {
    case ImplicitShape::Sphere: return ArePositive({input.radius});
    case ImplicitShape::Cube: return ArePositive({input.size});
    case ImplicitShape::Cone: return ArePositive({input.radius, input.height});
    case ImplicitShape::Cylinder: return radiiFit && ArePositive({input.height});
    case ImplicitShape::Capsule: return radiiFit && (input.height == 0 || ArePositive({input.height}));
    case ImplicitShape::Plane: return ArePositive({input.width, input.length});
  }
  return false;
}

void AddCapsule(const ImplicitInput& input, ShapeBuilder& builder) {
  const auto [bottom, top] = ReadRadii(input);
  // v by the length of the profile, so that a texture is not squeezed at the caps.
  const double quarter = std::numbers::pi / 2, side = std::hypot(input.height, bottom - top);
  const double total = quarter * (bottom + top) + side;
  const double v1 = quarter * bottom / total, v2 = (quarter * bottom + side) / total;
  builder.AddBowl(bottom, -input.height / 2, -1, 0, 0, v1, 0);
  if (side > 0) builder.AddSide(bottom, top, input.height, v1, v2, 1);
  builder.AddBowl(top, input.height / 2, 0, 1, v2, 1, 2);
}

}  // namespace

std::optional<MeshData> BuildImplicit(const ImplicitInput& input, const wavefront::DiagnosticSink& sink) {
  const auto warn = [&](const char* code, const std::string& message) {
    if (sink) sink({wavefront::Severity::Warning, code, input.path, message});
  };
  if (!HasUsableSizes(input)) {
    warn("implicit-bad-size", "The shape has a size that is zero, negative, not finite or beyond 1e18; nothing is drawn.");
    return std::nullopt;
  }
  const bool hasAxis = input.shape != ImplicitShape::Sphere && input.shape != ImplicitShape::Cube;
  char axis = 'Z';
  if (hasAxis) {
    if (input.axis == "X" || input.axis == "Y" || input.axis == "Z") axis = input.axis[0];
    else warn("implicit-bad-axis", "The axis \"" + input.axis + "\" is not X, Y or Z; Z is taken.");
  }
  ShapeBuilder builder;
  switch (input.shape) {
    case ImplicitShape::Sphere: builder.AddBowl(input.radius, 0, -1, 1, 0, 1, 0); break;
    case ImplicitShape::Cube: AddCube(input.size, builder); break;
    case ImplicitShape::Plane:
      AddPlane(input.width, input.length, axis, builder);
      axis = 'Z';  // already placed
      break;
    case ImplicitShape::Capsule: AddCapsule(input, builder); break;
    case ImplicitShape::Cone:
      builder.AddDisk(input.radius, -input.height / 2, false, 0);
      builder.AddSide(input.radius, 0, input.height, 0, 1, 1);
      break;
    case ImplicitShape::Cylinder: {
      const auto [bottom, top] = ReadRadii(input);
      builder.AddDisk(bottom, -input.height / 2, false, 0);
      builder.AddSide(bottom, top, input.height, 0, 1, 1);
      builder.AddDisk(top, input.height / 2, true, 2);
      break;
    }
  }
  return builder.Finish(axis, input.doubleSided);
}

}  // namespace delegate
