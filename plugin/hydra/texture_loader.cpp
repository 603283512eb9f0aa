// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/texture_loader.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/tf/pathUtils.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hio/image.h>
#include <pxr/imaging/hio/types.h>
#include <pxr/usd/sdf/layer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <set>

#include "delegate/texture_tiles.h"

namespace hydra {
namespace {

constexpr float kHalfMax = 65504;

enum class Encoding { AsIs, Srgb, Gamma22, Gamma18, Unknown };

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// The colour spaces that need no colour library, by the names of USD, OpenColorIO's configurations and MaterialX. The
// rendering space is linear Rec. 709.
constexpr const char* kAsIs[] = {"raw", "data", "none", "linear", "identity", "lin_rec709", "lin_rec709_scene", "lin_srgb",
                                 "linear rec.709 (srgb)", "scene_linear"};

Encoding EncodingOf(const std::string& colorSpace) {
  const std::string name = Lower(colorSpace);
  for (const char* known : kAsIs)
    if (name == known) return Encoding::AsIs;
  for (const char* known : {"srgb", "srgb_texture", "srgb_rec709_scene", "srgb - texture", "srgb_tx"})
    if (name == known) return Encoding::Srgb;
  if (name == "gamma22" || name == "g22_rec709") return Encoding::Gamma22;
  if (name == "gamma18" || name == "g18_rec709") return Encoding::Gamma18;
  return Encoding::Unknown;
}

// sRGB as OpenColorIO has it, for the same texels as the Python host's: IEC 61966-2-1's power, and the line that touches it
// (ExponentWithLinearTransform, gamma 2.4, offset 0.055), where the standard rounds slope and break (12.92, 0.04045).
float Decode(Encoding encoding, float value) {
  const double v = value, positive = std::max(v, 0.0);
  switch (encoding) {
    case Encoding::Srgb: {
      constexpr double kGamma = 2.4, kOffset = 0.055, kBreak = kOffset / (kGamma - 1);
      static const double slope = std::pow((kBreak + kOffset) / (1 + kOffset), kGamma) / kBreak;
      return static_cast<float>(v <= kBreak ? v * slope : std::pow((v + kOffset) / (1 + kOffset), kGamma));
    }
    case Encoding::Gamma22: return static_cast<float>(std::pow(positive, 2.2));
    case Encoding::Gamma18: return static_cast<float>(std::pow(positive, 1.8));
    default: return value;
  }
}

float Finite(float v) {
  constexpr float kMax = std::numeric_limits<float>::max();
  return std::isnan(v) ? 0 : std::clamp(v, -kMax, kMax);
}

uint16_t ClippedHalf(float v) {
  if (std::isnan(v)) v = 0;
  return GfHalf(std::clamp(v, -kHalfMax, kHalfMax)).bits();
}

// Component i of the file's pixels, whatever their type.
class PixelReader {
 public:
  PixelReader(const std::vector<uint8_t>& bytes, HioType type) : bytes_(bytes.data()), type_(type) {}
  float operator[](size_t i) const {
    switch (type_) {
      case HioTypeUnsignedByte:
      case HioTypeUnsignedByteSRGB: return bytes_[i] / 255.0f;
      case HioTypeSignedByte: return std::max(static_cast<int8_t>(bytes_[i]) / 127.0f, -1.0f);
      case HioTypeUnsignedShort: return At<uint16_t>(i) / 65535.0f;
      case HioTypeSignedShort: return std::max(At<int16_t>(i) / 32767.0f, -1.0f);
      case HioTypeUnsignedInt: return static_cast<float>(At<uint32_t>(i) / 4294967295.0);
      case HioTypeInt: return static_cast<float>(At<int32_t>(i) / 2147483647.0);
      case HioTypeHalfFloat: {
        GfHalf half;
        half.setBits(At<uint16_t>(i));
        return half;
      }
      case HioTypeFloat: return At<float>(i);
      case HioTypeDouble: return static_cast<float>(At<double>(i));
      default: return 0;
    }
  }

  template <typename T>
  T As(size_t i) const {
    return At<T>(i);
  }

 private:
  template <typename T>
  T At(size_t i) const {
    T value;
    std::memcpy(&value, bytes_ + i * sizeof(T), sizeof(T));
    return value;
  }
  const uint8_t* bytes_;
  HioType type_;
};

bool IsByte(HioType type) { return type == HioTypeUnsignedByte || type == HioTypeUnsignedByteSRGB; }

// UsdUVTexture's sourceColorSpace: "auto" means sRGB for 8-bit images of three or more channels, else raw.
std::string ResolveSpace(const delegate::TextureKey& texture, HioType type, int channels) {
  if (!texture.isColor) return "raw";
  if (!texture.colorSpace.empty() && Lower(texture.colorSpace) != "auto") return texture.colorSpace;
  return IsByte(type) && channels >= 3 ? "sRGB" : "raw";
}

// Grey fills red, green and blue; a second channel is alpha. `source(channel)` reads, `one` is opaque.
template <typename Out, typename Source>
void Expand(int channels, Out* rgba, Out one, Source source) {
  const bool grey = channels <= 2;
  for (int c = 0; c < 3; ++c) rgba[c] = source(grey ? 0 : c);
  rgba[3] = channels == 4 ? source(3) : channels == 2 ? source(1) : one;
}

template <typename Out, typename Source>
std::vector<uint8_t> Texels(size_t count, int channels, Out one, Source source) {
  std::vector<uint8_t> texels(count * 4 * sizeof(Out));
  for (size_t i = 0; i < count; ++i) {
    Out rgba[4];
    Expand<Out>(channels, rgba, one, [&](int c) { return source(i, c); });
    std::memcpy(&texels[i * sizeof rgba], rgba, sizeof rgba);
  }
  return texels;
}

wavefront::TextureData Convert(const std::string& name, const HioImage::StorageSpec& image,
                               const std::vector<uint8_t>& pixels, Encoding encoding) {
  wavefront::TextureData data;
  data.name = name;
  data.width = static_cast<uint32_t>(image.width);
  data.height = static_cast<uint32_t>(image.height);
  const int channels = HioGetComponentCount(image.format);
  const HioType type = HioGetHioType(image.format);
  const size_t count = size_t{data.width} * data.height;
  if (IsByte(type) && encoding == Encoding::AsIs) {
    data.format = wavefront::TexelFormat::Rgba8Unorm;
    data.texels.resize(count * 4);
    for (size_t i = 0; i < count; ++i)
      Expand<uint8_t>(channels, &data.texels[i * 4], 255,
                      [&](int c) { return pixels[i * static_cast<size_t>(channels) + static_cast<size_t>(c)]; });
    return data;
  }
  const bool isFloat = type == HioTypeFloat || type == HioTypeDouble;
  const bool isWhole = type == HioTypeUnsignedShort && encoding == Encoding::AsIs;
  std::array<float, 256> table;
  for (size_t v = 0; v < 256; ++v) table[v] = Decode(encoding, static_cast<float>(v) / 255.0f);
  const PixelReader components(pixels, type);
  const auto decoded = [&](size_t pixel, int c) {
    const bool isAlpha = c == 3 || (channels == 2 && c == 1);
    const size_t at = pixel * static_cast<size_t>(channels) + static_cast<size_t>(c);
    if (isAlpha) return components[at];
    return IsByte(type) ? table[pixels[at]] : Decode(encoding, components[at]);
  };
  if (isWhole) {
    data.format = wavefront::TexelFormat::Rgba16Unorm;
    data.texels = Texels<uint16_t>(count, channels, 65535, [&](size_t pixel, int c) {
      return components.As<uint16_t>(pixel * static_cast<size_t>(channels) + static_cast<size_t>(c));
    });
    return data;
  }
  const auto half = [&](size_t pixel, int c) { return ClippedHalf(decoded(pixel, c)); };
  // Floats that are all halfs, as those of RGBE files are, take half the memory and lose nothing.
  bool isHalf = !isFloat;
  if (isFloat) {
    isHalf = true;
    for (size_t i = 0; i < count && isHalf; ++i) {
      for (int c = 0; c < std::min(channels, 4) && isHalf; ++c) {
        GfHalf value;
        value.setBits(half(i, c));
        isHalf = static_cast<float>(value) == decoded(i, c);
      }
    }
  }
  data.format = isHalf ? wavefront::TexelFormat::Rgba16Float : wavefront::TexelFormat::Rgba32Float;
  data.texels = isHalf ? Texels<uint16_t>(count, channels, ClippedHalf(1), half)
                       : Texels<float>(count, channels, 1.0f, [&](size_t pixel, int c) { return Finite(decoded(pixel, c)); });
  return data;
}

}  // namespace

std::vector<std::string> UnconvertedSpaces() { return {std::begin(kAsIs), std::end(kAsIs)}; }

wavefront::Result<TextureConverter> DecodeTexture(const std::string& path) {
  const HioImageSharedPtr image = HioImage::OpenForReading(path, 0, 0, HioImage::Raw, /*suppressErrors=*/true);
  if (!image) return wavefront::Error{"The file cannot be read as an image."};
  HioImage::StorageSpec spec;
  spec.width = image->GetWidth();
  spec.height = image->GetHeight();
  spec.depth = 1;
  spec.format = image->GetFormat();
  spec.flipped = true;  // row 0 at the bottom
  if (spec.width <= 0 || spec.height <= 0 || spec.width > 32768 || spec.height > 32768)
    return wavefront::Error{"The image's size " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                            " is not within 1..32768 a side."};
  if (spec.format == HioFormatInvalid || HioIsCompressed(spec.format))
    return wavefront::Error{"The image's pixel format is not supported."};
  const auto pixels = std::make_shared<std::vector<uint8_t>>(size_t(spec.width) * size_t(spec.height) *
                                                             HioGetDataSizeOfFormat(spec.format));
  spec.data = pixels->data();
  if (!image->Read(spec)) return wavefront::Error{"The image is damaged."};
  return TextureConverter([path, spec, pixels](const delegate::TextureKey& texture) {
    const std::string space =
        ResolveSpace(texture, HioGetHioType(spec.format), HioGetComponentCount(spec.format));
    const Encoding encoding = EncodingOf(space);
    using Texels = wavefront::Result<wavefront::TextureData>;
    if (encoding == Encoding::Unknown)
      return Texels(wavefront::Error{"The colour space \"" + space + "\" is unknown here."});
    return Texels(Convert(path, spec, *pixels, encoding));
  });
}

std::vector<std::string> AnchoredPatterns(const std::string& pattern) {
  std::set<std::string> anchored;
  for (const SdfLayerHandle& layer : SdfLayer::GetLoadedLayers()) {
    if (!layer || layer->IsAnonymous() || layer->GetRealPath().empty()) continue;
    std::string candidate = TfNormPath(TfStringCatPaths(TfGetPathName(layer->GetRealPath()), pattern));
    if (!anchored.count(candidate) && !delegate::FindTiles(candidate).empty()) anchored.insert(std::move(candidate));
  }
  return {anchored.begin(), anchored.end()};
}

}  // namespace hydra
