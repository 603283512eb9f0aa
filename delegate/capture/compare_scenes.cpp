// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/capture/compare_scenes.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <tuple>

#include "delegate/capture/scene_archive.h"

namespace delegate {
namespace {

using namespace wavefront;

#define DELEGATE_CAPTURED(Type, ...)                            \
  [[maybe_unused]] auto MembersOf(const Type& captured) {       \
    const auto& [__VA_ARGS__] = captured;                       \
    return std::tie(__VA_ARGS__);                               \
  }                                                             \
  [[maybe_unused]] const char* MemberNames(const Type&) { return #__VA_ARGS__; }
#include "delegate/capture/captured_fields.def"
#undef DELEGATE_CAPTURED

template <typename T>
struct IsVector : std::false_type {};
template <typename T>
struct IsVector<std::vector<T>> : std::true_type {};

std::string Text(float v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(v));
  return text;
}
std::string Text(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", v);
  return text;
}
std::string Text(const Float3& v) { return "(" + Text(v.x) + ", " + Text(v.y) + ", " + Text(v.z) + ")"; }
std::string Text(const Float4& v) {
  return "(" + Text(v.x) + ", " + Text(v.y) + ", " + Text(v.z) + ", " + Text(v.w) + ")";
}
std::string Text(const UInt3& v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}
std::string Text(const Matrix4d& v) {
  std::string text;
  for (const auto& row : v.m)
    for (const double x : row) text += (text.empty() ? "(" : ", ") + Text(x);
  return text + ")";
}
std::string Text(const std::string& v) { return '"' + v + '"'; }
template <typename T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
std::string Text(T v) { return std::to_string(static_cast<int64_t>(v)); }

template <typename T>
constexpr bool kIsValue = archive::kIsPlain<T> || std::is_same_v<T, bool> || std::is_enum_v<T> || std::is_same_v<T, std::string>;

template <typename T>
bool SameBits(const T& a, const T& b) {
  if constexpr (archive::kIsPlain<T>) return std::memcmp(&a, &b, sizeof a) == 0;  // -0 and NaN are values like others
  else return a == b;
}

class Comparison {
 public:
  std::vector<std::string> lines;

  template <typename T>
  void Values(const std::string& where, const T& a, const T& b) {
    if constexpr (kIsValue<T>) {
      if (!SameBits(a, b)) Say(where, Text(a) + " against " + Text(b));
    } else if constexpr (IsVector<T>::value) {
      Vectors(where, a, b);
    } else if constexpr (std::is_same_v<T, archive::DisplacementPointer>) {
      if (!a != !b) Say(where, "in one only");
      else if (a) Values(where, *a, *b);
    } else if constexpr (std::is_same_v<T, std::shared_ptr<const archive::Words>>) {
      if (!a != !b || (a && *a != *b)) Say(where, "other code");
    } else {
      const auto membersOfA = MembersOf(a), membersOfB = MembersOf(b);
      std::string_view names = MemberNames(a);
      Members(where, membersOfA, membersOfB, names, std::make_index_sequence<std::tuple_size_v<decltype(membersOfA)>>());
    }
  }

  void Say(const std::string& where, const std::string& what) { lines.push_back(where + ": " + what); }

 private:
  template <typename T, std::size_t... i>
  void Members(const std::string& where, const T& a, const T& b, std::string_view names, std::index_sequence<i...>) {
    const auto next = [&] {
      const std::size_t comma = names.find(", ");
      const std::string name(names.substr(0, comma));
      names.remove_prefix(comma == std::string_view::npos ? names.size() : comma + 2);
      return where + "." + name;
    };
    (Values(next(), std::get<i>(a), std::get<i>(b)), ...);
  }

  template <typename T>
  void Vectors(const std::string& where, const std::vector<T>& a, const std::vector<T>& b) {
    if (a.size() != b.size()) return Say(where, std::to_string(a.size()) + " against " + std::to_string(b.size()) + " elements");
    if constexpr (kIsValue<T>) {  // one line for all of them
      std::size_t first = a.size(), count = 0;
      for (std::size_t i = a.size(); i-- > 0;)
        if (!SameBits(a[i], b[i])) first = i, ++count;
      if (count == 0) return;
      Say(where + "[" + std::to_string(first) + "]", Text(a[first]) + " against " + Text(b[first]) +
                                                         (count > 1 ? "; " + std::to_string(count) + " elements differ" : ""));
    } else {
      for (std::size_t i = 0; i < a.size(); ++i) Values(where + "[" + std::to_string(i) + "]", a[i], b[i]);
    }
  }
};

// By path, where ids stand for other prims their paths: what hosts agree on.
struct Named {
  explicit Named(const CapturedScene& scene) {
    for (const auto& [id, texture] : scene.textures) textures[Free(textures, texture.name)] = texture;
    for (const auto& [id, material] : scene.materials) materials[Free(materials, material.path)] = material;
    for (const auto& [id, data] : scene.instances) {
      const std::string path = Free(instances, data.path);
      InstanceData& instance = instances[path] = data;
      MeshData& mesh = meshes[path] = scene.meshes.at(data.mesh);
      std::ranges::sort(mesh.primvars, {}, &PrimvarData::name);
      std::ranges::sort(instance.instancePrimvars, {}, &PrimvarData::name);
      instance.mesh = 0;
      instance.materials.clear();
      for (const MaterialId slot : data.materials)
        worn[path].push_back(slot == kInvalidId ? std::string() : scene.materials.at(slot).path);
    }
    for (const auto& [id, data] : scene.lights) {
      const std::string path = Free(lights, data.path);
      lights[path] = data;
      lights[path].texture = 0;
      const auto texture = scene.textures.find(data.texture);
      lit[path].push_back(texture == scene.textures.end() ? std::string() : texture->second.name);
    }
  }

  template <typename T>
  static std::string Free(const std::map<std::string, T>& taken, std::string name) {
    while (taken.count(name)) name += '\'';
    return name;
  }

  std::map<std::string, TextureData> textures;
  std::map<std::string, MaterialData> materials;
  std::map<std::string, MeshData> meshes;  // by the path of who wears it
  std::map<std::string, InstanceData> instances;
  std::map<std::string, LightData> lights;
  std::map<std::string, std::vector<std::string>> worn, lit;  // materials by slot; the texture
};

template <typename T>
void Maps(Comparison& comparison, const char* kind, const std::map<std::string, T>& a, const std::map<std::string, T>& b) {
  for (const auto& [name, value] : a) {
    const auto other = b.find(name);
    const std::string where = std::string(kind) + " " + name;
    if (other == b.end()) comparison.Say(where, "in the first only");
    else comparison.Values(where, value, other->second);
  }
  for (const auto& [name, value] : b)
    if (a.count(name) == 0) comparison.Say(std::string(kind) + " " + name, "in the second only");
}

}  // namespace

std::vector<std::string> CompareScenes(const CapturedScene& a, const CapturedScene& b) {
  Comparison comparison;
  const Named first(a), second(b);
  comparison.Values("settings", a.settings, b.settings);
  comparison.Values("camera", a.camera, b.camera);
  Maps(comparison, "texture", first.textures, second.textures);
  Maps(comparison, "material", first.materials, second.materials);
  Maps(comparison, "mesh", first.meshes, second.meshes);
  Maps(comparison, "instances", first.instances, second.instances);
  Maps(comparison, "materials of", first.worn, second.worn);
  Maps(comparison, "light", first.lights, second.lights);
  Maps(comparison, "texture of", first.lit, second.lit);
  return std::move(comparison.lines);
}

}  // namespace delegate
