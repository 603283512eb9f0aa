// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Types of values in a material, and numbers of them. A colour is a vector here: what differs is colour management, and
// that is the texture request's.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace materialgen {

enum class Type : uint8_t {
  None,
  Bool,
  Int,
  Float,
  Vec2,
  Vec3,
  Vec4,
  Mat3,
  Mat4,
  String,
  Asset,
  Frame,
  Lobe,
  Call,
  Uv,
  Bsdf,
  Vdf,
  Surface,
  Displacement
};

// Number of floats; 0 for what is not a number.
constexpr int Components(Type type) {
  switch (type) {
    case Type::Bool:
    case Type::Int:
    case Type::Float:
      return 1;
    case Type::Vec2:
      return 2;
    case Type::Vec3:
      return 3;
    case Type::Vec4:
      return 4;
    case Type::Mat3:
      return 9;
    case Type::Mat4:
      return 16;
    default:
      return 0;
  }
}
constexpr bool IsVector(Type type) {
  return Components(type) >= 1 && Components(type) <= 4;
}
constexpr Type VectorType(int components) {
  constexpr Type kTypes[] = {Type::None, Type::Float, Type::Vec2, Type::Vec3, Type::Vec4};
  return components >= 1 && components <= 4 ? kTypes[components] : Type::None;
}

// Name of the type in GLSL.
std::string_view GlslName(Type type);
// MaterialX's name ("color3", "BSDF", ...) to a type; None where there is no such type here.
Type TypeFromMaterialX(std::string_view name);

// Value of up to 16 numbers; bool and int are held as floats (whole numbers below 2^24).
using Constant = std::array<float, 16>;

}  // namespace materialgen
