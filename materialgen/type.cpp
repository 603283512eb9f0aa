// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/type.h"

#include <iterator>

namespace materialgen {

std::string_view GlslName(Type type) {
  switch (type) {
    case Type::Bool:
      return "bool";
    case Type::Int:
      return "int";
    case Type::Float:
      return "float";
    case Type::Vec2:
      return "vec2";
    case Type::Vec3:
      return "vec3";
    case Type::Vec4:
      return "vec4";
    case Type::Mat3:
      return "mat3";
    case Type::Mat4:
      return "mat4";
    case Type::Frame:
      return "Frame";
    case Type::Uv:
      return "PatternUv";
    default:
      return "void";
  }
}

Type TypeFromMaterialX(std::string_view name) {
  struct Row {
    std::string_view name;
    Type type;
  };
  // EDFs are plain colours here: emitted radiance towards the viewer.
  static constexpr Row kRows[] = {
      {"boolean", Type::Bool},  {"integer", Type::Int},   {"float", Type::Float},   {"vector2", Type::Vec2},
      {"vector3", Type::Vec3},  {"vector4", Type::Vec4},  {"color3", Type::Vec3},   {"color4", Type::Vec4},
      {"matrix33", Type::Mat3}, {"matrix44", Type::Mat4}, {"string", Type::String}, {"filename", Type::Asset},
      {"BSDF", Type::Bsdf},     {"EDF", Type::Vec3},      {"VDF", Type::Vdf},       {"surfaceshader", Type::Surface},
      {"displacementshader", Type::Displacement},
  };
  for (const Row& row : kRows) {
    if (row.name == name) return row.type;
  }
  return Type::None;
}

}  // namespace materialgen
