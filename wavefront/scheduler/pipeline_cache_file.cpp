// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/pipeline_cache_file.h"

#include <unistd.h>

#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace wavefront {
namespace {

constexpr char kMagic[8] = {'h', 'd', 'W', 'P', 'i', 'p', '0', '1'};
struct Header {
  char magic[8];
  uint64_t bytes, checksum;
};

uint64_t Checksum(const std::vector<std::byte>& data) {  // FNV-1a
  uint64_t hash = 0xcbf29ce484222325ull;
  for (std::byte b : data) hash = (hash ^ static_cast<uint64_t>(b)) * 0x100000001b3ull;
  return hash;
}

}  // namespace

std::string PipelineCacheFile(const std::string& folder, const vulkan::DeviceInfo& info) {
  if (folder.empty()) return {};
  std::string name = "pipelines-" + info.name + "-" + info.driverName + "-" + info.driverVersion;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return folder + "/" + name;
}

std::vector<std::byte> ReadPipelineCache(const std::string& file) {
  std::error_code error;
  const uint64_t size = file.empty() ? 0 : std::filesystem::file_size(file, error);
  if (error || size <= sizeof(Header)) return {};
  std::ifstream stream(file, std::ios::binary);
  Header header{};
  if (!stream.read(reinterpret_cast<char*>(&header), sizeof(header))) return {};
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0 || header.bytes != size - sizeof(header)) return {};
  std::vector<std::byte> data(header.bytes);
  if (!stream.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size()))) return {};
  return Checksum(data) == header.checksum ? data : std::vector<std::byte>();
}

bool WritePipelineCache(const std::string& file, const std::vector<std::byte>& data) {
  if (file.empty() || data.empty()) return false;
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(file).parent_path(), error);
  if (error) return false;
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.bytes = data.size();
  header.checksum = Checksum(data);
  std::string part = file + ".part-XXXXXX";
  const int descriptor = mkstemp(part.data());
  if (descriptor < 0) return false;
  std::FILE* stream = fdopen(descriptor, "wb");
  bool isWritten = std::fwrite(&header, sizeof(header), 1, stream) == 1 &&
                   std::fwrite(data.data(), 1, data.size(), stream) == data.size();
  isWritten = std::fclose(stream) == 0 && isWritten;
  if (isWritten) std::filesystem::rename(part, file, error);
  if (isWritten && !error) return true;
  std::filesystem::remove(part, error);
  return false;
}

}  // namespace wavefront
