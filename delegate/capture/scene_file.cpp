// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/capture/scene_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <string_view>

#include "delegate/capture/scene_archive.h"

namespace delegate {
namespace {

constexpr char kMagic[8] = {'H', 'D', 'W', 'S', 'C', 'E', 'N', 'E'};
constexpr std::size_t kHeaderBytes = 40, kChunkHeaderBytes = 24, kNameBytes = 8;

template <typename T>
void Append(std::vector<std::byte>& bytes, const T& value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof value);
}
template <typename T>
T At(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// The chunks, in order: name, and what of a scene stands in it. Displacements come before the meshes that share them.
template <typename Scene, typename List, typename Visit>
void ForEachChunk(Scene& scene, List& displacements, Visit&& visit) {
  visit("INFO", [&](auto& a) { a(scene.info); });
  visit("KERNELS", [&](auto& a) { a(scene.kernels); });
  visit("TEXTURES", [&](auto& a) { a(scene.textures, scene.tiles); });
  visit("MATERIAL", [&](auto& a) { a(scene.materials, scene.defaultMaterial); });
  visit("DISPLACE", [&](auto& a) { a(displacements); });
  visit("MESHES", [&](auto& a) { a(scene.meshes); });
  visit("INSTANCE", [&](auto& a) { a(scene.instances); });
  visit("LIGHTS", [&](auto& a) { a(scene.lights); });
  visit("CAMERA", [&](auto& a) { a(scene.camera); });
  visit("SETTINGS", [&](auto& a) { a(scene.settings); });
}

uint64_t FieldSignature() {
  static const uint64_t signature = [] {
    archive::Signature s;
#define DELEGATE_CAPTURED(Struct, ...) \
  s.text += #Struct ":" #__VA_ARGS__;  \
  s.Describe<Struct>();
#include "delegate/capture/captured_fields.def"
#undef DELEGATE_CAPTURED
    return Checksum(std::as_bytes(std::span(s.text)));
  }();
  return signature;
}

uint64_t ChunkChecksum(std::span<const std::byte> header, std::span<const std::byte> bytes) {
  return Checksum(bytes, Checksum(header.first(kNameBytes + 8)));
}

// Bytes and how far they are read.
struct File {
  std::span<const std::byte> bytes;
  std::string name;
  wavefront::Error Bad(const std::string& what) const { return {"The scene file " + name + " cannot be read: " + what}; }
};

wavefront::Status CheckHeader(const File& file) {
  const auto& bytes = file.bytes;
  if (bytes.size() < sizeof kMagic || std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0)
    return file.Bad("it is no scene that `hdwavefront capture` wrote.");
  if (bytes.size() < kHeaderBytes) return file.Bad("it is cut off in its header.");
  if (At<uint64_t>(bytes, 32) != Checksum(bytes.first(32))) return file.Bad("its header is damaged.");
  const auto version = At<uint32_t>(bytes, 8);
  if (version != kSceneFileVersion)
    return file.Bad("it is of format " + std::to_string(version) + ", and this program reads " + std::to_string(kSceneFileVersion) + ".");
  const auto length = At<uint64_t>(bytes, 16);
  if (length != bytes.size())
    return file.Bad("it is " + std::to_string(bytes.size()) + " bytes long and should be " + std::to_string(length) +
                    (bytes.size() < length ? ": it is cut off." : "."));
  if (At<uint64_t>(bytes, 24) != FieldSignature())
    return file.Bad("another version of hdWavefront wrote it, which keeps other fields. Capture the stage again.");
  return {};
}

// The bytes of the chunk at `offset`, which moves behind it.
wavefront::Result<std::span<const std::byte>> ReadChunk(const File& file, const std::string& name, std::size_t& offset) {
  const auto rest = file.bytes.subspan(offset);
  const auto bad = [&](const char* what) { return file.Bad("its chunk " + name + " " + what); };
  if (rest.size() < kChunkHeaderBytes) return bad("is missing: the file is cut off.");
  char wanted[kNameBytes] = {};
  std::memcpy(wanted, name.data(), name.size());
  const auto length = At<uint64_t>(rest, kNameBytes);
  if (length > rest.size() - kChunkHeaderBytes) return bad("is longer than the file: it is cut off or damaged.");
  const auto payload = rest.subspan(kChunkHeaderBytes, length);
  if (At<uint64_t>(rest, kNameBytes + 8) != ChunkChecksum(rest, payload)) return bad("is damaged: its checksum does not fit.");
  if (std::memcmp(rest.data(), wanted, kNameBytes) != 0) return bad("is not where it should be.");
  offset += kChunkHeaderBytes + length;
  return payload;
}

std::string Reason() { return std::strerror(errno); }

}  // namespace

uint64_t Checksum(std::span<const std::byte> bytes, uint64_t start) {
  // FNV-1a over words: each step is a bijection of what came before, so one changed word cannot cancel out.
  uint64_t hash = start;
  const auto add = [&](uint64_t word) { hash = (hash ^ word) * 0x100000001b3ull; hash ^= hash >> 29; };
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) add(At<uint64_t>(bytes, i));
  uint64_t last = 0;
  if (i < bytes.size()) std::memcpy(&last, bytes.data() + i, bytes.size() - i);
  add(last);
  add(bytes.size());
  return hash;
}

std::vector<std::byte> EncodeScene(const CapturedScene& scene) {
  archive::Writer writer;
  std::vector<wavefront::DisplacementData> displacements;
  for (const auto& [id, mesh] : scene.meshes)
    for (const archive::DisplacementPointer& d : mesh.displacements)
      if (d && writer.displacements.try_emplace(d, uint32_t(displacements.size())).second) displacements.push_back(*d);

  std::vector<std::byte> file(kHeaderBytes);
  uint32_t chunks = 0;
  ForEachChunk(scene, displacements, [&](std::string_view name, const auto& fields) {
    writer.bytes.clear();
    fields(writer);
    const std::size_t begin = file.size();
    char padded[kNameBytes] = {};
    std::memcpy(padded, name.data(), name.size());
    Append(file, padded);
    Append(file, uint64_t(writer.bytes.size()));
    Append(file, ChunkChecksum(std::span(file).subspan(begin), writer.bytes));
    file.insert(file.end(), writer.bytes.begin(), writer.bytes.end());
    ++chunks;
  });
  std::vector<std::byte> header;
  Append(header, kMagic);
  Append(header, kSceneFileVersion);
  Append(header, chunks);
  Append(header, uint64_t(file.size()));
  Append(header, FieldSignature());
  Append(header, Checksum(header));
  std::copy(header.begin(), header.end(), file.begin());
  return file;
}

wavefront::Result<CapturedScene> DecodeScene(std::span<const std::byte> bytes, const std::string& name) {
  const File file{bytes, name};
  if (wavefront::Status status = CheckHeader(file); !status) return status.error();
  CapturedScene scene;
  std::vector<wavefront::DisplacementData> displacements;
  std::vector<archive::DisplacementPointer> shared;
  std::size_t offset = kHeaderBytes;
  uint32_t chunks = 0;
  wavefront::Status status;
  ForEachChunk(scene, displacements, [&](const std::string& chunk, const auto& fields) {
    if (!status) return;
    ++chunks;
    const auto payload = ReadChunk(file, chunk, offset);
    if (!payload) { status = payload.error(); return; }
    archive::Reader reader(payload.value());
    for (; shared.size() < displacements.size();)
      shared.push_back(std::make_shared<const wavefront::DisplacementData>(displacements[shared.size()]));
    reader.displacements = shared;
    fields(reader);
    if (!reader.trouble().empty()) status = file.Bad("its chunk " + chunk + " makes no sense: " + reader.trouble() + ".");
    else if (reader.left() != 0) status = file.Bad("its chunk " + chunk + " is longer than what it holds.");
  });
  if (!status) return status.error();
  if (offset != bytes.size() || chunks != At<uint32_t>(bytes, 12)) return file.Bad("more follows its last chunk.");
  if (status = CheckScene(scene); !status) return file.Bad("its chunk " + status.error().message);
  return scene;
}

wavefront::Status WriteSceneFile(const CapturedScene& scene, const std::string& path) {
  const std::vector<std::byte> bytes = EncodeScene(scene);
  const std::string beside = path + "." + std::to_string(getpid()) + ".part";
  std::FILE* file = std::fopen(beside.c_str(), "wb");
  const auto fail = [&] {
    const std::string reason = Reason();
    std::remove(beside.c_str());
    return wavefront::Error{"The scene file " + path + " cannot be written: " + reason + "."};
  };
  if (!file) return fail();
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() && std::fflush(file) == 0;
  if (!written) {
    const auto error = fail();
    std::fclose(file);
    return error;
  }
  if (std::fclose(file) != 0 || std::rename(beside.c_str(), path.c_str()) != 0) return fail();
  return {};
}

wavefront::Result<CapturedScene> ReadSceneFile(const std::string& path) {
  const auto bad = [&](const std::string& what) { return wavefront::Error{"The scene file " + path + " cannot be read: " + what + "."}; };
  std::error_code code;
  if (std::filesystem::is_directory(path, code)) return bad("it is a folder");
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) return bad(Reason());
  std::vector<std::byte> bytes;
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  if (code) return bad(code.message());
  bytes.resize(size);
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) return bad(std::ferror(file.get()) ? Reason() : "it changed while it was read");
  file.reset();
  return DecodeScene(bytes, path);
}

}  // namespace delegate
