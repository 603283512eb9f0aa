// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// How values become bytes and bytes become values: one walk over the fields for writing, for reading, and for the
// signature that tells formats apart. Little endian, no padding; a vector is its length and its elements.
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "delegate/capture/captured_scene.h"

namespace delegate::archive {

static_assert(std::endian::native == std::endian::little, "scene files are little endian");

#define DELEGATE_CAPTURED(Type, ...)                                 \
  template <typename Archive, typename Value>                        \
    requires std::is_same_v<std::remove_const_t<Value>, Type>        \
  void Fields(Archive& archive, Value& captured) {                   \
    auto& [__VA_ARGS__] = captured;                                  \
    archive(__VA_ARGS__);                                            \
  }
#include "delegate/capture/captured_fields.def"
#undef DELEGATE_CAPTURED

// Last value of each enumeration: bytes beyond it are damage.
template <typename T> constexpr uint32_t kLastOf = [] { static_assert(sizeof(T) == 0, "name the last value here"); return 0u; }();
template <> inline constexpr uint32_t kLastOf<wavefront::Interpolation> = uint32_t(wavefront::Interpolation::Instance);
template <> inline constexpr uint32_t kLastOf<wavefront::LightType> = uint32_t(wavefront::LightType::Dome);
template <> inline constexpr uint32_t kLastOf<wavefront::TexelFormat> = uint32_t(wavefront::TexelFormat::Rgba32Float);
template <> inline constexpr uint32_t kLastOf<wavefront::ExecutionMode> = uint32_t(wavefront::ExecutionMode::Megakernel);
template <> inline constexpr uint32_t kLastOf<wavefront::LightSampling> = uint32_t(wavefront::LightSampling::Tree);
template <> inline constexpr uint32_t kLastOf<wavefront::Aov> = uint32_t(wavefront::Aov::kCount) - 1;

// Compilers write a value that has no name as a cast, "(Enum)7": a value that was added and is not named above is found.
template <auto v>
constexpr bool IsNamed() {
  const std::string_view text = __PRETTY_FUNCTION__;
  return text[text.find("v = ") + 4] != '(';
}
template <typename T>
constexpr bool kLastIsLast = std::is_same_v<T, wavefront::Aov> ||
                             (IsNamed<T(kLastOf<T>)>() && !IsNamed<T(kLastOf<T> + 1)>());

// Values whose memory is their file form. Floats may hold any bits; a bool may not.
template <typename T>
constexpr bool kIsPlain = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_same_v<T, wavefront::Float3> ||
                          std::is_same_v<T, wavefront::Float4> || std::is_same_v<T, wavefront::UInt3> ||
                          std::is_same_v<T, wavefront::Matrix4d>;
static_assert(sizeof(wavefront::Float3) == 12 && sizeof(wavefront::UInt3) == 12 && sizeof(wavefront::Matrix4d) == 128);

using DisplacementPointer = std::shared_ptr<const wavefront::DisplacementData>;
using Words = std::vector<uint32_t>;

class Writer {
 public:
  template <typename... T>
  void operator()(const T&... values) { (Value(values), ...); }
  // What meshes share is written once, as an index into this; 0xffffffff: none.
  std::map<DisplacementPointer, uint32_t> displacements;
  std::vector<std::byte> bytes;

 private:
  void Raw(const void* data, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), from, from + size);
  }
  void Length(uint64_t n) { Raw(&n, sizeof n); }

  template <typename T>
  void Value(const T& value) {
    if constexpr (kIsPlain<T>) {
      Raw(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, bool>) {
      const uint8_t byte = value;
      Raw(&byte, 1);
    } else if constexpr (std::is_enum_v<T>) {
      const auto number = static_cast<uint32_t>(value);
      Raw(&number, sizeof number);
    } else {
      Fields(*this, value);
    }
  }
  void Value(const std::string& text) {
    Length(text.size());
    Raw(text.data(), text.size());
  }
  void Value(const std::shared_ptr<const Words>& words) {
    Length(words ? words->size() : 0);
    if (words) Raw(words->data(), words->size() * sizeof(uint32_t));
  }
  void Value(const DisplacementPointer& pointer) {
    Value(pointer ? displacements.at(pointer) : wavefront::kInvalidId);
  }
  template <typename T>
  void Value(const std::vector<T>& values) {
    Length(values.size());
    if constexpr (kIsPlain<T>) Raw(values.data(), values.size() * sizeof(T));
    else for (const T& value : values) Value(value);
  }
  template <typename T, std::size_t n>
  void Value(const std::array<T, n>& values) { for (const T& value : values) Value(value); }
  template <typename K, typename T>
  void Value(const std::map<K, T>& values) {
    Length(values.size());
    for (const auto& [key, value] : values) {
      Value(key);
      Value(value);
    }
  }
};

// The first thing that does not fit ends the reading: all that follows is left as it was. Nothing is allocated that the
// bytes at hand could not fill.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}
  template <typename... T>
  void operator()(T&... values) { (Value(values), ...); }
  std::vector<DisplacementPointer> displacements;
  const std::string& trouble() const { return trouble_; }
  std::size_t left() const { return left_.size(); }

 private:
  bool Fail(const char* what) {
    if (trouble_.empty()) trouble_ = what;
    return false;
  }
  bool Raw(void* data, std::size_t size) {
    if (!trouble_.empty() || size > left_.size()) return Fail("it ends too early");
    if (size != 0) std::memcpy(data, left_.data(), size);
    left_ = left_.subspan(size);
    return true;
  }
  uint64_t Length(std::size_t least) {
    uint64_t n = 0;
    if (!Raw(&n, sizeof n)) return 0;
    if (n > left_.size() / least) return Fail("a length in it is more than there is"), 0;
    return n;
  }

  template <typename T>
  void Value(T& value) {
    if constexpr (kIsPlain<T>) {
      Raw(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, bool>) {
      uint8_t byte = 0;
      if (Raw(&byte, 1) && byte > 1) Fail("a switch in it is neither on nor off");
      value = byte == 1;
    } else if constexpr (std::is_enum_v<T>) {
      static_assert(kLastIsLast<T>, "kLastOf names another value than the last");
      uint32_t number = 0;
      if (Raw(&number, sizeof number) && number > kLastOf<T>) Fail("it holds a choice that is none");
      if (trouble_.empty()) value = static_cast<T>(number);
    } else {
      Fields(*this, value);
    }
  }
  void Value(std::string& text) {
    text.resize(Length(1));
    Raw(text.data(), text.size());
  }
  void Value(std::shared_ptr<const Words>& words) {
    auto read = std::make_shared<Words>(Length(sizeof(uint32_t)));
    Raw(read->data(), read->size() * sizeof(uint32_t));
    words = std::move(read);
  }
  void Value(DisplacementPointer& pointer) {
    uint32_t index = wavefront::kInvalidId;
    Value(index);
    if (index == wavefront::kInvalidId) return;
    if (index < displacements.size()) pointer = displacements[index];
    else Fail("it names a displacement that is not there");
  }
  template <typename T>
  void Value(std::vector<T>& values) {
    if constexpr (kIsPlain<T>) {
      values.resize(Length(sizeof(T)));
      Raw(values.data(), values.size() * sizeof(T));
    } else {
      // One by one: elements may be larger than the bytes that a damaged length would have to be paid with.
      for (uint64_t n = Length(1); n > 0 && trouble_.empty(); --n) Value(values.emplace_back());
    }
  }
  template <typename T, std::size_t n>
  void Value(std::array<T, n>& values) { for (T& value : values) Value(value); }
  template <typename K, typename T>
  void Value(std::map<K, T>& values) {
    for (uint64_t n = Length(1); n > 0 && trouble_.empty(); --n) {
      K key{};
      Value(key);
      Value(values[key]);
    }
  }

  std::span<const std::byte> left_;
  std::string trouble_;
};

// The types of the fields, to the last number, in words.
class Signature {
 public:
  template <typename... T>
  void operator()(T&...) { (Describe<T>(), ...); }
  std::string text;

  template <typename T>
  void Describe() {
    if constexpr (std::is_enum_v<T>) text += 'e' + std::to_string(kLastOf<T>);
    else if constexpr (kIsPlain<T> || std::is_same_v<T, bool>)
      text += (std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u') + std::to_string(sizeof(T));
    else Nested(static_cast<T*>(nullptr));
  }

 private:
  void Nested(std::string*) { text += 's'; }
  void Nested(std::shared_ptr<const Words>*) { text += "[u4]"; }
  void Nested(DisplacementPointer*) { text += 'd'; }
  template <typename T> void Nested(std::vector<T>*) { text += '['; Describe<T>(); text += ']'; }
  template <typename T, std::size_t n> void Nested(std::array<T, n>*) { text += std::to_string(n) + '['; Describe<T>(); text += ']'; }
  template <typename T> void Nested(T*) {
    T value{};
    text += '{';
    Fields(*this, value);
    text += '}';
  }
};

}  // namespace delegate::archive
