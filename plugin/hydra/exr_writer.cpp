// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/exr_writer.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace hydra {
namespace {

// Bytes in the file's order, which is that of every machine that OpenUSD runs on: little-endian.
class Bytes {
 public:
  template <typename T>
  void Put(T value) {
    const auto* from = reinterpret_cast<const char*>(&value);
    data_.insert(data_.end(), from, from + sizeof(T));
  }
  void Text(const std::string& text) { data_.insert(data_.end(), text.begin(), text.end()); }
  void Name(const std::string& name) {
    Text(name);
    Put<char>(0);
  }
  void Attribute(const std::string& name, const std::string& type, const Bytes& value) {
    Name(name);
    Name(type);
    Put(static_cast<int32_t>(value.data_.size()));
    data_.insert(data_.end(), value.data_.begin(), value.data_.end());
  }
  const std::vector<char>& data() const { return data_; }

 private:
  std::vector<char> data_;
};

template <typename... T>
Bytes Values(T... values) {
  Bytes bytes;
  (bytes.Put(values), ...);
  return bytes;
}

Bytes Header(const ExrImage& image) {
  constexpr int32_t kMagic = 20000630, kVersion = 2, kLongNames = 0x400, kFloat = 2;
  Bytes header;
  header.Put(kMagic);
  header.Put(kVersion | kLongNames);
  Bytes channels;
  for (const auto& [name, values] : image.channels) {
    channels.Name(name);
    channels.Put(kFloat);
    channels.Put<int32_t>(0);  // not perceptually linear, and reserved
    channels.Put<int32_t>(1);  // sampling
    channels.Put<int32_t>(1);
  }
  channels.Put<char>(0);
  header.Attribute("channels", "chlist", channels);
  header.Attribute("compression", "compression", Values<char>(0));
  const auto window = [](int x, int y, uint32_t width, uint32_t height) {
    return Values<int32_t>(x, y, x + static_cast<int32_t>(width) - 1, y + static_cast<int32_t>(height) - 1);
  };
  header.Attribute("dataWindow", "box2i", window(image.x, image.y, image.width, image.height));
  header.Attribute("displayWindow", "box2i",
                   window(0, 0, image.fullWidth ? image.fullWidth : image.width,
                          image.fullHeight ? image.fullHeight : image.height));
  header.Attribute("lineOrder", "lineOrder", Values<char>(0));
  header.Attribute("pixelAspectRatio", "float", Values(image.pixelAspectRatio));
  header.Attribute("screenWindowCenter", "v2f", Values(0.0f, 0.0f));
  header.Attribute("screenWindowWidth", "float", Values(1.0f));
  // CIE xy of lin_rec709, the rendering space.
  header.Attribute("chromaticities", "chromaticities",
                   Values(0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f));
  for (const auto& [name, text] : image.text) {
    Bytes value;
    value.Text(text);
    header.Attribute(name, "string", value);
  }
  for (const auto& [name, matrix] : image.matrices) {
    Bytes value;
    for (const auto& row : matrix.m)
      for (const double v : row) value.Put(static_cast<float>(v));
    header.Attribute(name, "m44f", value);
  }
  header.Put<char>(0);
  return header;
}

bool WriteAll(std::FILE* file, const ExrImage& image) {
  const Bytes header = Header(image);
  const size_t lineBytes = image.channels.size() * image.width * sizeof(float);
  const size_t chunk = 2 * sizeof(int32_t) + lineBytes;
  bool good = std::fwrite(header.data().data(), 1, header.data().size(), file) == header.data().size();
  for (uint64_t row = 0; row < image.height && good; ++row) {
    const uint64_t offset = header.data().size() + image.height * sizeof(uint64_t) + row * chunk;
    good = std::fwrite(&offset, sizeof(offset), 1, file) == 1;
  }
  for (uint32_t row = 0; row < image.height && good; ++row) {
    const int32_t head[2] = {image.y + static_cast<int32_t>(row), static_cast<int32_t>(lineBytes)};
    good = std::fwrite(head, sizeof(head), 1, file) == 1;
    for (const auto& [name, values] : image.channels)
      good = good && std::fwrite(&values[size_t{row} * image.width], sizeof(float), image.width, file) == image.width;
  }
  return good;
}

}  // namespace

wavefront::Status WriteExr(const std::string& path, ExrImage image) {
  for (const auto& [name, values] : image.channels)
    if (values.size() != size_t{image.width} * image.height)
      return wavefront::Error{"The channel " + name + " does not have the image's size."};
  if (image.channels.empty() || image.width == 0 || image.height == 0)
    return wavefront::Error{"There is nothing to write to " + path + "."};
  // The format wants the channels in order of their names.
  std::sort(image.channels.begin(), image.channels.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  const std::string beside = path + "." + std::to_string(getpid()) + ".part";
  std::FILE* file = std::fopen(beside.c_str(), "wb");
  if (!file) return wavefront::Error{"The file " + path + " cannot be written: " + std::strerror(errno) + "."};
  bool good = WriteAll(file, image);
  good = std::fclose(file) == 0 && good;
  if (good) good = std::rename(beside.c_str(), path.c_str()) == 0;
  if (good) return {};
  std::remove(beside.c_str());
  return wavefront::Error{"The file " + path + " could not be written whole."};
}

}  // namespace hydra
